/// Interpolation of a smooth function of one variable from 17 Chebyshev-Lobatto points. No libm but sqrt.
#pragma once
#include <array>
#include <cstddef>

namespace palpate::plate {

struct Interval {
    double begin;
    double end;
};

constexpr std::size_t N_LOBATTO = 17;

/// The points, from `end` down to `begin`, both included: neighbouring intervals agree where they meet.
[[nodiscard]] std::array<double, N_LOBATTO> lobatto_points(const Interval& interval);

/// Polynomial of degree 16 through `values` at those points, barycentric form.
[[nodiscard]] double interpolate(const Interval& interval, const std::array<double, N_LOBATTO>& values,
                                 double x);

}  // namespace palpate::plate
