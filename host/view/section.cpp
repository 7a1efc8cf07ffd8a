#include "host/view/section.hpp"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <numbers>
#include <unordered_map>

namespace palpate::view {
namespace {

constexpr float kHalfWidth = 3.0F;  ///< of the cut, over the tool's radius
constexpr float kMargin = 1.3F;     ///< points are taken from so much farther
constexpr float kSameWall = 0.2F;   ///< least cosine between a point's normal and the contact's
constexpr int kSteps = 60;
constexpr float kReach = 0.8F;         ///< standard deviation of the weights over the spacing
constexpr float kWeightsLeast = 1.2F;  ///< sum of weights below which there is no skin

struct Axes {
    Eigen::Vector3f origin_m;
    Eigen::Vector3f right;
    Eigen::Vector3f ahead;
    Eigen::Vector3f up;
    [[nodiscard]] Eigen::Vector3f of(const Eigen::Vector3f& v) const {
        return {v.dot(right), v.dot(ahead), v.dot(up)};
    }
};

Axes axes_of(const Frame& frame, const Eigen::Vector3f& right) {
    Axes axes;
    axes.up = frame.normal->normalized();
    const Eigen::Vector3f along = right - right.dot(axes.up) * axes.up;
    axes.right = along.norm() > 0.1F * right.norm() ? Eigen::Vector3f(along.normalized())
                                                    : Eigen::Vector3f(axes.up.unitOrthogonal());
    axes.ahead = axes.up.cross(axes.right);
    axes.origin_m = frame.proxy_m.value_or(frame.tool_m) - frame.tool_radius_m * axes.up;
    return axes;
}

/// A scan point near the cut, in its axes.
struct Sample {
    Eigen::Vector3f at_m;
    Eigen::Vector3f by_m;
};

std::vector<Sample> samples_near(const Body& body, const Frame& frame, const Axes& axes, float radius_m) {
    std::unordered_map<std::uint32_t, Eigen::Vector3f> moved;
    for (const Moved& move : frame.dip) moved[move.point] = move.by_m;
    std::vector<Sample> near;
    for (std::uint32_t i = 0; i < body.points_m.size(); ++i) {
        const Eigen::Vector3f from_m = body.points_m[i] - axes.origin_m;
        if (!(from_m.norm() < radius_m) || !(body.normals[i].dot(axes.up) > kSameWall)) continue;
        const auto found = moved.find(i);
        const Eigen::Vector3f by_m = found == moved.end() ? Eigen::Vector3f::Zero() : found->second;
        near.push_back({axes.of(from_m), axes.of(by_m)});
    }
    return near;
}

using Quadratic = Eigen::Matrix<float, 6, 1>;

/// Height, and shift along x and y, of the skin at `x_m` in the cut; nullopt where there is none.
std::optional<std::array<float, 3>> skin_at(const std::vector<Sample>& samples, float x_m, float spacing_m) {
    Eigen::Matrix<float, 6, 6> left = 1.0e-4F * Eigen::Matrix<float, 6, 6>::Identity();
    Eigen::Matrix<float, 6, 3> right = Eigen::Matrix<float, 6, 3>::Zero();
    float sum = 0.0F;
    for (const Sample& sample : samples) {
        const float x = (sample.at_m.x() - x_m) / spacing_m;
        const float y = sample.at_m.y() / spacing_m;
        const float weight = std::exp(-(x * x + y * y) / (2.0F * kReach * kReach));
        if (weight < 1.0e-5F) continue;
        const Quadratic terms(Quadratic{1.0F, x, y, x * x, x * y, y * y});
        left += weight * terms * terms.transpose();
        right += weight * terms * Eigen::RowVector3f(sample.at_m.z(), sample.by_m.x(), sample.by_m.z());
        sum += weight;
    }
    if (sum < kWeightsLeast) return std::nullopt;
    const Eigen::Matrix<float, 6, 3> fitted = left.ldlt().solve(right);
    if (!fitted.row(0).allFinite()) return std::nullopt;
    return std::array<float, 3>{fitted(0, 0), fitted(0, 1), fitted(0, 2)};
}

}  // namespace

std::optional<Section> section_of(const Body& body, const Frame& frame, const Eigen::Vector3f& right) {
    if (!frame.normal || !(frame.normal->norm() > 0.0F)) return std::nullopt;
    const Axes axes = axes_of(frame, right);
    Section section;
    section.half_width_m = kHalfWidth * frame.tool_radius_m;
    const Eigen::Vector3f tool_m = axes.of(frame.tool_m - axes.origin_m);
    section.tool_m = {tool_m.x(), tool_m.z()};
    const float radius_m = kMargin * section.half_width_m;
    const std::vector<Sample> samples = samples_near(body, frame, axes, radius_m);
    if (samples.empty()) return section;
    const float spacing_m =
        radius_m * std::sqrt(std::numbers::pi_v<float> / static_cast<float>(samples.size()));
    for (int i = -kSteps; i <= kSteps; ++i) {
        const float x_m = section.half_width_m * static_cast<float>(i) / kSteps;
        const auto skin = skin_at(samples, x_m, spacing_m);
        if (!skin) continue;
        const auto [height_m, aside_m, up_m] = *skin;
        section.rest_m.emplace_back(x_m, height_m);
        section.dipped_m.emplace_back(x_m + aside_m, height_m + up_m);
    }
    return section;
}

}  // namespace palpate::view
