// `palpate run` as a person and a script see it: verdict and exit code, one document on stdout, results that
// say what they are, an interrupt that keeps what there is.
#include <catch2/catch.hpp>
#include <csignal>

#include "host/record/record.hpp"
#include "tests/host/app/processes.hpp"
#include "tests/host/app/sheet.hpp"
#include "tests/lacking.hpp"

using namespace palpate::test;
using Catch::Matchers::Contains;

namespace {

Outcome run(const Folder& folder, const std::string& scene, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"run", scene, "--out", (folder / "result").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return call(PAL_PALPATE_PROGRAM, arguments, folder);
}

void check_named_figures(const nlohmann::json& summary) {
    for (const char* name : {"force_error_rms_relative", "force_error_max_relative"}) {
        INFO(name);
        CHECK(summary[name].is_number());
    }
    for (const char* part : {"table", "quantisation", "delay", "staleness"}) {
        INFO(part);
        CHECK(summary["force_error_parts"][part]["rms_relative"].is_number());
        CHECK(summary["force_error_parts"][part]["max_relative"].is_number());
    }
    for (const char* name : {"digest_io", "digest_state"})
        CHECK(summary[name].get<std::string>().size() == 16);
    for (const char* name : {"contact", "checked", "fading", "clamped", "ramped", "stale", "without_table"}) {
        INFO(name);
        CHECK(summary["force_error_ticks"][name].is_number_unsigned());
    }
}

}  // namespace

TEST_CASE("the bunny is felt by the program: verdict, figures, every file", "[objects]") {
    if (!installed_bunny()) return;
    const Folder folder;
    const Outcome outcome = run(folder, PAL_SCENES "/bunny.toml", {"--json"});
    INFO(outcome.err);
    CHECK(outcome.code == 0);
    const nlohmann::json summary = json_of(folder / "result" / "summary.json");
    CHECK(nlohmann::json::parse(outcome.out) == summary);
    CHECK(summary["verdict"] == "pass");
    CHECK(summary["object"]["name"] == "bunny.obj");
    CHECK(summary["object"]["n_points"] == 34835);
    CHECK(summary["object"]["hash"].get<std::string>().size() == 16);
    CHECK(summary["stop"] == "none");
    CHECK(summary["force_error_rms_relative"] <= 0.03);
    CHECK(summary["stiffness_ratio"] >= 1.5);
    CHECK_THAT(summary["depth_over_thickness_warning"].get<std::string>(), Contains("half the thickness"));
    check_named_figures(summary);
    for (const char* name : {"summary.json", "scene.toml", "run.palrec", "ticks.csv", "ticks.json",
                             "events.csv", "force.png", "curve.png", "touch.png"}) {
        INFO(name);
#ifndef PALPATE_HAS_VIEW
        if (std::string(name) == "touch.png") continue;
#endif
        CHECK(std::filesystem::file_size(folder / "result" / name) > 100);
    }
}

TEST_CASE("the verdict is the exit code: a bound of [expect] that does not hold is 1, and named", "[run]") {
    const Folder folder;
    const std::string scene = write_sheet(folder.path());
    const Outcome passed =
        run(folder, scene, {"--quiet", "--set", "expect.force_error_rms_relative=<= 0.03"});
    CHECK(passed.code == 0);
    CHECK(passed.out.empty());
    CHECK(passed.err.empty());
    CHECK(json_of(folder / "result" / "summary.json")["verdict"] == "pass");
    const Outcome failed = run(folder, scene, {"--json", "--set", "expect.stop=== e-stop"});
    CHECK(failed.code == 1);
    CHECK_THAT(failed.err, Contains("verdict: fail") && Contains("stop == e-stop does not hold"));
    const nlohmann::json summary = nlohmann::json::parse(failed.out);
    CHECK(summary["verdict"] == "fail");
    CHECK(summary["verdict_reasons"].size() == 1);
    check_named_figures(summary);
    CHECK(failed.out.find("\"verdict\"") < failed.out.find("force_error"));
    CHECK(summary["stiffness_ratio"].is_null());
    CHECK_THAT(summary["stiffness_ratio_why"].get<std::string>(), Contains("no nodule"));
    const Outcome unknown = run(folder, scene, {"--set", "expect.beauty=>= 1"});
    CHECK(unknown.code == 1);
    CHECK_THAT(unknown.err, Contains("beauty") && Contains("not in summary.json"));
}

TEST_CASE("a skin that the loop would refuse everywhere fails the run, and the reason is its first word",
          "[run]") {
    const Folder folder;
    const Outcome outcome = run(folder, write_sheet(folder.path()), {"--set", "skin.young_pa=1e9"});
    CHECK(outcome.code == 1);
    CHECK_THAT(outcome.err, Contains("verdict: fail\n  every table was refused: stiffness "));
    const nlohmann::json summary = json_of(folder / "result" / "summary.json");
    CHECK(summary["tables"]["published"] == 0);
    CHECK(summary["tables"]["refused_by_check"] > 0);
}

TEST_CASE("--duration ends the path early, --check full compares every tick of contact", "[run]") {
    const Folder folder;
    const Outcome outcome =
        run(folder, write_sheet(folder.path()), {"--json", "--duration", "0.5", "--check", "full"});
    CHECK(outcome.code == 0);
    const nlohmann::json ticks = nlohmann::json::parse(outcome.out)["force_error_ticks"];
    CHECK(ticks["checked"] == ticks["contact"]);
    CHECK(ticks["contact"] > 150);
    CHECK(ticks["contact"] < 400);
}

TEST_CASE("the shortest --duration is short, and not the whole path", "[run]") {
    const Folder folder;
    CHECK(run(folder, write_sheet(folder.path()), {"--duration", "1e-7"}).code == 0);
    const palpate::record::Record record = palpate::record::read(folder / "result" / "run.palrec");
    CHECK(record.ticks.back().path_tick <= 101);
}

TEST_CASE("a soft start longer than homing may take is no homing that failed", "[run]") {
    const Folder folder;
    const Outcome outcome =
        run(folder, write_sheet(folder.path()), {"--quiet", "--duration", "0.5", "--set", "touch.ramp_s=6"});
    INFO(outcome.err);
    CHECK(outcome.code == 0);
    CHECK(json_of(folder / "result" / "summary.json")["verdict"] == "pass");
}

TEST_CASE("a file whose name is not UTF-8 is felt like any other", "[run]") {
    const Folder folder;
    const std::filesystem::path scene = folder / "sh\xe9\x65t.toml";  // as Latin-1 writes it
    std::filesystem::rename(write_sheet(folder.path()), scene);
    const Outcome outcome = run(folder, scene.string(), {"--json", "--duration", "0.1"});
    INFO(outcome.err);
    CHECK(outcome.code == 0);
    const nlohmann::json summary = json_of(folder / "result" / "summary.json");
    CHECK(nlohmann::json::parse(outcome.out) == summary);
    CHECK_THAT(summary["command"].get<std::string>(), Contains("sh\xef\xbf\xbd\x65t.toml"));
}

TEST_CASE("a run without contact says so, draws what there is and names no file that is missing", "[run]") {
    const Folder folder;
    const Outcome outcome = run(folder, write_sheet(folder.path()), {"--duration", "0.1"});
    CHECK(outcome.code == 0);
    CHECK_THAT(outcome.err, Contains("no contact") && Contains("force.png") && !Contains("gnuplot"));
    const std::string results = outcome.err.substr(outcome.err.find("results:"));
    CHECK_THAT(results, Contains("force.png") && !Contains("curve.png"));
    CHECK(json_of(folder / "result" / "summary.json")["force_error_rms_relative"].is_null());
}

TEST_CASE("Ctrl-C keeps the run as far as it came, also while its forces are checked", "[run]") {
    const Folder folder;
    Program palpate(
        PAL_PALPATE_PROGRAM,
        {"run", write_sheet(folder.path(), 30.0), "--check", "full", "--out", (folder / "result").string()},
        folder);
    do {
        look_again();
        REQUIRE(palpate.running());
    } while (palpate.err().find("stiffness:") == std::string::npos);
    palpate.send(SIGINT);
    CHECK(palpate.wait() == 130);
    const nlohmann::json summary = json_of(folder / "result" / "summary.json");
    CHECK(summary["verdict"] == "interrupted");
    CHECK(summary["interrupted"] == true);
    CHECK_THAT(summary["force_error_rms_relative_why"].get<std::string>(), Contains("interrupted"));
    CHECK(std::filesystem::exists(folder / "result" / "run.palrec"));
}

TEST_CASE("a TMPDIR that cannot be used, and a stdout that is full, are said", "[run]") {
    const Folder folder;
    const std::string scene = write_sheet(folder.path()), result = (folder / "result").string();
    for (const std::string& tmp : {std::string("/nonexistent"), "/tmp/" + std::string(100, 'x')}) {
        const Outcome outcome = call(
            "env", {"TMPDIR=" + tmp, PAL_PALPATE_PROGRAM, "run", scene, "--clock", "real", "--out", result},
            folder);
        CHECK(outcome.code == 2);
        CHECK_THAT(outcome.err, Contains("palpate: " + tmp) && Contains("set TMPDIR"));
        CHECK_FALSE(std::filesystem::exists(result));
    }
    const Outcome full = call("sh",
                              {"-c", "exec \"$0\" run \"$1\" --duration 0.1 --json --out \"$2\" >/dev/full",
                               PAL_PALPATE_PROGRAM, scene, result},
                              folder);
    CHECK(full.code == 1);
    CHECK_THAT(full.err, Contains("stdout cannot be written"));
    CHECK(std::filesystem::exists(result));
}
