/// One run of a scene: the same server, ring and step in virtual and in real time.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/link.h"
#include "host/app/progress.hpp"
#include "host/app/scratch.hpp"
#include "host/link/publisher.hpp"
#include "host/record/record.hpp"
#include "host/report/force_error.hpp"
#include "host/scene/world.hpp"
#include "host/table/server.hpp"

namespace palpate::app {

/// What an outside client (a test rig) sees and asks for during a run; all absent without one.
struct Operator {
    std::function<void(const pal_tick&, double rate_hz)> show = [](const pal_tick&, double) {};
    std::function<bool()> estop = [] { return false; };
    std::function<bool()> enable = [] { return true; };
};

/// A scene ready to be felt: its world and the stiffness that the path can reach.
struct Prepared {
    std::unique_ptr<scene::World> world;
    std::unique_ptr<table::StiffnessField> field;
    table::BuildOptions options;
};
/// Builds and bakes. Throws what world and cloud throw.
[[nodiscard]] Prepared prepare(std::unique_ptr<scene::World> world, Progress& progress);

struct RunResult {
    std::vector<pal_tick> ticks;
    std::map<std::uint64_t, record::TableBytes> tables;
    std::map<std::uint64_t, std::uint64_t> published_ns;  ///< by table, CLOCK_MONOTONIC; real time only
    std::string digest_io, digest_state;                  ///< empty in real time
    std::size_t n_tables_built = 0, n_tables_refused = 0;
    std::vector<link::Refused> refused_by_check;  ///< built, but not published: the loop would refuse them
    std::uint64_t start_unix_ns = 0, start_monotonic_ns = 0, end_monotonic_ns = 0;
    bool interrupted = false;
    std::string failure;        ///< a process or device that failed, in words; empty when all went well
    std::string no_tables;      ///< why a path that wants contact got no table at all; empty when it got one
    std::string why_no_plate;   ///< of the stiffness field, if some point had none
    std::string device_status;  ///< JSON line of the simulated device after a real run
    nlohmann::json supervision =
        nlohmann::json::object();  ///< real time: restarts, take-over, flight records
};

/// Lockstep: device, loop and host advance by ticks. `before_publish` may change a table on its way (tests
/// only).
[[nodiscard]] RunResult run_virtual(
    const Prepared& prepared, const Operator& rig, Progress& progress,
    const std::function<void(pal_table&)>& before_publish = [](pal_table&) {});

/// The loop's look-up and the table builder, as the error analysis needs them. Borrows `prepared`.
[[nodiscard]] report::LoopModel loop_model(const Prepared& prepared);

/// Where a run in real time leaves what cannot wait for its end: log.txt and the flight records, these with
/// `header`.
struct RealOutput {
    std::filesystem::path directory;
    nlohmann::json header;
};

/// Throws LiveInputError when the scene's device is a real one and something for it is missing.
void require_device_input(const scene::Scene& scene, const Scratch& scratch);

/// Processes by the wall clock: this one, which watches; the table builder, forked from it and forked anew
/// when it dies; palpate-loop; and palpate-falcon-sim unless the scene's device is a real one. A loop that
/// dies or stands still ends the run, with zero force sent to the device in its place.
[[nodiscard]] RunResult run_real(const Prepared& prepared, const Operator& rig, Progress& progress,
                                 const Scratch& scratch, const RealOutput& output);

/// The hand's path in the device frame, one point every 10 ms.
struct DevicePoint {
    double t_s, at_m[3];
};
[[nodiscard]] std::vector<DevicePoint> device_path(const scene::World& world);

/// Why a path that wants contact got no table at all, in words; empty when it got one.
[[nodiscard]] std::string why_no_tables(const Prepared& prepared, const RunResult& result);

/// Ticks from a path's begin to the run's end, 100 after its own.
[[nodiscard]] std::uint32_t path_ticks(const scene::World& world);

/// CLOCK_MONOTONIC.
[[nodiscard]] std::uint64_t monotonic_ns();

/// "1000 Hz  depth  2.90 mm  force  1.45 N  table  12 ms  missed 0  enabled"; "-" for a rate that is not
/// known yet, and for the depth where no table tells it.
[[nodiscard]] std::string status_line(const pal_tick& tick, double rate_hz);

}  // namespace palpate::app
