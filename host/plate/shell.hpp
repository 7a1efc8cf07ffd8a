/// What a shell's curvature adds to a plate: the foundation that stands for its membrane.
#pragma once
#include <Eigen/Core>

namespace palpate::plate {

/// Principal curvatures at the load; alike in sign on a dome or a bowl, unlike on a saddle.
struct Shell {
    double kappa1_per_m = 0.0;
    double kappa2_per_m = 0.0;
};

struct ShellTerm {
    Eigen::ArrayXXd foundation_n_per_m3;  ///< at the nodes, as `young_pa`; 0 where there is no skin
    bool boundary_dominated = false;      ///< cylinder, saddle and near them: the patch's edge decides
    double l_m = 0.0;  ///< (D/k_f)^(1/4) at the centre, E not smoothed; infinite without curvature
};

/// The k_f = E h kappa^2, kappa even over the patch, whose clamped square gives way at its centre as much as
/// the mean over 8 directions t of squares with k_f(t) = E h (kappa2 cos^2 t + kappa1 sin^2 t)^2 (MATH.md eq.
/// 38). That is E h kappa1 kappa2, exact, on domes and bowls that the patch's edge does not hold. No
/// foundation is right for cylinders and saddles: the mean lies between a fixed and an in-plane free edge for
/// saddles, 25 % above free for the cylinder. Continuous from one to the other. E is replaced by its harmonic
/// Gaussian mean over sigma = 2 l, as the membrane is not local (MATH.md eq. 39). The object is taken to go
/// on: good to 0.45 l/R on a closed shell; a patch with a free rim is 20-35 % softer.
/// `young_pa` at the nodes (ix, iz) of a patch of `size_m`, odd counts, >= 0, > 0 at the centre; 0: no skin,
/// left out of the means. `thickness_m` > 0 alike, or 1 x 1. Throws std::invalid_argument. n^3 operations.
[[nodiscard]] ShellTerm shell_term(const Shell& shell, const Eigen::ArrayXXd& young_pa,
                                   const Eigen::ArrayXXd& thickness_m, double poisson,
                                   const Eigen::Vector2d& size_m);

}  // namespace palpate::plate
