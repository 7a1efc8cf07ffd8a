/// The one weight function of all moving fits.
#pragma once

namespace palpate::contact {

/// Wendland's C2 function of r = distance/support: 1 at 0, 0 from 1 on, smooth between.
[[nodiscard]] inline double wendland(double r) {
    if (r >= 1.0) return 0.0;
    const double a = (1.0 - r) * (1.0 - r);
    return a * a * (4.0 * r + 1.0);
}

}  // namespace palpate::contact
