#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "host/app/interrupt.hpp"
#include "host/app/run.hpp"
#include "host/link/publisher.hpp"
#include "sim/stand/stand.h"

namespace palpate::app {
namespace {

constexpr std::uint32_t HOMING_TICKS_MAX = 5000;  // the ramp before the path comes on top

struct FreeStand {
    void operator()(pal_stand* stand) const { pal_stand_free(stand); }
};

std::vector<pal_hand_point> hand_points(const scene::World& world) {
    std::vector<pal_hand_point> points;
    for (const DevicePoint& p : device_path(world))
        points.push_back({p.t_s, {p.at_m[0], p.at_m[1], p.at_m[2]}});
    return points;
}

pal_stand_config stand_config(const scene::Scene& scene, const std::vector<pal_hand_point>& path) {
    pal_stand_config config{};
    config.falcon = pal_falcon_sim_config_default();
    pal_falcon_sim_seed(&config.falcon, scene.run.seed);
    config.hand.mass_kg = scene.hand.mass_kg;
    config.hand.stiffness_n_per_m = scene.hand.stiffness_n_per_m;
    config.hand.damping_n_s_per_m = scene.hand.damping_n_s_per_m;
    config.hand.weight_n =
        scene.hand.stiffness_n_per_m > 0.0 ? config.falcon.mass_kg * config.falcon.gravity_m_per_s2 : 0.0;
    config.hand.path = path.data();
    config.hand.n_points = static_cast<std::uint32_t>(path.size());
    config.ramp_ticks = static_cast<std::uint32_t>(std::lround(1e3 * scene.touch.ramp_s));
    config.hand.wait_ticks = std::max(config.ramp_ticks, 1U);
    config.hand.home_in_m[2] = PAL_HAND_HOME_IN_Z_M;
    config.force_max_n = static_cast<float>(scene.touch.force_max_n);
    return config;
}

/// A table on its way: asked for at one tick, published some ticks later.
struct Underway {
    std::unique_ptr<pal_table> table;
    std::uint32_t due_tick = 0;
};

}  // namespace

RunResult run_virtual(const Prepared& prepared, const Operator& rig, Progress& progress,
                      const std::function<void(pal_table&)>& before_publish) {
    const scene::World& world = *prepared.world;
    const std::vector<pal_hand_point> path = hand_points(world);
    const auto link = std::make_unique<pal_link>();
    pal_link_init(link.get(), 1);
    const pal_stand_config config = stand_config(world.scene, path);
    const std::unique_ptr<pal_stand, FreeStand> stand(pal_stand_new(&config, link.get()));
    if (!stand) throw std::runtime_error("the simulated Falcon cannot start from this scene");
    table::Server server(world, *prepared.field, prepared.options);
    link::Publisher publisher(*link);
    record::Digest digest;
    RunResult result;
    result.start_unix_ns =
        static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
    result.start_monotonic_ns = monotonic_ns();
    Underway underway;
    std::uint32_t left = HOMING_TICKS_MAX + config.ramp_ticks;
    const std::uint32_t after_begin = path_ticks(world);
    for (std::uint32_t tick = 0; left > 0; ++tick, --left) {
        const pal_table* published = nullptr;
        if (underway.table && tick >= underway.due_tick) {
            before_publish(*underway.table);
            published = publisher.publish(std::move(underway.table), tick);
        } else if (!underway.table) {
            published = publisher.refresh(tick);
        }
        if (published != nullptr) {
            digest.table(*published);
            result.tables[published->id] = record::table_bytes(*published);
        }
        pal_link_store(&link->host.enable, rig.enable() ? 1 : 0);
        pal_link_store(&link->host.estop, rig.estop() ? 1 : 0);
        pal_tick record{};
        pal_stand_tick(stand.get(), &record);
        digest.tick(record);
        result.ticks.push_back(record);
        rig.show(record, 1000.0);
        if (record.path_tick == 1) left = after_begin;
        if (!underway.table) underway = {server.update(record), tick + 1 + world.scene.solver.delay_ticks};
        if (tick % 64 == 0)
            progress.show("virtual " + std::to_string(tick) + " ms  " + status_line(record, 1000.0));
        if (interrupted()) {
            result.interrupted = true;
            break;
        }
    }
    result.end_monotonic_ns = monotonic_ns();
    result.digest_io = digest.io();
    result.digest_state = digest.state();
    result.n_tables_built = server.n_built();
    result.n_tables_refused = server.n_refused();
    result.refused_by_check = publisher.refused();
    result.why_no_plate = prepared.field->why_not();
    result.no_tables = why_no_tables(prepared, result);
    if (result.ticks.empty() || result.ticks.back().path_tick == 0) {
        if (!result.interrupted && !world.path.empty()) result.failure = "the device did not home within 5 s";
    }
    return result;
}

report::LoopModel loop_model(const Prepared& prepared) {
    return {.table_force_n =
                [](const pal_table& table, const Eigen::Vector3d& at_m) {
                    const Eigen::Vector3f at = at_m.cast<float>();
                    Eigen::Vector3f force = Eigen::Vector3f::Zero();
                    pal_stand_table_force(&table, at.data(), force.data());
                    return Eigen::Vector3d(force.cast<double>());
                },
            .fresh_table = [&prepared](const Eigen::Vector3d& at_m,
                                       const contact::Foot& foot) -> std::unique_ptr<pal_table> {
                const scene::World& world = *prepared.world;
                table::BuildOptions options = prepared.options;
                options.n_nodes = 7;  // the look-up reads four by four; the rest would only cost time
                auto table =
                    table::build(*world.surface, *prepared.field, options, world.on_object(at_m), foot, 0);
                if (table) {
                    table->id = 1;
                    pal_table_seal(table.get());
                }
                return table;
            }};
}

}  // namespace palpate::app
