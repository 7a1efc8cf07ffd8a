#include "host/view/camera.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace palpate::view {
namespace {

constexpr float kPitchMax_rad = 1.55F;
constexpr float kOrbit_rad_per_px = 0.008F;
constexpr float kZoomPerClick = 0.88F;
constexpr float kDistanceMin_m = 0.005F;
constexpr float kDistanceMax_m = 5.0F;
constexpr float kHomeOblique_rad = 1.15F;  ///< between view and skin normal: along the skin, into the dip
/// Turns about the normal, from straight above (on flat skin: from the user's side), in order of liking.
constexpr std::array<float, 8> kHomeTurns_rad{-0.15F, 0.15F, -1.2F, 1.2F, -1.9F, 1.9F, -2.6F, 2.6F};
constexpr float kLineOfSight = 0.15F;  ///< radius of what must be free before the eye, over the view's

Eigen::Vector3f direction(float yaw_rad, float pitch_rad) {
    const float level = std::cos(pitch_rad);
    return {level * std::sin(yaw_rad), std::sin(pitch_rad), level * std::cos(yaw_rad)};
}

Eigen::Vector3f mean_normal_near(const Body& body, float radius_m) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    const std::size_t n = std::min(body.points_m.size(), body.normals.size());
    float nearest_m = std::numeric_limits<float>::infinity();
    Eigen::Vector3f nearest_normal = Eigen::Vector3f::UnitZ();
    for (std::size_t i = 0; i < n; ++i) {
        const float distance_m = (body.points_m[i] - body.focus_m).norm();
        if (distance_m < nearest_m) {
            nearest_m = distance_m;
            nearest_normal = body.normals[i];
        }
    }
    // Only the wall that the nearest point belongs to: a thin object's other wall would cancel it.
    for (std::size_t i = 0; i < n; ++i) {
        const bool is_near = (body.points_m[i] - body.focus_m).norm() < nearest_m + radius_m;
        if (is_near && body.normals[i].dot(nearest_normal) > 0.0F) sum += body.normals[i];
    }
    return sum.norm() > 0.0F ? Eigen::Vector3f(sum.normalized()) : nearest_normal;
}

/// Whether nothing of the body stands between the eye and the skin at the target.
bool is_free(const Body& body, const Camera& camera, const Eigen::Vector3f& normal) {
    const float radius_m = kLineOfSight * body.view_radius_m;
    const Eigen::Vector3f back = (camera.eye_m() - camera.target_m).normalized();
    const Eigen::Vector3f from_m = camera.target_m + 2.0F * radius_m * normal;  // clear of the skin itself
    return std::none_of(body.points_m.begin(), body.points_m.end(), [&](const Eigen::Vector3f& point_m) {
        const Eigen::Vector3f d_m = point_m - from_m;
        const float ahead_m = d_m.dot(back);
        return ahead_m > 0.0F && ahead_m < camera.distance_m && (d_m - ahead_m * back).norm() < radius_m;
    });
}

float fitting_distance_m(float radius_m, float fov_y_rad) {
    return std::clamp(radius_m / std::sin(0.5F * fov_y_rad), kDistanceMin_m, kDistanceMax_m);
}

}  // namespace

Eigen::Vector3f Camera::eye_m() const {
    return target_m + distance_m * direction(yaw_rad, pitch_rad);
}

Eigen::Vector3f Camera::right() const {
    return {std::cos(yaw_rad), 0.0F, -std::sin(yaw_rad)};
}

Eigen::Matrix4f Camera::view() const {
    const Eigen::Vector3f back = direction(yaw_rad, pitch_rad);
    const Eigen::Vector3f up = back.cross(right());
    Eigen::Matrix4f m = Eigen::Matrix4f::Identity();
    m.block<1, 3>(0, 0) = right().transpose();
    m.block<1, 3>(1, 0) = up.transpose();
    m.block<1, 3>(2, 0) = back.transpose();
    m.block<3, 1>(0, 3) = -(m.block<3, 3>(0, 0) * eye_m());
    return m;
}

Eigen::Matrix4f Camera::projection(Size size, const Eigen::Vector3f& centre_m, float radius_m) const {
    const float to_centre_m = (centre_m - eye_m()).norm();
    const float far_m = std::max(to_centre_m + radius_m, 2.0F * distance_m);
    const float near_m = std::max(std::min(to_centre_m - radius_m, 0.5F * distance_m), 1.0e-3F * far_m);
    const float f = 1.0F / std::tan(0.5F * fov_y_rad);
    Eigen::Matrix4f m = Eigen::Matrix4f::Zero();
    m(0, 0) = f * static_cast<float>(size.height) / static_cast<float>(size.width);
    m(1, 1) = f;
    m(2, 2) = (far_m + near_m) / (near_m - far_m);
    m(2, 3) = 2.0F * far_m * near_m / (near_m - far_m);
    m(3, 2) = -1.0F;
    return m;
}

Camera orbited(const Camera& camera, float dx_px, float dy_px) {
    Camera turned = camera;
    turned.yaw_rad -= dx_px * kOrbit_rad_per_px;
    turned.pitch_rad =
        std::clamp(camera.pitch_rad + dy_px * kOrbit_rad_per_px, -kPitchMax_rad, kPitchMax_rad);
    return turned;
}

Camera panned(const Camera& camera, float dx_px, float dy_px, Size size) {
    if (size.empty()) return camera;
    const Eigen::Matrix4f m = camera.view();
    const float step_m = metres_per_pixel(camera, size);
    Camera moved = camera;
    moved.target_m += step_m * (dy_px * m.block<1, 3>(1, 0) - dx_px * m.block<1, 3>(0, 0)).transpose();
    return moved;
}

Camera zoomed(const Camera& camera, float clicks) {
    Camera nearer = camera;
    nearer.distance_m =
        std::clamp(camera.distance_m * std::pow(kZoomPerClick, clicks), kDistanceMin_m, kDistanceMax_m);
    return nearer;
}

Camera home_camera(const Body& body) {
    Camera camera;
    camera.target_m = body.focus_m;
    camera.distance_m = fitting_distance_m(body.view_radius_m, camera.fov_y_rad);
    const Eigen::Vector3f normal = mean_normal_near(body, 0.3F * body.view_radius_m);
    const bool lies_flat = std::hypot(normal.x(), normal.z()) < 0.3F;
    const Eigen::Vector3f ahead = lies_flat ? Eigen::Vector3f::UnitZ() : Eigen::Vector3f::UnitY();
    const Eigen::Vector3f along = (ahead - ahead.dot(normal) * normal).normalized();
    std::optional<Camera> first;
    for (const float turn_rad : kHomeTurns_rad) {
        const Eigen::Vector3f tangent = Eigen::AngleAxisf(turn_rad, normal) * along;
        const Eigen::Vector3f back =
            std::cos(kHomeOblique_rad) * normal + std::sin(kHomeOblique_rad) * tangent;
        camera.yaw_rad = std::atan2(back.x(), back.z());
        camera.pitch_rad =
            std::clamp(std::asin(std::clamp(back.y(), -1.0F, 1.0F)), -kPitchMax_rad, kPitchMax_rad);
        if (!first) first = camera;
        if (is_free(body, camera, normal)) return camera;
    }
    return *first;
}

Camera framed(const Camera& camera, const Body& body) {
    const Bounds bounds = bounds_of(body.points_m);
    Camera whole = camera;
    whole.target_m = bounds.centre_m;
    whole.distance_m = fitting_distance_m(bounds.radius_m, camera.fov_y_rad);
    return whole;
}

std::optional<Pixel> project(const Camera& camera, Size size, const Eigen::Vector3f& point_m) {
    const Eigen::Vector4f in_eye = camera.view() * point_m.homogeneous();
    const float depth_m = -in_eye.z();
    if (size.empty() || !(depth_m > 1.0e-6F)) return std::nullopt;
    const float half_height = 0.5F * static_cast<float>(size.height);
    const float px_per_slope = half_height / std::tan(0.5F * camera.fov_y_rad);
    return Pixel{0.5F * static_cast<float>(size.width) + px_per_slope * in_eye.x() / depth_m,
                 half_height - px_per_slope * in_eye.y() / depth_m, depth_m};
}

float metres_per_pixel(const Camera& camera, Size size) {
    return 2.0F * camera.distance_m * std::tan(0.5F * camera.fov_y_rad) / static_cast<float>(size.height);
}

Bounds bounds_of(const std::vector<Eigen::Vector3f>& points_m) {
    if (points_m.empty()) return {};
    Eigen::Vector3f low = points_m.front();
    Eigen::Vector3f high = points_m.front();
    for (const Eigen::Vector3f& point : points_m) {
        low = low.cwiseMin(point);
        high = high.cwiseMax(point);
    }
    return {0.5F * (low + high), std::max(0.5F * (high - low).norm(), 1.0e-4F)};
}

}  // namespace palpate::view
