/// Loads and answers to test bounds with.
#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "host/plate/bounds/bounds.hpp"
#include "host/plate/plate.hpp"

namespace palpate::plate::loads {

using Force = std::vector<double>;  ///< at the nodes, x fastest; sum 1

[[nodiscard]] inline std::span<const double> span_of(const Eigen::ArrayXXd& field) {
    return {field.data(), static_cast<std::size_t>(field.size())};
}

[[nodiscard]] inline Force point(Eigen::Index nx, Eigen::Index nz, const Node& node) {
    Force force(static_cast<std::size_t>(nx * nz), 0.0);
    force[static_cast<std::size_t>(node.ix + nx * node.iz)] = 1.0;
    return force;
}

/// Even over the nodes of a disc; places and radius over the side of the n x n square.
[[nodiscard]] inline Force disc(Eigen::Index n, double at_x, double at_z, double radius) {
    Force force(static_cast<std::size_t>(n * n), 0.0);
    double count = 0.0;
    for (Eigen::Index iz = 0; iz < n; ++iz) {
        for (Eigen::Index ix = 0; ix < n; ++ix) {
            const double x = static_cast<double>(ix) / static_cast<double>(n - 1) - at_x;
            const double z = static_cast<double>(iz) / static_cast<double>(n - 1) - at_z;
            if (x * x + z * z > radius * radius * (1.0 + 1e-9)) continue;
            force[static_cast<std::size_t>(ix + n * iz)] = 1.0;
            count += 1.0;
        }
    }
    for (double& f : force) f /= count;
    return force;
}

/// Load-weighted mean deflection, by factorisation.
[[nodiscard]] inline double compliance(const Problem& problem, const Force& force) {
    std::vector<double> w(force.size());
    Plate(problem).solve(force, w);
    double sum = 0.0;
    for (std::size_t i = 0; i < w.size(); ++i) sum += force[i] * w[i];
    return sum;
}

[[nodiscard]] inline Bracket bracket_at(const Bounds& bounds, const Problem& problem, Rung rung,
                                        Bounds::Scratch& scratch) {
    return bounds.bracket(span_of(problem.rigidity_n_m), span_of(problem.foundation_n_per_m3),
                          {.relative_error = 0.0, .last = rung}, scratch);
}

}  // namespace palpate::plate::loads
