/// What every body with large deflections is asked and answers.
#pragma once
#include <vector>

namespace palpate::reference {

/// What holds a clamped edge in its own plane. Deflection and slope are 0 there in both cases.
enum class Edge { fixed, free };

/// Where a point was held, one depth after another, and what that took. Lists are as long as each other.
struct Pressed {
    double linear_stiffness_n_per_m = 0.0;  ///< k of the same residuals without their quadratic part
    std::vector<double> depths_m;
    std::vector<double> reaction_n;   ///< F
    std::vector<double> energy_j;     ///< F is its derivative by the depth
    std::vector<double> force_ratio;  ///< F/(k d)
    std::vector<int> iterations;
};

}  // namespace palpate::reference
