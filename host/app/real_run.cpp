#include <chrono>
#include <cmath>
#include <fstream>
#include <sstream>
#include <thread>

#include "host/app/flight.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/live.hpp"
#include "host/app/run.hpp"
#include "host/app/table_process.hpp"

namespace palpate::app {
namespace {

using Clock = std::chrono::steady_clock;

std::string millionths(double value) {
    return std::to_string(std::llround(1e6 * value));
}

void write_path(const std::filesystem::path& file, const std::vector<DevicePoint>& path) {
    std::ofstream out(file);
    out << "palpate-path 1\n";
    for (const DevicePoint& p : path) {
        out << millionths(p.t_s) << ' ' << millionths(p.at_m[0]) << ' ' << millionths(p.at_m[1]) << ' '
            << millionths(p.at_m[2]) << '\n';
    }
    if (!out) throw std::runtime_error(file.string() + ": cannot be written");
}

std::string grip_text(const scene::Hand& hand) {
    std::ostringstream out;
    out << hand.mass_kg << ',' << hand.stiffness_n_per_m << ',' << hand.damping_n_s_per_m;
    return out.str();
}

std::uint32_t ramp_ticks(const scene::Scene& scene) {
    return static_cast<std::uint32_t>(std::lround(1e3 * scene.touch.ramp_s));
}

/// All but the simulated hand.
LiveOptions live_options(const scene::Scene& scene) {
    const scene::Device& device = scene.device;
    LiveOptions options{.device = device.backend,
                        .firmware = device.firmware,
                        .delta = device.model == scene::Device{}.model ? "" : device.model,
                        .sim_arguments = {},
                        .force_max_n = scene.touch.force_max_n,
                        .ramp_ticks = ramp_ticks(scene),
                        .loop_arguments = {}};
    if (!device.serial.empty()) options.device += ":" + device.serial;
    return options;
}

LiveOptions live_options(const Prepared& prepared, const Scratch& scratch) {
    const scene::Scene& scene = prepared.world->scene;
    LiveOptions options = live_options(scene);
    if (scene.device.backend != "sim") return options;
    const std::filesystem::path path = scratch / "path";
    write_path(path, device_path(*prepared.world));
    options.sim_arguments = {"--path",       path.string(),
                             "--grip",       grip_text(scene.hand),
                             "--ramp-ticks", std::to_string(std::max(1L, options.ramp_ticks)),
                             "--seed",       std::to_string(scene.run.seed)};
    return options;
}

/// Reads the loop's records and numbers the path's ticks: the path begins a ramp after homing, here as in the
/// device.
class Watcher {
public:
    Watcher(const pal_link& link, std::uint32_t ramp_ticks) : link_(&link), ramp_ticks_(ramp_ticks) {}
    /// Appends what is new; the newest record, if any.
    const pal_tick* drain(std::vector<pal_tick>& ticks) {
        const std::size_t before = ticks.size();
        pal_tick record{};
        while (pal_state_ring_read(&link_->ticks, &reader_, &record)) {
            if (homed_tick_ == 0 && record.state != PAL_STATE_HOMING && record.state != PAL_STATE_DISABLED) {
                homed_tick_ = record.tick;
            }
            const std::uint32_t begun = homed_tick_ + ramp_ticks_;
            if (homed_tick_ != 0 && record.tick > begun) record.path_tick = record.tick - begun;
            ticks.push_back(record);
        }
        return ticks.size() > before ? &ticks.back() : nullptr;
    }
    [[nodiscard]] std::uint32_t n_dropped() const { return reader_.n_dropped; }

private:
    const pal_link* link_;
    std::uint32_t ramp_ticks_, homed_tick_ = 0;
    pal_state_reader reader_{};
};

/// Ticks per second over the last half second or so.
class Rate {
public:
    double now(std::size_t n_ticks) {
        const auto at = Clock::now();
        const double s = std::chrono::duration<double>(at - since_).count();
        if (s > 0.5) {
            hz_ = static_cast<double>(n_ticks - n_) / s;
            since_ = at;
            n_ = n_ticks;
        }
        return hz_;
    }

private:
    Clock::time_point since_ = Clock::now();
    std::size_t n_ = 0;
    double hz_ = 0.0;
};

/// Whether the run is over: the path's end, or of a person's the duration, if the scene has one.
bool finished(const scene::World& world, bool simulated, const std::vector<pal_tick>& ticks) {
    if (ticks.empty()) return false;
    const pal_tick& last = ticks.back();
    if (simulated) {
        const std::uint32_t begins_at_most = HOMING_TICKS_MAX + ramp_ticks(world.scene);
        return last.path_tick > path_ticks(world) || (last.path_tick == 0 && last.tick > begins_at_most);
    }
    const double duration_s = world.scene.run.duration_s;
    return duration_s > 0.0 && last.path_tick > std::lround(1e3 * duration_s);
}

/// Whether forces are still off at the end for a device that was lost.
bool device_is_lost(const std::vector<pal_tick>& ticks) {
    return !ticks.empty() && (ticks.back().stop & PAL_FAULT_DEVICE_LOST) != 0;
}

nlohmann::json restarts_json(const std::vector<TableRestart>& restarts) {
    nlohmann::json all = nlohmann::json::array();
    for (const TableRestart& restart : restarts) {
        nlohmann::json one = {{"why", restart.why}, {"noticed_tick", restart.noticed_tick}};
        one["table_after_s"] = nullptr;
        if (restart.served_ns != 0)
            one["table_after_s"] = 1e-9 * static_cast<double>(restart.served_ns - restart.noticed_ns);
        else
            one["table_after_s_why"] = "none was due before the end";
        all.push_back(one);
    }
    return all;
}

/// Watches the loop, the device and the table builder until the run is over or one of them ends it.
class RealRun {
public:
    RealRun(const Prepared& prepared, Progress& progress, const Scratch& scratch, const RealOutput& output)
        : prepared_(&prepared),
          progress_(&progress),
          live_(live_options(prepared, scratch), scratch, output.directory / "log.txt",
                [&](const std::string& name, const pal_link& link) {
                    const std::string words = salvage_flight(output.directory, output.header, name, link);
                    if (!words.empty()) progress.done(words);
                }),
          tables_(prepared, live_.link()),
          watcher_(live_.link(), ramp_ticks(prepared.world->scene)),
          flight_(output.directory, output.header) {}

    RunResult run(const Operator& rig) {
        result_.start_unix_ns =
            static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
        result_.start_monotonic_ns = monotonic_ns();
        Rate rate;
        for (std::uint32_t beat = 1; !finished(*prepared_->world, live_.simulated(), result_.ticks); ++beat) {
            obey(rig, beat);
            if (const pal_tick* newest = watcher_.drain(result_.ticks)) {
                const double hz = rate.now(result_.ticks.size());
                rig.show(*newest, hz);
                progress_->show("real time  " + status_line(*newest, hz));
            }
            if (!all_well()) break;
            std::this_thread::sleep_for(LOOK_EVERY);
        }
        end();
        return std::move(result_);
    }

private:
    void obey(const Operator& rig, std::uint32_t beat) {
        pal_link_host& words = live_.link().host;
        pal_link_store(&words.heartbeat, beat);
        pal_link_store(&words.enable, rig.enable() ? 1 : 0);
        if (rig.estop()) pal_link_store(&words.estop, 1);
    }

    bool all_well() {
        const std::size_t n_restarts = tables_.restarts().size();
        tables_.look(result_.ticks);
        if (tables_.restarts().size() > n_restarts)
            progress_->done("the table builder ended (" + tables_.restarts().back().why +
                            "); a new one goes on");
        flight_.look(result_.ticks, tables_.report().tables);
        result_.failure = live_.failure();
        if (!result_.failure.empty()) {
            const TakeOver over = live_.take_over();
            watcher_.drain(result_.ticks);
            flight_.look(result_.ticks, tables_.report().tables);
            flight_.note(result_.failure, result_.ticks, tables_.report().tables);
            result_.supervision["take_over"] = {
                {"done", over.done}, {"took_s", over.took_s}, {"words", over.words}};
        }
        if (result_.failure.empty()) result_.failure = tables_.failure();
        result_.interrupted = interrupted() && result_.failure.empty();
        return result_.failure.empty() && !result_.interrupted;
    }

    void end() {
        const bool ended = live_.stop();  // before the table at work is waited for: the force ends now
        if (!ended && result_.failure.empty()) result_.failure = "palpate-loop did not end when asked to";
        tables_.stop();
        watcher_.drain(result_.ticks);
        flight_.look(result_.ticks, tables_.report().tables);
        result_.end_monotonic_ns = monotonic_ns();
        result_.device_status = live_.device_at_rest();
        const TableProcess::Report& report = tables_.report();
        result_.tables = report.tables;
        result_.published_ns = report.published_ns;
        result_.n_tables_built = report.n_built;
        result_.n_tables_refused = report.n_refused_places;
        result_.refused_by_check = report.refused;
        result_.why_no_plate = report.why_no_plate;
        result_.supervision["table_builder_restarts"] = restarts_json(tables_.restarts());
        result_.supervision["flight_records"] = flight_.files();
        result_.supervision["n_records_lost"] = watcher_.n_dropped();
        const bool homed = !result_.ticks.empty() && result_.ticks.back().path_tick > 0;
        if (result_.failure.empty() && !result_.interrupted && !homed)
            result_.failure = "the device did not home within 10 s";
        if (result_.failure.empty() && !live_.simulated() && device_is_lost(result_.ticks))
            result_.failure = "the device was lost, and forces stayed off to the end; see log.txt";
        if (live_.simulated()) result_.no_tables = why_no_tables(*prepared_, result_);
    }

    const Prepared* prepared_;
    Progress* progress_;
    Live live_;
    TableProcess tables_;
    Watcher watcher_;
    FlightRecorder flight_;
    RunResult result_;
};

}  // namespace

void require_device_input(const scene::Scene& scene, const Scratch& scratch) {
    require_firmware(live_options(scene), scratch);
}

RunResult run_real(const Prepared& prepared, const Operator& rig, Progress& progress, const Scratch& scratch,
                   const RealOutput& output) {
    return RealRun(prepared, progress, scratch, output).run(rig);
}

}  // namespace palpate::app
