/// The rungs that need sums alone. All in units of side^2/(1 N m), side along x.
#pragma once
#include <limits>

#include "host/plate/bounds/member.hpp"
#include "host/plate/bounds/weights.hpp"

namespace palpate::plate::bounds {

/// What is known of the compliance.
struct Range {
    double lower = 0.0, upper = std::numeric_limits<double>::infinity();
    /// Both hold. NaN says nothing.
    void meet(double low, double high) {
        if (low > lower) lower = low;
        if (high < upper) upper = high;
    }
};

/// Energies of a member's deflection under D and k_f, and of its stress, over k0^2 where that is k0's.
struct Energies {
    double bending, foundation;
    double stress_bending, stress_foundation;  ///< the latter 0 unless can_bound_above
};
[[nodiscard]] Energies energies(const Member& member, const Weights& weights);

/// A foundation's reaction can bear a part of the load only where there is one everywhere.
[[nodiscard]] bool can_bound_above(const Member& member, const Weights& weights);

/// The uniform plate's compliance over the extremes of D (MATH.md eq. 50).
void extremes_rung(const Member& member, const Weights& weights, Range& range);
/// One trial (MATH.md eq. 51).
void uniform_rung(const Member& member, const Weights& weights, const Energies& energies, Range& range);
/// The best of the modes' combinations (MATH.md eq. 52); of anchors.
void modes_lower_rung(const Member& member, const Weights& weights, Range& range);
void modes_upper_rung(const Member& member, const Weights& weights, Range& range);

}  // namespace palpate::plate::bounds
