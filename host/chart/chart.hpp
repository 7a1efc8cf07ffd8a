/// A fitted sphere's neighbourhood of the contact, laid flat.
#pragma once
#include <Eigen/Core>
#include <optional>

namespace palpate::chart {

enum class Projection {
    azimuthal,   ///< Lambert azimuthal equal-area: isometric at the contact
    gall_peters  ///< the paper's eq. 4 with the contact at (0, 0): stretches 2:1 there
};

/// Frame at a contact: e3 leaves the object, from the sphere's centre through the origin; e1, e2 tangent.
struct Frame {
    Eigen::Vector3d origin_m;
    Eigen::Matrix3d axes;  ///< e1, e2, e3 as rows
    double kappa_per_m;    ///< signed curvature of the sphere, convex > 0; 0 is a plane
    /// Coordinates of a place in the frame.
    [[nodiscard]] Eigen::Vector3d local_m(const Eigen::Vector3d& at_m) const;
    [[nodiscard]] Eigen::Vector3d world_m(const Eigen::Vector3d& local_m) const;
};

/// Frame with the azimuth fixed by world directions: e1 is the part of the world's x that is tangent (of the
/// world's z where x is within 10 degrees of e3). docs/FRAMES.md says where it flips.
[[nodiscard]] Frame frame_at(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& e3, double kappa_per_m);

/// Gnomonic coordinates and height over the sphere of a place x in the frame (MATH.md eq. 1): (u, v, height).
/// nullopt where q = 1 + kappa x3 < 0.2: the far side or past the centre.
[[nodiscard]] std::optional<Eigen::Vector3d> gnomonic(const Frame& frame, const Eigen::Vector3d& local_m);
/// Inverse: the place at (u, v) and a height over the sphere, in the frame.
[[nodiscard]] Eigen::Vector3d from_gnomonic(const Frame& frame, double u_m, double v_m, double height_m);

/// Plate coordinates (x, z) relative to the contact of gnomonic (u, v). Exact for kappa = 0 and of either
/// sign.
[[nodiscard]] Eigen::Vector2d to_plate(const Frame& frame, Projection projection, double u_m, double v_m);
/// Inverse of to_plate: gnomonic (u, v) of plate coordinates; nullopt outside the hemisphere.
[[nodiscard]] std::optional<Eigen::Vector2d> from_plate(const Frame& frame, Projection projection,
                                                        const Eigen::Vector2d& plate_m);

}  // namespace palpate::chart
