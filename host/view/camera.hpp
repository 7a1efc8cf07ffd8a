/// Where the picture is taken from, and where a point of the workspace lands in it.
#pragma once
#include <Eigen/Core>
#include <optional>

#include "host/view/frame.hpp"

namespace palpate::view {

/// A picture's size in pixels.
struct Size {
    int width = 0;
    int height = 0;
    [[nodiscard]] bool empty() const { return width <= 0 || height <= 0; }
};

/// A turntable about +y: it looks at `target_m` from `distance_m` away and never rolls.
struct Camera {
    Eigen::Vector3f target_m{0, 0, 0};
    float yaw_rad = 0.0F;    ///< 0: from +z, the user's side; positive: from +x
    float pitch_rad = 0.0F;  ///< positive: from above; within +-1.55
    float distance_m = 0.2F;
    float fov_y_rad = 0.6F;

    [[nodiscard]] Eigen::Vector3f eye_m() const;
    /// What points to the right in the picture; level.
    [[nodiscard]] Eigen::Vector3f right() const;
    /// Workspace to eye: x right in the picture, y up, z towards the eye.
    [[nodiscard]] Eigen::Matrix4f view() const;
    /// Eye to clip space of OpenGL. The planes enclose the sphere `radius_m` around `centre_m`.
    [[nodiscard]] Eigen::Matrix4f projection(Size size, const Eigen::Vector3f& centre_m,
                                             float radius_m) const;
};

/// Drags and wheel, in pixels and clicks; the result stays within usable limits.
[[nodiscard]] Camera orbited(const Camera& camera, float dx_px, float dy_px);
[[nodiscard]] Camera panned(const Camera& camera, float dx_px, float dy_px, Size size);
[[nodiscard]] Camera zoomed(const Camera& camera, float clicks);

/// The first view: body.focus_m and view_radius_m around it, from the side the skin faces there, but nearly
/// along the skin, so that a dip's profile and a force along the normal are seen in their length. From above
/// where nothing of the body is in the way, else from the next side where nothing is.
[[nodiscard]] Camera home_camera(const Body& body);
/// The whole object from the direction of `camera`.
[[nodiscard]] Camera framed(const Camera& camera, const Body& body);

/// A place in the picture: pixels from its top left corner (pixel centres at .5), and metres in front of the
/// eye.
struct Pixel {
    float x;
    float y;
    float depth_m;
};

/// nullopt behind the eye.
[[nodiscard]] std::optional<Pixel> project(const Camera& camera, Size size, const Eigen::Vector3f& point_m);

/// Metres across one pixel at the distance of the target.
[[nodiscard]] float metres_per_pixel(const Camera& camera, Size size);

/// The sphere around the bounding box of the points; radius 0.01 m for no points.
struct Bounds {
    Eigen::Vector3f centre_m{0, 0, 0};
    float radius_m = 0.01F;
};
[[nodiscard]] Bounds bounds_of(const std::vector<Eigen::Vector3f>& points_m);

}  // namespace palpate::view
