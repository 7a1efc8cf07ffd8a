#include <sched.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>

#include "common/frame.h"
#include "host/app/commands.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/live.hpp"
#include "host/app/progress.hpp"
#include "host/app/run.hpp"
#include "host/latency/publications.hpp"
#include "host/latency/report.hpp"
#include "host/record/record.hpp"

namespace palpate::app {
namespace {

constexpr std::uint32_t MARK_EVERY_TICKS = 50;  // longer than a fade: each mark is seen alone
constexpr std::uint32_t SETTLE_TICKS = 500;     // after the start ramp, not counted: the hand is still moving
constexpr long RAMP_TICKS = 200;
// A marked table pushes towards the user with STIFFNESS times a depth. Soft, so that a hand that trembles by
// one encoder count (0.04 mm) does not change a motor word by itself.
constexpr float MARK_STIFFNESS_N_PER_M = 20.0F;
constexpr std::array<float, 2> MARK_DEPTHS_M = {0.010F, 0.020F};  // 0.2 N and 0.4 N in turn

struct LatencyOptions {
    std::string device = "usb", firmware, delta, out, policy;
    double seconds = 10.0;
    int cpu = -1, priority = -1;
    bool json = false, quiet = false;
};

/// Why this process cannot run on `cpu` alone; empty when it can.
std::string refusal_of_cpu(int cpu) {
    const long n_cpus = sysconf(_SC_NPROCESSORS_CONF);
    if (cpu >= n_cpus) return "this machine has processors 0 to " + std::to_string(n_cpus - 1);
    cpu_set_t before, wanted;
    CPU_ZERO(&wanted);
    CPU_SET(static_cast<std::size_t>(cpu), &wanted);
    if (sched_getaffinity(0, sizeof before, &before) != 0) return "";
    if (sched_setaffinity(0, sizeof wanted, &wanted) != 0)
        return std::string("not for this process (") + std::strerror(errno) + "); see cpuset and taskset";
    sched_setaffinity(0, sizeof before, &before);
    return "";
}

/// What palpate-loop would refuse, said before anything starts: nothing would be measured.
void require_loop_options(const LatencyOptions& options) {
    const bool fifo = options.policy.empty() || options.policy == "fifo";
    if (options.priority >= 0 && !fifo) throw LiveInputError("--priority belongs to --policy fifo");
    if (options.cpu < 0) return;
    const std::string words = options.policy == "deadline"
                                  ? "the kernel keeps no thread with a deadline on one processor"
                                  : refusal_of_cpu(options.cpu);
    if (!words.empty()) throw LiveInputError("--cpu " + std::to_string(options.cpu) + ": " + words);
}

/// A flat skin whose force at `at_m` is the mark's, the same in every place nearby but for its depth.
std::unique_ptr<pal_table> marked_table(const pal_tick& record, float depth_m) {
    constexpr std::uint32_t N_NODES = PAL_TABLE_NODES_MIN;
    constexpr std::uint32_t N_PLANE = (N_NODES + 2) * (N_NODES + 2);
    auto table = std::make_unique<pal_table>();
    table->tick = record.tick;
    table->law = PAL_LAW_POTENTIAL;
    table->n_nodes = N_NODES;
    table->spacing_m = 0.02F;
    table->valid_radius_m = 0.03F;
    table->depth_scale_m = 1.0F;
    for (std::size_t i = 0; i < 3; ++i) {
        table->p0_m[i] = table->made_for_m[i] = record.position_m[i];
        table->axes[4 * i] = 1.0F;  // e3 = z, towards the user
    }
    for (std::uint32_t i = 0; i < N_PLANE; ++i) {
        table->coef[i] = depth_m;
        table->coef[N_PLANE + i] = MARK_STIFFNESS_N_PER_M;
        table->coef[2 * N_PLANE + i] = 1.0F;
    }
    return table;
}

LiveOptions live_options(const LatencyOptions& options) {
    LiveOptions live{.device = options.device,
                     .firmware = options.firmware,
                     .delta = options.delta,
                     .sim_arguments = {"--grip", "firm", "--ramp-ticks", std::to_string(RAMP_TICKS)},
                     .force_max_n = 2.0,
                     .ramp_ticks = RAMP_TICKS,
                     .loop_arguments = {}};
    const auto pass = [&](const char* name, const std::string& value) {
        live.loop_arguments.insert(live.loop_arguments.end(), {name, value});
    };
    if (options.cpu >= 0) pass("--cpu", std::to_string(options.cpu));
    if (options.priority >= 0) pass("--priority", std::to_string(options.priority));
    if (!options.policy.empty()) pass("--policy", options.policy);
    return live;
}

/// One measurement: watches the loop and publishes marked tables until the time is over.
class LatencyRun {
public:
    LatencyRun(const LatencyOptions& options, const Scratch& scratch, const std::filesystem::path& log,
               Progress& progress)
        : options_(&options),
          progress_(&progress),
          live_(live_options(options), scratch, log),
          publisher_(live_.link()) {}

    /// What ended it early, in words; empty when it ran its time.
    [[nodiscard]] std::string run() {
        const auto last_tick = [this] { return begun_tick_ + ticks_wanted(); };
        for (std::uint32_t beat = 1; begun_tick_ == 0 || newest_.tick < last_tick(); ++beat) {
            pal_link_store(&live_.link().host.heartbeat, beat);
            drain();
            const std::string failure = live_.failure();
            if (!failure.empty()) {
                const TakeOver over = live_.take_over();
                return failure + "; " + over.words;
            }
            if (interrupted()) return "interrupted";
            if (live_.simulated() && begun_tick_ == 0 && newest_.tick > HOMING_TICKS_MAX)
                return "the simulated device did not home within 10 s";
            std::this_thread::sleep_for(LOOK_EVERY);
        }
        return "";
    }

    /// Ends the loop, and measures.
    [[nodiscard]] latency::Report report(latency::Machine machine, double stolen_before_s) {
        const bool ended = live_.stop();
        drain();
        const latency::LoopWords words = latency::loop_words(live_.link().loop);
        if (!ended) progress_->done("palpate-loop did not end when asked to");
        const std::optional<double> stolen = latency::stolen_s();
        return latency::make_report(std::move(machine),
                                    stolen ? std::optional(*stolen - stolen_before_s) : std::nullopt, words,
                                    meter_.result(publications_));
    }

private:
    [[nodiscard]] std::uint32_t ticks_wanted() const {
        return static_cast<std::uint32_t>(std::lround(1e3 * options_->seconds));
    }

    void drain() {
        pal_tick record{};
        while (pal_state_ring_read(&live_.link().ticks, &reader_, &record)) {
            newest_ = record;
            if (record.state == PAL_STATE_ENABLED && enabled_tick_ == 0) enabled_tick_ = record.tick;
            const bool settled = enabled_tick_ != 0 && record.tick >= enabled_tick_ + SETTLE_TICKS;
            if (settled && begun_tick_ == 0) begun_tick_ = record.tick;
            if (begun_tick_ != 0 && record.tick - begun_tick_ < ticks_wanted()) meter_.add(record);
        }
        if (begun_tick_ != 0 && newest_.tick - marked_tick_ >= MARK_EVERY_TICKS) mark();
        if (begun_tick_ == 0) {
            progress_->show("waiting for the device: " + record::state_word(newest_.state) +
                            (live_.simulated() ? "" : "; hold the grip, push it in and pull it out"));
        } else {
            const double s = 1e-3 * (newest_.tick - begun_tick_);
            progress_->show("measuring: " + std::to_string(std::lround(s)) + " of " +
                            std::to_string(std::lround(options_->seconds)) + " s, missed " +
                            std::to_string(newest_.n_missed));
        }
    }

    void mark() {
        const std::uint64_t at_ns = monotonic_ns();
        const pal_table* published =
            publisher_.publish(marked_table(newest_, MARK_DEPTHS_M.at(n_marks_++ % 2)), newest_.tick);
        if (published == nullptr) throw std::logic_error(publisher_.refused().back().why);
        // The first one begins the contact, and a force that is new has a start ramp: it marks nothing.
        publications_[published->id] = {
            .t_ns = at_ns, .made_for_tick = published->tick, .marked = n_marks_ > 1};
        marked_tick_ = newest_.tick;
    }

    const LatencyOptions* options_;
    Progress* progress_;
    Live live_;
    link::Publisher publisher_;
    latency::Meter meter_;
    latency::Publications publications_;
    pal_state_reader reader_{};
    pal_tick newest_{};
    std::uint32_t enabled_tick_ = 0, begun_tick_ = 0, marked_tick_ = 0, n_marks_ = 0;
};

void write_results(const std::filesystem::path& directory, const latency::Report& report,
                   const std::string& text, const nlohmann::json& json, Progress& progress) {
    record::write_file(directory / "latency.txt", text);
    record::write_file(directory / "latency.json", record::json_text(json, 1) + "\n");
    record::write_file(directory / "wake_up.hist",
                       latency::cyclictest_text(report.measured.wake_up_raw.histogram));
    const std::string words =
        latency::draw_histograms(directory / "latency.png", report, "palpate device latency");
    if (!words.empty()) progress.done(words);
}

int measure_latency(const LatencyOptions& options) {
    catch_interrupts();
    require_loop_options(options);
    const Scratch scratch;
    require_firmware(live_options(options), scratch);
    std::optional<record::OutputDirectory> out;
    if (!options.out.empty()) out.emplace(options.out);
    const std::filesystem::path log = out ? out->path() / "log.txt" : scratch / "log";
    Progress progress(options.quiet);
    latency::Machine machine = latency::machine_facts();
    const double stolen_s = latency::stolen_s().value_or(0.0);
    LatencyRun run(options, scratch, log, progress);
    const std::string failure = run.run();
    const latency::Report report = run.report(std::move(machine), stolen_s);
    progress.leave();
    const std::string text = latency::text_of(report);
    nlohmann::json json = latency::json_of(report);
    json["device"] = options.device;
    json["failure"] = failure;
    if (out) {
        write_results(out->path(), report, text, json, progress);
        out->commit();
    }
    if (options.json) {
        std::cout << record::json_text(json, 1) << '\n';
    } else {
        std::cout << text;
    }
    if (!std::cout.flush()) throw std::runtime_error("stdout cannot be written");
    if (failure == "interrupted") return 130;
    if (!failure.empty()) {
        std::cerr << "palpate: " << failure << '\n';
        return 3;
    }
    return report.verdict.suitability == latency::Suitability::NOT_SUITABLE ? 1 : 0;
}

}  // namespace

void add_latency(CLI::App& device, std::function<int()>& chosen) {
    auto options = std::make_shared<LatencyOptions>();
    CLI::App* command = device.add_subcommand(
        "latency", "wake-up, tick, sensor to force, publication to motor word: measured, with a verdict");
    command->add_option("--device", options->device, "usb[:SERIAL], or sim: a simulated one (usb)")
        ->check([](const std::string& name) { return refusal_of_device(name); });
    command->add_option("--firmware", options->firmware,
                        "with usb: the boot image (palpate device firmware)");
    command->add_option("--delta", options->delta, "with usb: another delta's geometry and gains, TOML");
    command->add_option("--seconds", options->seconds, "how long to measure (10)")
        ->check(CLI::Range(1.0, 86400.0))
        ->check(refusal_of_not_finite);
    command->add_option("--cpu", options->cpu, "processor for the loop; any by default")
        ->check(CLI::Range(0, 1023));
    command->add_option("--policy", options->policy, "of the loop: fifo, deadline or other (fifo)")
        ->check(CLI::IsMember({"fifo", "deadline", "other"}));
    command->add_option("--priority", options->priority, "of the loop, with fifo (80)")
        ->check(CLI::Range(1, 99));
    command->add_option("--out", options->out,
                        "folder for latency.txt, .json, .png, wake_up.hist and log.txt");
    command->add_flag("--json", options->json, "JSON on stdout (schema palpate.latency/1) instead of text");
    command->add_flag("--quiet", options->quiet, "no progress");
    command->footer(
        "The loop runs as in palpate run. Every 50 ms it is given a table that pushes with 0.2 N or 0.4 N in "
        "turn:\n"
        "the time from its publication to the first other motor word is what a new table takes to be felt.\n"
        "Hold a real device's grip meanwhile.\n\n"
        "Examples:\n"
        "  palpate device latency --device sim --seconds 60 --out out/latency\n"
        "  palpate-falcon-sim run --grip firm -- palpate device latency --firmware boot.bin\n\n"
        "Exit codes: 0 suitable, marginal or not known, 1 not suitable, 2 bad input, 3 the device or the "
        "loop "
        "failed, 130 interrupted.");
    command->callback([options, &chosen] { chosen = [options] { return measure_latency(*options); }; });
}

}  // namespace palpate::app
