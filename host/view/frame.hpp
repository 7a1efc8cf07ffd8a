/// What one picture shows, in plain values: the renderer knows nothing of scenes, records or windows.
#pragma once
#include <Eigen/Core>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace palpate::view {

/// The object, fixed for a scene. Workspace frame, metres: x right, y up, z towards the user.
struct Body {
    std::vector<Eigen::Vector3f> points_m;
    std::vector<Eigen::Vector3f> normals;
    std::vector<float> stiffness_n_per_m;  ///< per point; NaN: not known (drawn grey)
    std::string unknown = "unknown";       ///< why a point is grey, in lines of a dozen letters
    Eigen::Vector3f focus_m{0, 0, 0};      ///< what the camera looks at first
    float view_radius_m = 0.03F;           ///< what it shows around it
};

/// A point that is pushed in, and how far it moves.
struct Moved {
    std::uint32_t point;
    Eigen::Vector3f by_m;
};

/// One moment.
struct Frame {
    double t_s = 0.0;
    Eigen::Vector3f tool_m{0, 0, 0};
    float tool_radius_m = 0.003F;
    std::optional<Eigen::Vector3f> proxy_m;  ///< where the tool would rest on the undeformed skin
    std::optional<Eigen::Vector3f> normal;   ///< contact normal there
    Eigen::Vector3f force_n{0, 0, 0};        ///< on the hand
    float depth_m = 0.0F;
    float k_n_per_m = 0.0F;  ///< 0 without contact
    std::vector<Moved> dip;  ///< the deformed skin
    std::string rate_line;   ///< "haptics 1000 Hz  missed 0  table 12 ms"
};

/// Frames of a run by time.
struct Source {
    Body body;
    double duration_s = 0.0;
    std::function<Frame(double t_s)> frame_at;
    std::string title;
};

}  // namespace palpate::view
