#include "host/app/view_source.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "host/chart/patch.hpp"
#include "host/record/record.hpp"

namespace palpate::app {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kViewToolRadii = 8.0F;  ///< half the picture's height, so that a dip is seen and an ear too

Vector3f vec(const float (&v)[3]) {
    return {v[0], v[1], v[2]};
}

/// Index of the tick at a scene time, or of the first after it; `times_s` ascend and are not empty.
std::size_t tick_at(const std::vector<double>& times_s, double t_s) {
    constexpr double kHalfTick_s = 0.0005;
    const auto found = std::lower_bound(times_s.begin(), times_s.end(), std::max(t_s, 0.0) - kHalfTick_s);
    return std::min(static_cast<std::size_t>(found - times_s.begin()), times_s.size() - 1);
}

std::string rate_line(const pal_tick& tick, double rate_hz) {
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), "haptics %.0f Hz   missed %u   table %u ms old", rate_hz,
                  tick.n_missed, tick.table_age_ticks);
    return text.data();
}

/// Ticks per second of the run's clock in the second around a tick.
double rate_hz(const std::vector<pal_tick>& ticks, std::size_t at) {
    const std::size_t low = at >= 500 ? at - 500 : 0, high = std::min(at + 500, ticks.size() - 1);
    const double s = 1e-9 * static_cast<double>(ticks[high].t_ns - ticks[low].t_ns);
    return s > 0.0 ? static_cast<double>(high - low) / s : 0.0;
}

/// The foot on the wall that pushes. Deep in a thin object the other wall is nearer: it is looked for from
/// farther and farther outside.
std::optional<contact::Foot> touched(const scene::World& world, const Vector3d& tool, const Vector3d& force) {
    const double radius_m = world.scene.touch.tool_radius_m;
    const Vector3d out = force.normalized();
    std::optional<contact::Foot> foot = world.surface->foot(tool, world.tree->nearest(tool));
    for (double way_m = radius_m; way_m < 20.0 * radius_m; way_m *= 2.0) {
        if (!foot || foot->normal.dot(out) >= 0.0) break;
        foot = world.surface->foot(tool, world.tree->nearest(tool + way_m * out));
    }
    return foot;
}

void touch(const scene::World& world, const pal_tick& tick, view::Frame& frame) {
    if (!(tick.depth_m > 0.0F)) return;
    const Vector3d tool = world.on_object(vec(tick.position_m).cast<double>());
    const double radius_m = world.scene.touch.tool_radius_m;
    const auto foot = touched(world, tool, frame.force_n.cast<double>());
    if (!foot) return;
    frame.proxy_m = (foot->point_m + radius_m * foot->normal).cast<float>();
    frame.normal = foot->normal.cast<float>();
    const double force_n = static_cast<double>(frame.force_n.norm()) / world.scene.placement.force_scale;
    if (!(force_n > 0.0)) return;
    try {
        for (const chart::Displaced& d : chart::dip(*world.surface, *foot, world.material, force_n)) {
            frame.dip.push_back({d.point, d.by_m.cast<float>()});
        }
    } catch (const chart::NoPatch&) {  // no plate at a rim: the skin is drawn undeformed
    }
}

}  // namespace

double peak_time_s(const std::vector<pal_tick>& ticks) {
    const std::vector<double> times_s = record::scene_times_s(ticks);
    double peak_s = 0.0;
    float largest = 0.0F;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        const float size = vec(ticks[i].force_n).squaredNorm();
        if (times_s[i] < 0.0 || !(ticks[i].depth_m > 0.0F) || !(size > largest)) continue;
        largest = size;
        peak_s = times_s[i];
    }
    return peak_s;
}

view::Source view_source(const scene::World& world, const table::StiffnessField& field,
                         std::vector<pal_tick> ticks) {
    view::Source source;
    for (const Vector3d& p : world.cloud.points_m) source.body.points_m.push_back(p.cast<float>());
    for (const Vector3d& n : world.cloud.normals) source.body.normals.push_back(n.cast<float>());
    source.body.stiffness_n_per_m = field.known_n_per_m();
    source.body.unknown = "not solved:\nthe path does\nnot reach it";
    source.body.view_radius_m = kViewToolRadii * static_cast<float>(world.scene.touch.tool_radius_m);
    if (!world.nodules.empty()) {
        source.body.focus_m = world.nodules.front().at_m.cast<float>();
    } else if (!world.path.empty()) {
        source.body.focus_m = world.path[world.path.size() / 2].foot.point_m.cast<float>();
    }
    source.title = world.scene.title;
    std::vector<double> times_s = record::scene_times_s(ticks);
    source.duration_s = ticks.empty() ? 0.0 : std::max(times_s.back(), 0.0);
    source.frame_at = [&world, ticks = std::move(ticks), times_s = std::move(times_s)](double t_s) {
        view::Frame frame;
        frame.t_s = t_s;
        frame.tool_radius_m = static_cast<float>(world.scene.touch.tool_radius_m);
        if (ticks.empty()) {
            if (!world.path.empty()) frame.tool_m = world.on_object(world.path.front().tool_m).cast<float>();
            return frame;
        }
        const std::size_t at = tick_at(times_s, t_s);
        const pal_tick& tick = ticks[at];
        frame.t_s = times_s[at];
        frame.tool_m = world.on_object(vec(tick.position_m).cast<double>()).cast<float>();
        frame.force_n = tick.truth_valid != 0 ? vec(tick.truth_force_n) : vec(tick.force_n);
        const scene::Placement& placement = world.scene.placement;  // the picture is the object's
        frame.depth_m = static_cast<float>(placement.position_scale) * std::max(tick.depth_m, 0.0F);
        frame.k_n_per_m =
            tick.k_n_per_m / static_cast<float>(placement.position_scale * placement.force_scale);
        frame.rate_line = rate_line(tick, rate_hz(ticks, at));
        touch(world, tick, frame);
        return frame;
    };
    return source;
}

}  // namespace palpate::app
