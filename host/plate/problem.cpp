#include "host/plate/problem.hpp"

#include <cmath>
#include <cstdio>
#include <limits>

namespace palpate::plate {
namespace {

using Eigen::ArrayXXd;
using Eigen::Index;

constexpr double RIGIDITY_SPAN_MAX = 1e15;  ///< largest over smallest; beyond it double cannot hold both
constexpr double LINE_RATIO_MAX = 4.0;      ///< of neighbouring spacings
constexpr double LEAST = std::numeric_limits<double>::min();
constexpr double MOST = std::numeric_limits<double>::max();

using Words = std::optional<std::string>;

std::string grid_text(Index nx, Index nz) {
    return std::to_string(nx) + " x " + std::to_string(nz);
}

Words bad_size(const std::string& name, Index nx, Index nz, const Problem& problem) {
    if (nx == 0 || nz == 0) return std::nullopt;
    if (nx == problem.rigidity_n_m.rows() && nz == problem.rigidity_n_m.cols()) return std::nullopt;
    return name + " of " + grid_text(nx, nz) + " nodes; must be empty or match the rigidity's " +
           grid_text(problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols());
}

struct Range {
    double least, most;
    const char* wanted;
};

/// The first node of a field that is out of range; NaN is. Nodes without plate do not count.
Words bad_node(const ArrayXXd& field, const Mask& solid, const std::string& name, const Range& range) {
    for (Index ix = 0; ix < field.rows(); ++ix) {
        for (Index iz = 0; iz < field.cols(); ++iz) {
            if (solid.size() != 0 && !solid(ix, iz)) continue;
            if (field(ix, iz) >= range.least && field(ix, iz) <= range.most) continue;
            return name + " " + number_text(field(ix, iz)) + " at " + node_text(ix, iz) + "; " + range.wanted;
        }
    }
    return std::nullopt;
}

Words bad_sizes(const Problem& p) {
    const auto is_length = [](double m) { return m >= 1e-15 && m <= 1e15; };
    if (!is_length(p.size_m.x()) || !is_length(p.size_m.y())) {
        return "plate sides " + number_text(p.size_m.x()) + " x " + number_text(p.size_m.y()) +
               " m; each must be a positive length";
    }
    if (p.rigidity_n_m.rows() < 5 || p.rigidity_n_m.cols() < 5) {
        return "grid of " + grid_text(p.rigidity_n_m.rows(), p.rigidity_n_m.cols()) +
               " nodes; needs at least 5 x 5";
    }
    const auto bad = [&](const char* name, const auto& field) {
        return bad_size(name, field.rows(), field.cols(), p);
    };
    if (auto words = bad("foundation", p.foundation_n_per_m3)) return words;
    if (auto words = bad("Poisson's ratio", p.poisson_at_nodes)) return words;
    if (auto words = bad("harmonic mean across x", p.harmonic_x_n_m)) return words;
    if (auto words = bad("harmonic mean across z", p.harmonic_z_n_m)) return words;
    if ((p.harmonic_x_n_m.size() == 0) != (p.harmonic_z_n_m.size() == 0))
        return "one harmonic mean without the other; give both or neither";
    return bad("mask", p.solid);
}

Words bad_lines(const Eigen::ArrayXd& lines_m, Index n, double length_m, const std::string& axis) {
    if (lines_m.size() == 0) return std::nullopt;
    const std::string name = "grid lines along " + axis;
    if (lines_m.size() != n)
        return name + ": " + std::to_string(lines_m.size()) + "; needs " + std::to_string(n);
    if (!(std::fabs(lines_m(0)) <= 1e-12 * length_m) ||
        !(std::fabs(lines_m(n - 1) - length_m) <= 1e-12 * length_m)) {
        return name + " must run from 0 to the plate's side";
    }
    for (Index i = 1; i < n; ++i) {
        const double h = lines_m(i) - lines_m(i - 1);
        if (!(h > 0.0)) return name + " must ascend";
        if (i == 1) continue;
        const double ratio = h / (lines_m(i - 1) - lines_m(i - 2));
        if (!(ratio <= LINE_RATIO_MAX && ratio >= 1.0 / LINE_RATIO_MAX))
            return name + ": neighbouring spacings differ by more than a factor of " +
                   number_text(LINE_RATIO_MAX);
    }
    return std::nullopt;
}

Words bad_fields(const Problem& p) {
    const Range positive{LEAST, MOST, "must be positive and finite"};
    const Range ratio{std::nextafter(-1.0, 0.0), std::nextafter(0.5, 0.0), "must lie between -1 and 0.5"};
    if (auto words = bad_node(p.rigidity_n_m, p.solid, "rigidity", positive)) return words;
    if (auto words = bad_node(p.foundation_n_per_m3, p.solid, "foundation",
                              {0.0, MOST, "must be finite and not negative"})) {
        return words;
    }
    if (auto words = bad_node(p.poisson_at_nodes, {}, "Poisson's ratio", ratio)) return words;
    if (!(p.poisson > -1.0 && p.poisson < 0.5))
        return "Poisson's ratio " + number_text(p.poisson) + "; " + ratio.wanted;
    if (auto words = bad_node(p.harmonic_x_n_m, p.solid, "harmonic mean across x", positive)) return words;
    if (auto words = bad_node(p.harmonic_z_n_m, p.solid, "harmonic mean across z", positive)) return words;
    return std::nullopt;
}

Words bad_span(const Problem& p) {
    double least = MOST, most = 0.0;
    for (Index iz = 0; iz < p.rigidity_n_m.cols(); ++iz) {
        for (Index ix = 0; ix < p.rigidity_n_m.rows(); ++ix) {
            if (p.solid.size() != 0 && !p.solid(ix, iz)) continue;
            least = std::min(least, p.rigidity_n_m(ix, iz));
            most = std::max(most, p.rigidity_n_m(ix, iz));
        }
    }
    if (most == 0.0) return "no node has any plate";
    if (most / least > RIGIDITY_SPAN_MAX)
        return "rigidity spans more than 15 decades; clamp the softest nodes";
    return std::nullopt;
}

/// Three points off one line, or an edge with a slope, or a foundation must hold the plate.
Words not_held(const Problem& p) {
    if (p.foundation_n_per_m3.size() != 0 && (p.foundation_n_per_m3 > 0.0).any()) return std::nullopt;
    int clamped = 0, supported = 0;
    for (const Edge edge : p.edges) {
        clamped += edge == Edge::clamped;
        supported += edge == Edge::supported;
    }
    if (clamped > 0 || supported > 1) return std::nullopt;
    return "nothing keeps the plate from tilting; clamp an edge, support two, or lay it on a foundation";
}

}  // namespace

std::optional<std::string> problem_with(const Problem& problem) {
    if (auto words = bad_sizes(problem)) return words;
    if (auto words = bad_lines(problem.lines_x_m, problem.rigidity_n_m.rows(), problem.size_m.x(), "x"))
        return words;
    if (auto words = bad_lines(problem.lines_z_m, problem.rigidity_n_m.cols(), problem.size_m.y(), "z"))
        return words;
    if (auto words = bad_fields(problem)) return words;
    if (auto words = bad_span(problem)) return words;
    return not_held(problem);
}

const Problem& require_problem(const Problem& problem) {
    if (const auto words = problem_with(problem)) throw std::invalid_argument(*words);
    return problem;
}

std::string number_text(double value, int digits) {
    std::array<char, 32> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%.*g", digits, value);
    return buffer.data();
}

std::string node_text(Index ix, Index iz) {
    return "node (" + std::to_string(ix) + ", " + std::to_string(iz) + ")";
}

}  // namespace palpate::plate
