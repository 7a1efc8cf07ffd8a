/// Algebraic sphere fit after Pratt (SIGGRAPH 1987), with a continuous limit at the plane.
#pragma once
#include <Eigen/Core>
#include <span>
#include <stdexcept>

namespace palpate::contact {

/// A sphere or plane as u0 |x|^2 + (u1 u2 u3).x + u4 = 0 with u1^2 + u2^2 + u3^2 - 4 u0 u4 = 1 (paper eq. 1),
/// signed so that the value is positive outside the object. Positions relative to `origin_m`. The centre is
/// -(u1 u2 u3)/(2 u0) (the paper's eq. 3 mixes two conventions: docs/PAPER.md), never formed: a plane has u0
/// = 0.
struct Sphere {
    Eigen::Vector3d origin_m;
    Eigen::Matrix<double, 5, 1> u;
    [[nodiscard]] double kappa_per_m() const;  ///< signed, convex > 0: 2 u0 under the constraint
    /// Signed distance, positive outside; exact and smooth through kappa = 0.
    [[nodiscard]] double distance_m(const Eigen::Vector3d& at_m) const;
    /// Unit, along the gradient at `at_m`: away from the object.
    [[nodiscard]] Eigen::Vector3d normal(const Eigen::Vector3d& at_m) const;
    /// Nearest point on the sphere.
    [[nodiscard]] Eigen::Vector3d project(const Eigen::Vector3d& at_m) const;
};

/// Points that no sphere can be fitted to.
struct NoFit : std::invalid_argument {
    using std::invalid_argument::invalid_argument;
};

/// Weighted Pratt fit: minimises sum w (algebraic distance)^2 under the constraint of eq. 1 (a generalised
/// symmetric eigenproblem, solved after centring and scaling). `outward` gives the sign; points
/// all round a sphere have none, then the object is inside. Throws NoFit with fewer than 4 points of
/// positive weight, or with all of them in one place. O(n), allocates nothing; 4 us for 55 points.
[[nodiscard]] Sphere fit_sphere(std::span<const Eigen::Vector3d> points_m, std::span<const double> weights,
                                const Eigen::Vector3d& outward);

}  // namespace palpate::contact
