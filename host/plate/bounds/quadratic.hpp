/// Small quadratic forms whose value at a point can be trusted, whatever their minimiser's rounding.
#pragma once
#include <array>
#include <cstddef>

#include "host/plate/bounds/member.hpp"

namespace palpate::plate::bounds {

/// y'A y - 2 b'y over the first `n` of N_MODES_MAX; `pairs` as pair_at orders them.
struct Quadratic {
    std::size_t n;
    std::array<double, n_pairs(N_MODES_MAX)> pairs;

    [[nodiscard]] double at(std::size_t i, std::size_t j) const {
        return pairs[i <= j ? pair_at(n, i, j) : pair_at(n, j, i)];
    }
    /// A y = b nearly, on the entries from `first` on; 0 before, and where A has nothing.
    [[nodiscard]] std::array<double, N_MODES_MAX> solve(const std::array<double, N_MODES_MAX>& b,
                                                        std::size_t first) const;
    /// y'A y, at most: the entries are sums that may be wrong by `margin` of |i||j|, |i| = A_ii^1/2.
    [[nodiscard]] double most(const std::array<double, N_MODES_MAX>& y, double margin) const;
};

}  // namespace palpate::plate::bounds
