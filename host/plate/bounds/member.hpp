/// One uniform plate under the load, and what is worth keeping of it: made once, asked for every D.
#pragma once
#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "host/plate/bounds/strains.hpp"
#include "host/plate/plate.hpp"

namespace palpate::plate::bounds {

constexpr double EPSILON = std::numeric_limits<double>::epsilon();  ///< twice a rounding error

/// The uniform plate, 7 ways in which D may differ from uniform, one in which the foundation may.
constexpr std::size_t N_MODES_MAX = 9;

[[nodiscard]] constexpr std::size_t n_pairs(std::size_t n_modes) {
    return n_modes * (n_modes + 1) / 2;
}
/// Where the pair (i, j), i <= j, stands among the pairs of `n_modes`.
[[nodiscard]] constexpr std::size_t pair_at(std::size_t n_modes, std::size_t i, std::size_t j) {
    return i * n_modes - i * (i + 1) / 2 + j;
}

/// Deflections and balanced stresses, as products of pairs lumped to the nodes (MATH.md eq. 52). Each block
/// holds n_pairs(n) rows of one value per node; those of the foundation are empty without one.
struct Modes {
    std::size_t n = 0;
    std::vector<double> strain_d,
        strain_k;  ///< of the deflections: w_i'K w_j = sum of D and of k_f times these
    std::vector<double> stress_d,
        stress_k;  ///< of the stresses: their energy is the sum of these over D and k_f
    std::array<double, N_MODES_MAX> work{};       ///< p'w_i
    std::array<double, N_MODES_MAX> slip{};       ///< norm of what rounding may have done to the strains
    std::array<double, N_MODES_MAX> imbalance{};  ///< (r'K^-1 r)^1/2 of r = B's_0 - p, B's_i; K uniform
};

/// D = 1, k_f = k0 everywhere. Lengths over the side along x; forces of the load, which need not sum to 1.
struct Member {
    double k0 = 0.0;
    double work = 0.0;                                   ///< p'w of the deflection kept, rounded down
    double compliance_low = 0.0, compliance_high = 0.0;  ///< its own, surely
    std::vector<double> bending;     ///< energy density at the nodes per unit of D, rounded up
    std::vector<double> foundation;  ///< and per unit of k_f
    double bending_sum = 0.0, foundation_sum = 0.0;
    double imbalance = 0.0;          ///< (r'K^-1 r)^1/2, r = B's - p, at most
    Modes modes;                     ///< none unless an anchor
    std::unique_ptr<Plate> plate;    ///< none unless an anchor
    std::vector<double> deflection;  ///< padded; anchors
    std::vector<double> stress;      ///< in rows of B; anchors
};

/// All that the members have in common.
struct Setting {
    Problem unit;  ///< the problem with D = 1 and no foundation, lengths over the side along x
    Strains<long double> strains;
    std::vector<long double> force;  ///< padded, zero where nothing moves
    std::array<double, 2> load_at;   ///< centre of the load, lengths over the side along x
    double least_eigenvalue = 0.0;   ///< of K at D = 1, k_f = 0; a lower bound

    /// `problem` as Bounds wants it. Throws as Plate does.
    Setting(const Problem& problem, std::span<const double> force);
};

enum class Keep { sums, anchor };

/// `with_foundation`: keep what a foundation needs although k0 may be 0. Throws as Plate does.
[[nodiscard]] Member make_member(const Setting& setting, double k0, bool with_foundation, Keep keep);

/// Between the values at the nodes of a grid, x fastest, and a padded grid.
template <typename From, typename To>
void pad(const Padded& grid, const From* nodes, To* padded) {
    for (std::size_t iz = 0; iz < grid.nz; ++iz) {
        for (std::size_t ix = 0; ix < grid.nx; ++ix)
            padded[grid.at(ix, iz)] = static_cast<To>(nodes[ix + grid.nx * iz]);
    }
}
template <typename From, typename To>
void unpad(const Padded& grid, const From* padded, To* nodes) {
    for (std::size_t iz = 0; iz < grid.nz; ++iz) {
        for (std::size_t ix = 0; ix < grid.nx; ++ix)
            nodes[ix + grid.nx * iz] = static_cast<To>(padded[grid.at(ix, iz)]);
    }
}

}  // namespace palpate::plate::bounds
