/// Forces on plates to test with, and what comes of them.
#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "host/plate/solver.hpp"
#include "tests/host/plate/fields.hpp"

namespace palpate::plate::forces {

struct Answer {
    Report report;
    std::vector<double> deflection_m;
};

/// 1 N at the centre node.
[[nodiscard]] inline std::vector<double> at_centre(const Problem& problem) {
    const Eigen::Index nx = problem.rigidity_n_m.rows(), nz = problem.rigidity_n_m.cols();
    std::vector<double> force_n(static_cast<std::size_t>(nx * nz), 0.0);
    force_n[static_cast<std::size_t>(nx / 2 + nx * (nz / 2))] = 1.0;
    return force_n;
}

/// In [-0.2, 0.8) N at every node, the edges' too.
[[nodiscard]] inline std::vector<double> random(const Problem& problem, std::uint64_t seed) {
    fields::Random stream(seed);
    std::vector<double> force_n(static_cast<std::size_t>(problem.rigidity_n_m.size()));
    for (double& force : force_n) force = stream.next() - 0.2;
    return force_n;
}

[[nodiscard]] inline Answer solve(const Solver& solver, const std::vector<double>& force_n) {
    Answer answer{{}, std::vector<double>(force_n.size(), -1.0)};
    answer.report = solver.solve(force_n, answer.deflection_m);
    return answer;
}

[[nodiscard]] inline Answer solve(Method method, const Problem& problem, const std::vector<double>& force_n,
                                  const Options& options = {}) {
    return solve(*make_solver(method, problem, options), force_n);
}

/// |a - b|_2/|b|_2.
[[nodiscard]] inline double error(std::span<const double> a, std::span<const double> b) {
    const auto n = static_cast<Eigen::Index>(b.size());
    const Eigen::Map<const Eigen::VectorXd> at_a(a.data(), n), at_b(b.data(), n);
    return (at_a - at_b).norm() / at_b.norm();
}

}  // namespace palpate::plate::forces
