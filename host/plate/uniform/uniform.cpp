#include "host/plate/uniform/uniform.hpp"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "host/plate/uniform/lobatto.hpp"

namespace palpate::plate {
namespace {

/// 1/(8 c0)^2, c0 the compliance without a foundation: flattened() is 1 at both ends of the axis.
constexpr double CROSSOVER = 496.0;

constexpr std::array<Interval, 6> INTERVALS{
    {{0.0, 4.0}, {4.0, 8.0}, {8.0, 16.0}, {16.0, 24.0}, {24.0, 48.0}, {48.0, 96.0}}};
constexpr std::size_t N_TABULATED =
    4;  ///< intervals with continuum values; beyond them the edge is out of reach

using Values = std::array<double, N_LOBATTO>;

constexpr std::array<Values, N_TABULATED> CONTINUUM{{
#include "host/plate/uniform/uniform_table.inc"
}};

std::optional<std::size_t> interval_of(double side_over_l) {
    for (std::size_t k = 0; k < INTERVALS.size(); ++k) {
        if (side_over_l <= INTERVALS[k].end) return k;
    }
    return std::nullopt;
}

void require_ratio(double side_over_l) {
    if (!(side_over_l >= 0.0)) throw std::invalid_argument("side over l must not be negative");
}

Values solve_interval(Eigen::Index n, const Interval& interval) {
    const Values points = lobatto_points(interval);
    Values values{};
    for (std::size_t j = 0; j < N_LOBATTO; ++j) {
        values[j] = flattened(Plate(uniform_square(n, points[j])).centre_compliance_m_per_n(), points[j]);
    }
    return values;
}

}  // namespace

double flattened(double compliance, double side_over_l) {
    const double s2 = side_over_l * side_over_l;
    return compliance * 8.0 * std::sqrt(s2 * s2 + CROSSOVER);
}

double unflattened(double flat, double side_over_l) {
    const double s2 = side_over_l * side_over_l;
    return flat / (8.0 * std::sqrt(s2 * s2 + CROSSOVER));
}

double uniform_square_compliance(double side_over_l) {
    require_ratio(side_over_l);
    const auto k = interval_of(side_over_l);
    if (!k || *k >= N_TABULATED) return 1.0 / (8.0 * side_over_l * side_over_l);
    return unflattened(interpolate(INTERVALS[*k], CONTINUUM[*k], side_over_l), side_over_l);
}

Problem uniform_square(Eigen::Index n, double side_over_l) {
    Problem problem;
    problem.size_m = {1.0, 1.0};
    problem.rigidity_n_m = Eigen::ArrayXXd::Ones(n, n);
    const double s2 = side_over_l * side_over_l;
    problem.foundation_n_per_m3 = Eigen::ArrayXXd::Constant(n, n, s2 * s2);
    return problem;
}

double uniform_square_grid_compliance(Eigen::Index n, double side_over_l) {
    require_ratio(side_over_l);
    const auto k = interval_of(side_over_l);
    if (!k) return Plate(uniform_square(n, side_over_l)).centre_compliance_m_per_n();
    // A pure function's memory: results do not depend on it.
    thread_local std::map<Eigen::Index, std::array<std::optional<Values>, INTERVALS.size()>> solved;
    std::optional<Values>& values = solved[n][*k];
    if (!values) values = solve_interval(n, INTERVALS[*k]);
    return unflattened(interpolate(INTERVALS[*k], *values, side_over_l), side_over_l);
}

}  // namespace palpate::plate
