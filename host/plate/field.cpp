#include "host/plate/field.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace palpate::plate {
namespace {

using Eigen::Index;

std::pair<Index, double> place(double x_m, double length_m, Index n) {
    const double at = std::clamp(x_m / length_m, 0.0, 1.0) * static_cast<double>(n - 1);
    const Index below = std::min(static_cast<Index>(at), std::max<Index>(n - 2, 0));
    return {below, at - static_cast<double>(below)};
}

double linear(const Eigen::ArrayXXd& v, std::pair<Index, double> x, std::pair<Index, double> z) {
    const auto [i, a] = x;
    const auto [j, b] = z;
    const Index i1 = std::min(i + 1, v.rows() - 1), j1 = std::min(j + 1, v.cols() - 1);
    return (1.0 - b) * ((1.0 - a) * v(i, j) + a * v(i1, j)) + b * ((1.0 - a) * v(i, j1) + a * v(i1, j1));
}

/// Grid lines x(t) = t + c t (1 - t), t = i/(n - 1), over a side of 1, so that `wanted` is a line on this
/// grid and on the two coarser ones (MATH.md eq. 32). Slopes stay within 1 +- |c|, |c| <= 1/2 where it can be
/// had.
Eigen::ArrayXd moved_lines(Index n, double length_m, double wanted_m, int halvings) {
    Index step = 1;
    for (int k = 0; k < halvings && (n - 1) % (2 * step) == 0; ++k) step *= 2;
    const Index cells = (n - 1) / step;
    const double wanted = wanted_m / length_m, coarse = static_cast<double>(cells);
    const double node = std::clamp(std::round(wanted * coarse), 1.0, coarse - 1.0) / coarse;
    const double c = (wanted - node) / (node * (1.0 - node));
    Eigen::ArrayXd lines(n);
    for (Index i = 0; i < n; ++i) {
        const double t = static_cast<double>(i) / static_cast<double>(n - 1);
        lines(i) = length_m * (t + c * t * (1.0 - t));
    }
    lines(n - 1) = length_m;
    return lines;
}

Eigen::ArrayXd even_lines(Index n, double length_m) {
    Eigen::ArrayXd lines(n);
    for (Index i = 0; i < n; ++i) lines(i) = length_m * (static_cast<double>(i) / static_cast<double>(n - 1));
    return lines;
}

double harmonic(double a, double b) {
    return 2.0 / (1.0 / a + 1.0 / b);
}

/// D at a node and its harmonic means, from its four quarters.
struct Quarters {
    double mean, harmonic_x, harmonic_z;

    Quarters(const Sheet& sheet, double x_m, double z_m) {
        const double ex = BESIDE * sheet.size_m.x(), ez = BESIDE * sheet.size_m.y();
        const auto at = [&](double x, double z) {
            return sheet.rigidity_n_m(std::clamp(x, 0.0, sheet.size_m.x()),
                                      std::clamp(z, 0.0, sheet.size_m.y()));
        };
        const double ll = at(x_m - ex, z_m - ez), hl = at(x_m + ex, z_m - ez);
        const double lh = at(x_m - ex, z_m + ez), hh = at(x_m + ex, z_m + ez);
        mean = 0.25 * ((ll + hl) + (lh + hh));
        harmonic_x = harmonic(0.5 * (ll + lh), 0.5 * (hl + hh));
        harmonic_z = harmonic(0.5 * (ll + hl), 0.5 * (lh + hh));
    }
};

/// A jump is what two places a billionth of the plate apart differ by.
constexpr double JUMP = 1e-6;

void set_rigidity(Problem& problem, const Sheet& sheet, const Eigen::ArrayXd& x_m,
                  const Eigen::ArrayXd& z_m) {
    bool jumps = false;
    for (Index iz = 0; iz < z_m.size(); ++iz) {
        for (Index ix = 0; ix < x_m.size(); ++ix) {
            const Quarters d(sheet, x_m(ix), z_m(iz));
            const bool jump = d.harmonic_x < (1.0 - JUMP) * d.mean || d.harmonic_z < (1.0 - JUMP) * d.mean;
            problem.rigidity_n_m(ix, iz) = jump ? d.mean : sheet.rigidity_n_m(x_m(ix), z_m(iz));
            problem.harmonic_x_n_m(ix, iz) = jump ? d.harmonic_x : problem.rigidity_n_m(ix, iz);
            problem.harmonic_z_n_m(ix, iz) = jump ? d.harmonic_z : problem.rigidity_n_m(ix, iz);
            jumps = jumps || jump;
        }
    }
    if (jumps) return;
    problem.harmonic_x_n_m.resize(0, 0);
    problem.harmonic_z_n_m.resize(0, 0);
}

Eigen::ArrayXXd at_nodes(const Field& field, const Eigen::ArrayXd& x_m, const Eigen::ArrayXd& z_m) {
    if (!field) return {};
    Eigen::ArrayXXd values(x_m.size(), z_m.size());
    for (Index iz = 0; iz < z_m.size(); ++iz) {
        for (Index ix = 0; ix < x_m.size(); ++ix) values(ix, iz) = field(x_m(ix), z_m(iz));
    }
    return values;
}

}  // namespace

Field sampled(Eigen::ArrayXXd values, const Eigen::Vector2d& size_m, Sampling sampling) {
    if (values.size() == 0) throw std::invalid_argument("a field without values");
    return [values = std::move(values), size_m, sampling](double x_m, double z_m) {
        const auto x = place(x_m, size_m.x(), values.rows());
        const auto z = place(z_m, size_m.y(), values.cols());
        if (sampling == Sampling::linear) return linear(values, x, z);
        const auto near = [](std::pair<Index, double> p, Index n) {
            return std::min(p.first + (p.second >= 0.5 ? 1 : 0), n - 1);
        };
        return values(near(x, values.rows()), near(z, values.cols()));
    };
}

Problem on_grid(const Sheet& sheet, Index nx, Index nz, const std::optional<NodeAt>& node_at) {
    Problem problem;
    problem.size_m = sheet.size_m;
    problem.poisson = sheet.poisson;
    problem.edges = sheet.edges;
    const Eigen::ArrayXd even_x_m = even_lines(nx, sheet.size_m.x()),
                         even_z_m = even_lines(nz, sheet.size_m.y());
    Eigen::ArrayXd x_m = even_x_m, z_m = even_z_m;
    if (node_at) {
        x_m = moved_lines(nx, sheet.size_m.x(), node_at->at_m.x(), node_at->halvings);
        z_m = moved_lines(nz, sheet.size_m.y(), node_at->at_m.y(), node_at->halvings);
    }
    if ((x_m != even_x_m).any() || (z_m != even_z_m).any()) {
        problem.lines_x_m = x_m;
        problem.lines_z_m = z_m;
    }
    problem.rigidity_n_m.resize(nx, nz);
    problem.harmonic_x_n_m.resize(nx, nz);
    problem.harmonic_z_n_m.resize(nx, nz);
    set_rigidity(problem, sheet, x_m, z_m);
    problem.foundation_n_per_m3 = at_nodes(sheet.foundation_n_per_m3, x_m, z_m);
    problem.poisson_at_nodes = at_nodes(sheet.poisson_at, x_m, z_m);
    if (sheet.solid) problem.solid = at_nodes(sheet.solid, x_m, z_m) > 0.0;
    return problem;
}

Node nearest_node(const Problem& problem, const Eigen::Vector2d& at_m) {
    const auto nearest = [](const Eigen::ArrayXd& lines_m, double wanted_m) {
        Index best = 0;
        (lines_m - wanted_m).abs().minCoeff(&best);
        return best;
    };
    const auto lines = [](const Eigen::ArrayXd& lines_m, Index n, double length_m) {
        return lines_m.size() != 0 ? lines_m : even_lines(n, length_m);
    };
    return {nearest(lines(problem.lines_x_m, problem.rigidity_n_m.rows(), problem.size_m.x()), at_m.x()),
            nearest(lines(problem.lines_z_m, problem.rigidity_n_m.cols(), problem.size_m.y()), at_m.y())};
}

}  // namespace palpate::plate
