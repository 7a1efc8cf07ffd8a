#include "host/app/view_source.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "host/chart/patch.hpp"

namespace palpate::app {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

Vector3f vec(const float (&v)[3]) {
    return {v[0], v[1], v[2]};
}

/// Index of the tick at a scene time; the first tick of the path where it has none before.
std::size_t tick_at(const std::vector<pal_tick>& ticks, std::size_t first, double t_s) {
    const auto ahead = static_cast<std::size_t>(std::max(0.0, t_s) * 1e3);
    return std::min(first + ahead, ticks.size() - 1);
}

std::size_t first_of_path(const std::vector<pal_tick>& ticks) {
    const auto found =
        std::find_if(ticks.begin(), ticks.end(), [](const pal_tick& t) { return t.path_tick > 0; });
    return found == ticks.end() ? 0 : static_cast<std::size_t>(found - ticks.begin());
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

void touch(const scene::World& world, const pal_tick& tick, view::Frame& frame) {
    const Vector3d tool = world.on_object(vec(tick.position_m).cast<double>());
    const auto foot = world.surface->foot(tool, world.tree->nearest(tool));
    if (!foot) return;
    const double radius_m = world.scene.touch.tool_radius_m;
    frame.proxy_m = (foot->point_m + radius_m * foot->normal).cast<float>();
    frame.normal = foot->normal.cast<float>();
    const auto force_n = static_cast<double>(frame.force_n.norm());
    if (!(tick.depth_m > 0.0F) || !(force_n > 0.0)) return;
    try {
        for (const chart::Displaced& d : chart::dip(*world.surface, *foot, world.material, force_n)) {
            frame.dip.push_back({d.point, d.by_m.cast<float>()});
        }
    } catch (const chart::NoPatch&) {  // no plate at a rim: the skin is drawn undeformed
    }
}

}  // namespace

double peak_time_s(const std::vector<pal_tick>& ticks) {
    const auto size = [](const pal_tick& t) { return vec(t.force_n).squaredNorm(); };
    const auto peak = std::max_element(
        ticks.begin(), ticks.end(), [&](const pal_tick& a, const pal_tick& b) { return size(a) < size(b); });
    return peak == ticks.end() ? 0.0 : 1e-3 * peak->path_tick;
}

view::Source view_source(const scene::World& world, const table::StiffnessField& field,
                         std::vector<pal_tick> ticks) {
    view::Source source;
    for (const Vector3d& p : world.cloud.points_m) source.body.points_m.push_back(p.cast<float>());
    for (const Vector3d& n : world.cloud.normals) source.body.normals.push_back(n.cast<float>());
    source.body.stiffness_n_per_m = field.known_n_per_m();
    if (!world.nodules.empty()) {
        source.body.focus_m = world.nodules.front().at_m.cast<float>();
    } else if (!world.path.empty()) {
        source.body.focus_m = world.path[world.path.size() / 2].foot.point_m.cast<float>();
    }
    source.title = world.scene.title;
    const std::size_t first = first_of_path(ticks);
    source.duration_s = ticks.empty() ? 0.0 : 1e-3 * static_cast<double>(ticks.size() - 1 - first);
    source.frame_at = [&world, ticks = std::move(ticks), first](double t_s) {
        view::Frame frame;
        frame.t_s = t_s;
        frame.tool_radius_m = static_cast<float>(world.scene.touch.tool_radius_m);
        if (ticks.empty()) {
            if (!world.path.empty()) frame.tool_m = world.on_object(world.path.front().tool_m).cast<float>();
            return frame;
        }
        const std::size_t at = tick_at(ticks, first, t_s);
        const pal_tick& tick = ticks[at];
        frame.tool_m = world.on_object(vec(tick.position_m).cast<double>()).cast<float>();
        frame.force_n = tick.truth_valid != 0 ? vec(tick.truth_force_n) : vec(tick.force_n);
        frame.depth_m = std::max(tick.depth_m, 0.0F);
        frame.k_n_per_m = tick.k_n_per_m;
        frame.rate_line = rate_line(tick, rate_hz(ticks, at));
        touch(world, tick, frame);
        return frame;
    };
    return source;
}

}  // namespace palpate::app
