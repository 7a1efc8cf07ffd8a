#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "common/frame.h"
#include "host/app/interrupt.hpp"
#include "host/app/run.hpp"

namespace palpate::app {

Prepared prepare(std::unique_ptr<scene::World> world, Progress& progress) {
    Prepared prepared{.world = std::move(world), .field = nullptr, .options = {}};
    prepared.field =
        std::make_unique<table::StiffnessField>(*prepared.world->surface, prepared.world->material);
    prepared.options = table::build_options(*prepared.world);
    const auto points = table::reachable_points(*prepared.world, *prepared.field, prepared.options);
    const std::string of = " of " + std::to_string(points.size()) + " points that the path can reach";
    prepared.field->bake(points, [&](std::size_t n) {
        stop_when_interrupted();
        progress.show("stiffness: " + std::to_string(n) + of);
    });
    progress.done("stiffness: " + std::to_string(prepared.field->n_solved()) + of);
    return prepared;
}

std::vector<DevicePoint> device_path(const scene::World& world) {
    std::vector<DevicePoint> path;
    for (const scene::Target& target : world.path) {
        path.push_back(
            {target.t_s,
             {target.tool_m.x() + PAL_WORKSPACE_CENTRE_X_M, target.tool_m.y() + PAL_WORKSPACE_CENTRE_Y_M,
              target.tool_m.z() + PAL_WORKSPACE_CENTRE_Z_M}});
    }
    return path;
}

std::string why_no_tables(const Prepared& prepared, const RunResult& result) {
    const auto& path = prepared.world->scene.hand.path;
    const bool wants_contact =
        std::any_of(path.begin(), path.end(), [](const auto& p) { return p.depth_m > 0.0; });
    if (!wants_contact || result.interrupted || !result.tables.empty()) return "";
    if (!result.refused_by_check.empty())
        return "every table was refused: " + result.refused_by_check.front().why;
    if (result.n_tables_refused == 0) return "";
    const std::string& why = result.why_no_plate;
    return "no table could be built: where the tool was the skin is not smooth or ends; for a double wall "
           "set "
           "object.sides = \"outer\"" +
           (why.empty() ? "" : "; some points have no plate: " + why);
}

std::uint32_t path_ticks(const scene::World& world) {
    constexpr std::uint32_t TAIL_TICKS = 100;
    return static_cast<std::uint32_t>(std::lround(1e3 * scene::duration_s(world.scene))) + TAIL_TICKS;
}

std::uint64_t monotonic_ns() {
    return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
}

std::string status_line(const pal_tick& tick, double rate_hz) {
    const double force =
        std::sqrt(static_cast<double>(tick.force_n[0] * tick.force_n[0] + tick.force_n[1] * tick.force_n[1] +
                                      tick.force_n[2] * tick.force_n[2]));
    std::array<char, 16> depth{"   - "};
    if ((tick.faults & (PAL_FAULT_TABLE_MISSING | PAL_FAULT_TABLE_LEFT)) == 0) {
        std::snprintf(depth.data(), depth.size(), "%5.2f",
                      1e3 * std::max(0.0, static_cast<double>(tick.depth_m)));
    }
    std::array<char, 16> rate{"   -"};
    if (rate_hz > 0.0) std::snprintf(rate.data(), rate.size(), "%4.0f", rate_hz);
    std::array<char, 160> text{};
    std::snprintf(text.data(), text.size(), "%s Hz  depth %s mm  force %5.2f N  table %3u ms  missed %u  %s",
                  rate.data(), depth.data(), force, tick.table_age_ticks, tick.n_missed,
                  record::state_word(tick.state).c_str());
    return text.data();
}

}  // namespace palpate::app
