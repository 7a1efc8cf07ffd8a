#include "tests/host/view/sheet.hpp"

#include <cmath>

namespace palpate::view::testing {
namespace {

constexpr float kSide_m = 0.08F;
constexpr float kRadius_m = 0.06F;  ///< of the dome
constexpr float kSpotX_m = 0.009F;
constexpr float kToolRadius_m = 0.003F;

float height_m(float x, float z) {
    return std::sqrt(kRadius_m * kRadius_m - x * x - z * z) - kRadius_m;
}
Eigen::Vector3f centre() {
    return {0.0F, -kRadius_m, 0.0F};
}
float spot(float x, float z) {
    const float d = std::sqrt((x - kSpotX_m) * (x - kSpotX_m) + z * z);
    return 0.5F * (1.0F - std::tanh((d - 0.005F) / 0.0012F));
}

}  // namespace

Body domed_sheet(int n) {
    Body body;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const float x = kSide_m * (static_cast<float>(i) / static_cast<float>(n - 1) - 0.5F);
            const float z = kSide_m * (static_cast<float>(j) / static_cast<float>(n - 1) - 0.5F);
            const Eigen::Vector3f at{x, height_m(x, z), z};
            body.points_m.push_back(at);
            body.normals.push_back((at - centre()).normalized());
            const float soft = kSoft_n_per_m * (1.0F + 1.5F * (x + 0.5F * kSide_m));
            body.stiffness_n_per_m.push_back(soft + (kStiff_n_per_m - soft) * spot(x, z));
        }
    }
    body.view_radius_m = 0.024F;
    return body;
}

Frame pressed(const Body& body, float x_m, float z_m, float depth_m) {
    const Eigen::Vector3f skin{x_m, height_m(x_m, z_m), z_m};
    const Eigen::Vector3f normal = (skin - centre()).normalized();
    Frame frame;
    frame.tool_radius_m = kToolRadius_m;
    frame.proxy_m = skin + kToolRadius_m * normal;
    frame.normal = normal;
    frame.tool_m = *frame.proxy_m - depth_m * normal;
    frame.depth_m = depth_m;
    frame.rate_line = "haptics 1000 Hz   missed 0   table 12 ms";
    if (!(depth_m > 0.0F)) return frame;
    const float soft = kSoft_n_per_m * (1.0F + 1.5F * (x_m + 0.5F * kSide_m));
    frame.k_n_per_m = soft + (kStiff_n_per_m - soft) * spot(x_m, z_m);
    frame.force_n = frame.k_n_per_m * depth_m * normal;
    for (std::uint32_t i = 0; i < body.points_m.size(); ++i) {
        const float d = (body.points_m[i] - skin).norm();
        const float w = depth_m * std::exp(-d * d / (2.0F * 0.0035F * 0.0035F));
        if (w > 1.0e-6F) frame.dip.push_back({i, -w * normal});
    }
    return frame;
}

Source stroke() {
    Source source;
    source.body = domed_sheet();
    source.duration_s = 2.0;
    source.title = "A hard spot in a domed sheet";
    source.frame_at = [body = source.body](double t_s) {
        Frame frame = pressed(body, -0.012F + 0.012F * static_cast<float>(t_s), 0.0F, 0.004F);
        frame.t_s = t_s;
        return frame;
    };
    return source;
}

}  // namespace palpate::view::testing
