#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <optional>

#include "host/app/build_info.hpp"
#include "host/app/commands.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/live.hpp"
#include "host/app/run.hpp"
#include "host/app/scratch.hpp"
#include "host/app/touch_picture.hpp"
#include "host/report/figures.hpp"
#include "host/report/pictures.hpp"
#include "host/scene/resolve.hpp"
#ifdef PALPATE_HAS_RIG
#include "host/app/rig_operator.hpp"
#endif

namespace palpate::app {
namespace {

using report::Json;

#ifdef PALPATE_HAS_RIG
constexpr bool HAS_RIG = true;
constexpr const char* RIG_HELP = "ADDR:PORT of a Modbus TCP server for a test rig, loopback only";
#else
constexpr bool HAS_RIG = false;
constexpr const char* RIG_HELP = "not in this build (PALPATE_RIG)";
#endif

struct RunOptions {
    std::string scene, clock, out, device, firmware, delta, rig, check = "sample";
    double duration_s = 0.0;
    std::vector<std::string> set;
    bool has_rig = false, json = false, quiet = false;
};

std::vector<std::string> overrides_of(const RunOptions& options) {
    std::vector<std::string> overrides = options.set;
    const std::size_t colon = options.device.find(':');
    const std::string backend = options.device.substr(0, colon);
    const std::string clock = options.clock.empty() && backend == "usb" ? "real" : options.clock;
    const auto set = [&](const char* key, const std::string& toml) {
        overrides.push_back(std::string(key) + "=" + toml);
    };
    if (!clock.empty()) set("run.clock", clock);
    if (!backend.empty()) set("device.backend", backend);
    // As TOML strings: a serial number or a file's name may look like a number.
    if (colon != std::string::npos)
        set("device.serial", scene::toml_string(options.device.substr(colon + 1)));
    if (!options.firmware.empty()) set("device.firmware", scene::toml_string(options.firmware));
    if (!options.delta.empty()) set("device.model", scene::toml_string(options.delta));
    if (options.duration_s > 0.0) set("run.duration_s", scene::number_text(options.duration_s));
    return overrides;
}

/// As a shell takes it for one word.
std::string shell_word(const std::string& text) {
    if (text.find_first_of(" \t\n\"'\\$`&|;<>()*?[]#~!{}") == std::string::npos) return text;
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

std::string command_of(const RunOptions& options) {
    std::string command = "palpate run " + options.scene;
    for (const std::string& set : overrides_of(options)) command += " --set " + shell_word(set);
    return command + " --check " + options.check;
}

Json object_json(const scene::World& world) {
    return {{"name", world.object_name},
            {"hash", record::hash_text(world.object_hash)},
            {"n_points", world.cloud.points_m.size()},
            {"n_repeated_points", world.cloud.n_duplicates},
            {"n_points_of_the_other_side", world.n_other_side},
            {"spacing_m", world.spacing_m}};
}

/// The force error with its words; an interrupt while it is computed leaves the run's other results as they
/// are.
void check_forces(const RunOptions& options, const Prepared& prepared, const RunResult& result,
                  std::span<const report::Touch> touches, Progress& progress, Json& summary) {
    const auto show = [&](double share) {
        stop_when_interrupted();
        progress.show("checking forces against the plate, " + std::to_string(std::lround(100.0 * share)) +
                      " %");
    };
    std::optional<report::ForceError> error;
    std::string why_not = result.tables.empty() ? "there was no table" : "there was no contact";
    if (prepared.world->scene.run.clock != "virtual") {
        why_not = "in real time the true place between two ticks is not known";
    } else if (result.interrupted) {
        why_not = "the run was interrupted";
    } else {
        try {
            error = report::force_error(*prepared.world, result.ticks, touches, result.tables,
                                        loop_model(prepared),
                                        options.check == "full" ? report::EVERY_TICK : report::SAMPLE, show);
        } catch (const Interrupted&) {
            why_not = "its computation was interrupted";
            summary["interrupted"] = true;
        }
    }
    report::add_force_error(summary, error, why_not);
}

void add_digests(const scene::World& world, const RunResult& result, Json& summary) {
    const bool is_virtual = world.scene.run.clock == "virtual";
    for (const auto& [name, digest] :
         {std::pair("digest_io", result.digest_io), std::pair("digest_state", result.digest_state)}) {
        summary[name] = is_virtual ? Json(digest) : Json(nullptr);
        if (!is_virtual) summary[std::string(name) + "_why"] = "real time is not repeatable";
    }
}

Json summary_of(const RunOptions& options, const Prepared& prepared, const RunResult& result,
                Progress& progress) {
    const scene::World& world = *prepared.world;
    Json summary = {{"schema", "palpate.summary/1"},
                    {"verdict", nullptr},
                    {"verdict_reasons", Json::array()},
                    {"stop", nullptr},
                    {"failure", result.failure.empty() ? result.no_tables : result.failure},
                    {"interrupted", result.interrupted}};
    const std::vector<report::Touch> touches = report::touches(world, result.ticks);
    check_forces(options, prepared, result, touches, progress, summary);
    const report::StiffnessRatio ratio = report::stiffness_ratio(world, result.ticks, touches);
    summary["stiffness_ratio"] = ratio.value ? Json(*ratio.value) : Json(nullptr);
    if (!ratio.value) summary["stiffness_ratio_why"] = ratio.why;
    summary["stiffness_ratio_ticks"] = {{"over", ratio.n_over}, {"beside", ratio.n_beside}};
    add_digests(world, result, summary);
    summary.update(report::run_figures(world, result.ticks, touches));
    summary["tables"] = {{"built", result.n_tables_built},
                         {"published", result.tables.size()},
                         {"refused_places", result.n_tables_refused},
                         {"refused_by_check", result.refused_by_check.size()}};
    if (!result.refused_by_check.empty())
        summary["tables"]["refused_by_check_why"] = result.refused_by_check.front().why;
    summary["stiffness_points"] = {{"solved", prepared.field->n_solved()},
                                   {"saddles", prepared.field->n_saddles()}};
    if (!result.device_status.empty()) {
        summary["device"] = Json::parse(result.device_status, nullptr, false);
        if (summary["device"].is_discarded()) summary["device"] = {{"no_answer", result.device_status}};
    }
    if (!result.supervision.empty()) summary["supervision"] = result.supervision;
    summary.update(Json{
        {"title", world.scene.title},
        {"clock", world.scene.run.clock},
        {"object", object_json(world)},
        {"scene_hash", record::hash_text(world.scene.hash)},
        {"source_hash", record::hash_text(world.source_hash)},
        {"command", command_of(options)},
        {"palpate", PALPATE_VERSION},
        {"build", PALPATE_BUILD},
        {"started_utc", record::utc_text(static_cast<std::time_t>(result.start_unix_ns / 1'000'000'000U))},
        {"duration_wall_s",
         1e-9 * static_cast<double>(result.end_monotonic_ns - result.start_monotonic_ns)}});
    return summary;
}

/// Sets "verdict": what failed, or "pass". A real-time run is measured, not judged. Returns the exit code.
int judge(const scene::World& world, const RunResult& result, Json& summary) {
    const bool judged = world.scene.run.clock == "virtual", interrupted = summary["interrupted"];
    const std::vector<std::string> failed =
        judged ? report::failed_expectations(world.scene, summary) : std::vector<std::string>{};
    const bool fails = !failed.empty() || !result.no_tables.empty();
    summary["verdict_reasons"] = failed;
    summary["verdict"] = !result.failure.empty() ? "fail"
                         : interrupted           ? "interrupted"
                         : fails                 ? "fail"
                         : judged                ? "pass"
                                                 : "measured";
    if (!result.failure.empty()) return 3;
    if (interrupted) return 130;
    return fails ? 1 : 0;
}

/// What is known before the first tick.
nlohmann::json record_header(const RunOptions& options, const Prepared& prepared,
                             const std::string& scene_toml) {
    const scene::World& world = *prepared.world;
    return {{"schema", "palpate.record/1"},
            {"palpate", PALPATE_VERSION},
            {"build", PALPATE_BUILD},
            {"command", command_of(options)},
            {"scene_hash", record::hash_text(world.scene.hash)},
            {"scene", scene_toml},
            {"object", object_json(world)},
            {"device", world.scene.device.backend == "sim" ? "simulated novint-falcon"
                                                           : world.scene.device.model + " on the USB"}};
}

/// What is known after the last.
void add_times(nlohmann::json& header, const RunResult& result) {
    header["started_utc"] = record::utc_text(static_cast<std::time_t>(result.start_unix_ns / 1'000'000'000U));
    header["start_unix_ns"] = result.start_unix_ns;
    header["start_monotonic_ns"] = result.start_monotonic_ns;
    header["end_monotonic_ns"] = result.end_monotonic_ns;
    if (!result.published_ns.empty()) {
        nlohmann::json& published = header["published_ns"] = nlohmann::json::array();
        for (const auto& [id, at_ns] : result.published_ns) published.push_back({id, at_ns});
    }
}

std::filesystem::path output_directory(const RunOptions& options) {
    if (!options.out.empty()) return options.out;
    return std::filesystem::path("out") / std::filesystem::path(options.scene).stem();
}

void write_results(const std::filesystem::path& directory, const nlohmann::json& header,
                   const Prepared& prepared, const RunResult& result, Progress& progress) {
    record::write_file(directory / "scene.toml", header["scene"].get<std::string>());
    record::write(directory / "run.palrec", {header, result.ticks, result.tables});
    record::write_ticks_csv(directory / "ticks.csv", result.ticks);
    record::write_ticks_json(directory / "ticks.json");
    record::write_events_csv(directory / "events.csv", result.ticks);
    const std::string words = report::draw_pictures(directory, prepared.world->scene.title, result.ticks);
    if (!words.empty()) progress.done(words);
    const std::string more = draw_touch(directory / "touch.png", prepared, result);
    if (!more.empty()) progress.done(more);
}

/// A figure of the summary for a person, or why there is none.
std::string figure(const Json& summary, const std::string& name, double times, const char* unit) {
    if (!summary[name].is_number()) return "not known (" + summary[name + "_why"].get<std::string>() + ")";
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.2f%s", times * summary[name].get<double>(), unit);
    return text.data();
}

void say(const Json& summary, const std::filesystem::path& directory) {
    std::cerr << "verdict: " << summary["verdict"].get<std::string>() << '\n';
    const auto failure = summary["failure"].get<std::string>();
    if (!failure.empty()) std::cerr << "  " << failure << '\n';
    for (const auto& reason : summary["verdict_reasons"])
        std::cerr << "  " << reason.get<std::string>() << '\n';
    std::cerr << "force error, rms: " << figure(summary, "force_error_rms_relative", 100.0, " %");
    if (summary["force_error_max_relative"].is_number())
        std::cerr << ", max: " << figure(summary, "force_error_max_relative", 100.0, " %");
    std::cerr << "\nstiffness over the nodule against beside it: "
              << figure(summary, "stiffness_ratio", 1.0, "")
              << "\nstop: " << summary["stop"].get<std::string>()
              << ", missed ticks: " << summary["n_missed_ticks"] << '\n';
    if (summary["digest_io"].is_string()) {
        std::cerr << "digest: io " << summary["digest_io"].get<std::string>() << ", state "
                  << summary["digest_state"].get<std::string>() << '\n';
    }
    if (summary.contains("depth_over_thickness_warning")) {
        std::cerr << "depth/h up to " << figure(summary, "depth_over_thickness_max", 1.0, "") << ": "
                  << summary["depth_over_thickness_warning"].get<std::string>() << '\n';
    }
    std::cerr << "results: " << directory.string() << ':';
    for (const char* name : {"summary.json", "scene.toml", "run.palrec", "ticks.csv", "events.csv",
                             "force.png", "curve.png", "touch.png", "log.txt"}) {
        if (std::filesystem::exists(directory / name)) std::cerr << ' ' << name;
    }
    if (summary.contains("supervision")) {
        for (const auto& name : summary["supervision"]["flight_records"])
            std::cerr << ' ' << name.get<std::string>();
    }
    std::cerr << '\n';
}

int run(const RunOptions& options) {
    catch_interrupts();
    const scene::Scene scene = scene::load(options.scene, overrides_of(options));
    record::OutputDirectory out(output_directory(options));
    const bool is_virtual = scene.run.clock == "virtual";
    std::optional<Scratch> scratch;  // before the bake: what cannot be made is said at once
    if (!is_virtual) require_device_input(scene, scratch.emplace());
    Progress progress(options.quiet);
    Operator rig;
#ifdef PALPATE_HAS_RIG
    const auto server = options.has_rig ? std::make_unique<RigOperator>(options.rig, progress) : nullptr;
    if (server) rig = server->as_operator();
#endif
    const Prepared prepared = prepare(scene::build(scene), progress);
    nlohmann::json header =
        record_header(options, prepared,
                      scene::resolved_toml(prepared.world->scene, std::filesystem::absolute(out.path())));
    const RunResult result = is_virtual ? run_virtual(prepared, rig, progress)
                                        : run_real(prepared, rig, progress, *scratch, {out.path(), header});
    add_times(header, result);
    Json summary = summary_of(options, prepared, result, progress);
    const int code = judge(*prepared.world, result, summary);
    write_results(out.path(), header, prepared, result, progress);
    record::write_file(out.path() / "summary.json", record::json_text(summary, 2) + "\n");
    out.commit();
    progress.leave();
    if (!options.quiet) say(summary, output_directory(options));
    if (options.json && !(std::cout << record::json_text(summary, 2) << std::endl))
        throw std::runtime_error("stdout cannot be written; summary.json has what --json would have printed");
    return code;
}

}  // namespace

std::string refusal_of_not_finite(const std::string& number) {
    const bool finite = std::isfinite(std::strtod(number.c_str(), nullptr));
    return finite ? "" : "a finite number is expected, not " + number;
}

void add_run(CLI::App& palpate, std::function<int()>& chosen) {
    auto options = std::make_shared<RunOptions>();
    CLI::App* command =
        palpate.add_subcommand("run", "let a hand feel a scene, and report force, error and stability");
    command->add_option("scene", options->scene, "scene file (docs/SCENE.md)")->required();
    command
        ->add_option("--clock", options->clock,
                     "virtual: lockstep, repeatable; real: processes of their own at 1 kHz")
        ->check(CLI::IsMember({"virtual", "real"}));
    command
        ->add_option("--duration", options->duration_s,
                     "seconds of the path to run; its whole length by default")
        ->check(CLI::PositiveNumber)
        ->check(refusal_of_not_finite);
    command->add_option("--out", options->out, "result folder; an earlier one moves to DIR.1 (out/SCENE)");
    command->add_option("--set", options->set, "section.key=value: any key of the scene, kept in the record")
        ->allow_extra_args(false);
    command
        ->add_option(
            "--device", options->device,
            "sim, or usb[:SERIAL]: a real Falcon in a person's hand, clock real, until Ctrl-C or --duration")
        ->check([](const std::string& name) { return refusal_of_device(name); });
    command->add_option("--firmware", options->firmware,
                        "with usb: the boot image (palpate device firmware)");
    command->add_option("--delta", options->delta, "with usb: another delta's geometry and gains, TOML");
    command
        ->add_option("--check", options->check, "ticks compared with the plate: sample (about 400) or full")
        ->check(CLI::IsMember({"sample", "full"}));
    command->add_option("--rig", options->rig, RIG_HELP)->check([](const std::string&) {
        return std::string(HAS_RIG ? "" : "this palpate was built without the rig (PALPATE_RIG)");
    });
    command->add_flag("--json", options->json, "print summary.json on stdout");
    command->add_flag("--quiet", options->quiet, "no progress, no words");
    command->footer("Example:\n  palpate run sim/scenes/bunny.toml --set hand.grip=light --out out/light");
    command->callback([options, command, &chosen] {
        options->has_rig = command->count("--rig") > 0;
        chosen = [options] { return run(*options); };
    });
}

}  // namespace palpate::app
