#include "host/plate/loads.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace palpate::plate {
namespace {

using Eigen::Index;

Eigen::ArrayXd all_lines(const Eigen::ArrayXd& lines_m, Index n, double length_m) {
    if (lines_m.size() != 0) return lines_m;
    Eigen::ArrayXd even_m(n);
    for (Index i = 0; i < n; ++i)
        even_m(i) = length_m * (static_cast<double>(i) / static_cast<double>(n - 1));
    return even_m;
}

/// Lagrange weights of the four lines around a place.
struct LineWeights {
    Index first;
    std::array<double, 4> w{};

    LineWeights(const Eigen::ArrayXd& lines_m, double at_m, Spread spread = Spread::cubic) {
        const auto above = std::upper_bound(lines_m.begin(), lines_m.end(), at_m) - lines_m.begin();
        first = std::clamp<Index>(above - 2, 0, lines_m.size() - 4);
        if (spread == Spread::linear) {
            const Index low = std::clamp<Index>(above - 1, 0, lines_m.size() - 2);
            const double share = (at_m - lines_m(low)) / (lines_m(low + 1) - lines_m(low));
            w[static_cast<std::size_t>(low - first)] = 1.0 - share;
            w[static_cast<std::size_t>(low + 1 - first)] = share;
            return;
        }
        for (std::size_t a = 0; a < 4; ++a) {
            w[a] = 1.0;
            for (std::size_t b = 0; b < 4; ++b) {
                if (a == b) continue;
                const double xa = lines_m(first + static_cast<Index>(a)),
                             xb = lines_m(first + static_cast<Index>(b));
                w[a] *= (at_m - xb) / (xa - xb);
            }
        }
    }
};

template <typename Visit>
void for_nodes_around(const GridLines& lines, const Eigen::Vector2d& at_m, Spread spread, Visit visit) {
    const LineWeights x(lines.x_m, at_m.x(), spread), z(lines.z_m, at_m.y(), spread);
    for (std::size_t b = 0; b < 4; ++b) {
        for (std::size_t a = 0; a < 4; ++a) {
            const Index node =
                x.first + static_cast<Index>(a) + lines.x_m.size() * (z.first + static_cast<Index>(b));
            visit(static_cast<std::size_t>(node), x.w[a] * z.w[b]);
        }
    }
}

double spacing_at(const Eigen::ArrayXd& lines_m, double at_m) {
    const LineWeights weights(lines_m, at_m);
    return (lines_m(weights.first + 3) - lines_m(weights.first)) / 3.0;
}

}  // namespace

GridLines::GridLines(const Problem& problem)
    : x_m(all_lines(problem.lines_x_m, problem.rigidity_n_m.rows(), problem.size_m.x())),
      z_m(all_lines(problem.lines_z_m, problem.rigidity_n_m.cols(), problem.size_m.y())) {}

void add_force(const GridLines& lines, const Eigen::Vector2d& at_m, double force_n,
               std::span<double> at_nodes_n, Spread spread) {
    for_nodes_around(lines, at_m, spread,
                     [&](std::size_t node, double weight) { at_nodes_n[node] += weight * force_n; });
}

double deflection_at(const GridLines& lines, const Eigen::Vector2d& at_m,
                     std::span<const double> at_nodes_m) {
    double sum = 0.0;
    for_nodes_around(lines, at_m, Spread::cubic,
                     [&](std::size_t node, double weight) { sum += weight * at_nodes_m[node]; });
    return sum;
}

std::vector<double> unit_pressure(const GridLines& lines, const Eigen::Vector2d& at_m, double radius_m,
                                  Spread spread) {
    std::vector<double> force_n(static_cast<std::size_t>(lines.x_m.size() * lines.z_m.size()), 0.0);
    if (!(radius_m > 0.0)) {
        add_force(lines, at_m, 1.0, force_n, spread);
        return force_n;
    }
    const double h_m = std::min(spacing_at(lines.x_m, at_m.x()), spacing_at(lines.z_m, at_m.y()));
    const auto rings = std::clamp<Index>(static_cast<Index>(std::ceil(2.0 * radius_m / h_m)), 8, 64);
    const Index rays = 6 * rings;
    for (Index i = 0; i < rings; ++i) {  // of equal area
        const double r_m = radius_m * std::sqrt((static_cast<double>(i) + 0.5) / static_cast<double>(rings));
        for (Index k = 0; k < rays; ++k) {
            const double angle =
                2.0 * std::numbers::pi * (static_cast<double>(k) + 0.5) / static_cast<double>(rays);
            add_force(lines, at_m + r_m * Eigen::Vector2d(std::cos(angle), std::sin(angle)),
                      1.0 / static_cast<double>(rings * rays), force_n, spread);
        }
    }
    return force_n;
}

std::vector<Node> touched_nodes(const GridLines& lines, const Eigen::Vector2d& at_m, double radius_m) {
    std::vector<Node> nodes;
    Node nearest{};
    (lines.x_m - at_m.x()).abs().minCoeff(&nearest.ix);
    (lines.z_m - at_m.y()).abs().minCoeff(&nearest.iz);
    for (Index iz = 0; iz < lines.z_m.size(); ++iz) {
        for (Index ix = 0; ix < lines.x_m.size(); ++ix) {
            const double distance_m = std::hypot(lines.x_m(ix) - at_m.x(), lines.z_m(iz) - at_m.y());
            if (distance_m <= radius_m * (1.0 + 1e-9)) nodes.push_back({ix, iz});
        }
    }
    if (nodes.empty()) nodes.push_back(nearest);
    return nodes;
}

}  // namespace palpate::plate
