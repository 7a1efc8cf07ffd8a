#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "host/latency/trace.hpp"
#include "tests/host/latency/run.hpp"

using namespace palpate::latency;
using nlohmann::json;

namespace {

json traced(const std::vector<pal_tick>& ticks, const Publications& publications,
            TraceResult* result = nullptr) {
    std::string text;
    const TraceResult r = write_trace(ticks, publications, [&](std::string_view piece) { text += piece; });
    if (result != nullptr) *result = r;
    return json::parse(text);
}

std::vector<json> of(const json& doc, const std::string& phase, const std::string& name = "") {
    std::vector<json> out;
    for (const json& event : doc["traceEvents"]) {
        if (event["ph"] == phase && (name.empty() || event.value("name", "") == name)) out.push_back(event);
    }
    return out;
}

/// What a viewer relies on; words of the first thing that is wrong.
std::string problem_with(const json& doc) {
    double last_us = 0.0;
    std::map<std::string, int> open;
    std::map<std::string, double> slice_end_us;
    for (const json& event : doc["traceEvents"]) {
        const std::string phase = event["ph"];
        if (phase == "M") continue;
        const double t_us = event["ts"];
        if (t_us < last_us) return "time goes back: " + event.dump();
        last_us = t_us;
        const std::string track =
            event["pid"].dump() + "/" + (event.contains("tid") ? event["tid"].dump() : "");
        if (phase == "B" || phase == "E") open[track] += phase == "B" ? 1 : -1;
        const std::string span = event.value("cat", "") + event.value("id", "") + event["pid"].dump();
        if (phase == "b" || phase == "e") open[span] += phase == "b" ? 1 : -1;
        if (open[track] < 0 || open[span] < 0) return "an end without a beginning: " + event.dump();
        if (open[track] > 1 || open[span] > 1) return "two at once on one row: " + event.dump();
        if (phase != "X") continue;
        if (event["dur"] < 0.0) return "a negative length: " + event.dump();
        // A slice lies inside the last tick or begins after it.
        double& end_us = slice_end_us[track];
        const double to_us = t_us + event["dur"].get<double>(), rounding_us = 1e-6;
        if (event["name"] == "tick" && t_us < end_us - rounding_us) return "ticks overlap: " + event.dump();
        if (event["name"] == "tick" || event["name"] == "request") end_us = to_us;
        if (to_us > end_us + rounding_us) return "a stage outlasts its tick: " + event.dump();
    }
    for (const auto& [row, n] : open) {
        if (n != 0) return "never ended: " + row;
    }
    return "";
}

/// Two tables with a fade, a fault that lasts, a stop, a stall.
std::vector<pal_tick> eventful() {
    auto ticks = sample::run(400);
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        pal_tick& tick = ticks[i];
        tick.state = i < 20    ? PAL_STATE_HOMING
                     : i < 40  ? PAL_STATE_RAMP
                     : i < 390 ? PAL_STATE_ENABLED
                               : PAL_STATE_FAULT;
        tick.table_id = i < 50 ? 0 : i < 200 ? 1 : 3;
        tick.before_id = i >= 200 && i < 216 ? 1 : 0;
        tick.faults = i >= 100 && i < 110 ? std::uint32_t{PAL_FAULT_FORCE_CLAMP} : 0U;
        if (i >= 105) tick.faults |= std::uint32_t{PAL_FAULT_TABLE_STALE};
        tick.stop = i >= 390 ? std::uint32_t{PAL_FAULT_ESTOP} : 0U;
        tick.force_n[1] = i >= 60 ? 2.5F : 0.0F;
        tick.depth_m = i >= 60 ? 0.003F : -0.01F;
        if (i < 300) continue;
        sample::shift(tick, 2000000);
        tick.n_missed = 2;
        if (i > 300) tick.stamp_ns[5] += 2000000;
    }
    return ticks;
}

Publications published() {
    return {{1, {.t_ns = sample::T0_NS + 49500000, .made_for_tick = 30}},
            {2, {.t_ns = sample::T0_NS + 190000000, .made_for_tick = 150}},
            {3, {.t_ns = sample::T0_NS + 199200000, .made_for_tick = 160}}};
}

}  // namespace

TEST_CASE("a trace of a run in real time is JSON in the order of time with every beginning ended") {
    TraceResult result;
    const json doc = traced(eventful(), published(), &result);
    CHECK(problem_with(doc).empty());
    CHECK(problem_with(doc) == "");
    CHECK(doc["otherData"]["schema"] == "palpate.trace/1");
    CHECK(doc["otherData"]["zero_ns"] == std::to_string(sample::T0_NS + 10000));
    CHECK(result.n_left_out == 0);
    CHECK(result.n_events == doc["traceEvents"].size() - of(doc, "M").size());
}

TEST_CASE("each tick is a slice with its stages inside") {
    const json doc = traced(sample::run(30), {});
    const auto ticks = of(doc, "X", "tick");
    REQUIRE(ticks.size() == 30);
    CHECK(ticks[7]["ts"] == 7000.0);
    CHECK(ticks[7]["dur"] == 23.0);
    CHECK(ticks[7]["args"]["tick"] == 7);
    const std::map<std::string, std::pair<double, double>> truth = {{"collect", {0.0, 5.0}},
                                                                    {"choose table", {5.0, 1.0}},
                                                                    {"compute force", {6.0, 14.0}},
                                                                    {"hand over", {20.0, 3.0}}};
    for (const auto& [name, at] : truth) {
        const auto stages = of(doc, "X", name);
        REQUIRE(stages.size() == 30);
        CHECK(stages[7]["ts"] == 7000.0 + at.first);
        CHECK(stages[7]["dur"] == at.second);
    }
    const auto requests = of(doc, "X", "request");
    REQUIRE(requests.size() == 29);
    CHECK(requests[0]["ts"] == 23.0);
    CHECK(requests[0]["dur"] == 400.0);
}

TEST_CASE(
    "a table is shown from the tick that it was made for to its publication, its first use and its end") {
    const json doc = traced(eventful(), published());
    const auto built = of(doc, "b", "made for .. published"), waits = of(doc, "b", "published .. in use");
    const auto in_use = of(doc, "e", "published .. in use");
    REQUIRE(built.size() == 3);
    REQUIRE(waits.size() == 2);
    CHECK(built[0]["ts"] == 30000.0);
    CHECK(built[0]["args"]["table"] == 1);
    CHECK(waits[0]["ts"] == 49490.0);   // published at 49.5 ms, the first tick woke at 0.01
    CHECK(in_use[0]["ts"] == 50020.0);  // T3
    CHECK(of(doc, "i", "table 2 was published and not used").size() == 1);
    CHECK(of(doc, "i", "for table 3")[0]["ts"] == 160000.0);
    const auto first = of(doc, "B", "table 1"), third = of(doc, "B", "table 3"),
               fade = of(doc, "B", "1 to 3");
    REQUIRE(first.size() == 1);
    CHECK(first[0]["ts"] == 50000.0);
    CHECK(first[0]["args"]["made_for_tick"] == 30);
    CHECK(third[0]["ts"] == 200000.0);
    CHECK(fade[0]["ts"] == 200000.0);
}

TEST_CASE("states, faults, stops and missed periods stand where they happened") {
    const json doc = traced(eventful(), published());
    CHECK(of(doc, "B", "homing")[0]["ts"] == 0.0);
    CHECK(of(doc, "B", "enabled")[0]["ts"] == 40000.0);
    CHECK(of(doc, "b", "fault: force-clamp")[0]["ts"] == 100000.0);
    CHECK(of(doc, "e", "fault: force-clamp")[0]["ts"] == 110000.0);
    CHECK(of(doc, "b", "fault: table-stale")[0]["ts"] == 105000.0);
    CHECK(of(doc, "i", "stop: e-stop")[0]["ts"] == 392000.0);
    CHECK(of(doc, "i", "missed 2")[0]["ts"] == 302000.0);
    const auto force = of(doc, "C", "force (N)"), depth = of(doc, "C", "depth (mm)");
    REQUIRE(force.size() == 2);  // changes only
    CHECK(force[1]["args"]["value"] == 2.5);
    CHECK(force[1]["ts"] == 60000.0);
    CHECK(depth[1]["args"]["value"].get<double>() == Approx(3.0));
    CHECK(of(doc, "C", "woken late (us)")[0]["args"]["value"] == 10.0);
}

TEST_CASE("in virtual time a tick lasts its period and a table waits from the tick that it was made for") {
    auto ticks = eventful();
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        std::memset(ticks[i].stamp_ns, 0, sizeof ticks[i].stamp_ns);
        ticks[i].t_ns = i * 1000000;
        ticks[i].wake_late_ns = 0;
    }
    Publications publications = published();
    for (auto& [id, publication] : publications) publication.t_ns = 0;
    const json doc = traced(ticks, publications);
    CHECK(problem_with(doc) == "");
    CHECK(of(doc, "X", "tick").size() == 400);
    CHECK(of(doc, "X", "tick")[3]["dur"] == 1000.0);
    CHECK(of(doc, "X", "collect").empty());
    CHECK(of(doc, "C", "woken late (us)").empty());
    CHECK(of(doc, "b", "made for .. in use").size() == 2);
    CHECK(of(doc, "e", "made for .. in use")[0]["ts"] == 50000.0);
}

TEST_CASE("part of a run is a trace of its own") {
    const auto ticks = eventful();
    const json doc = traced({ticks.begin() + 100, ticks.begin() + 205}, published());
    CHECK(problem_with(doc) == "");
    CHECK(of(doc, "b", "made for .. published").size() == 2);  // of table 1 nothing is inside
}

TEST_CASE("one tick, no ticks, and ticks without sense make valid traces") {
    CHECK(problem_with(traced({}, published())) == "");
    CHECK(problem_with(traced(sample::run(1), {})) == "");
    auto ticks = eventful();
    ticks[50].stamp_ns[4] = 3;                  // ends before it began
    ticks[60].stamp_ns[2] = ~std::uint64_t{0};  // a stage beyond the tick
    ticks[70].stamp_ns[5] = 17;                 // completed long ago
    ticks[80].force_n[0] = std::numeric_limits<float>::quiet_NaN();
    ticks[90].t_ns -= 500000000;  // before everything
    TraceResult result;
    const json doc = traced(ticks, published(), &result);
    CHECK(problem_with(doc) == "");
    CHECK(of(doc, "i", "tick without stamps").size() == 1);
    CHECK(result.n_left_out > 0);
}

TEST_CASE("the check of these tests sees what it is for: the mutants") {
    const json good = traced(eventful(), published());
    const auto broken = [&](auto&& how) {
        json doc = good;
        how(doc["traceEvents"]);
        return problem_with(doc);
    };
    const auto find = [](json& events, const std::string& phase) -> std::size_t {
        std::size_t i = 0;
        while (events[i]["ph"] != phase) ++i;
        return i;
    };
    CHECK(broken([&](json& events) { events[events.size() / 2]["ts"] = 0.0; }) != "");
    CHECK(broken([&](json& events) { events.erase(find(events, "E")); }) != "");
    CHECK(broken([&](json& events) { events.erase(find(events, "e")); }) != "");
    CHECK(broken([&](json& events) { events[find(events, "X")]["dur"] = -1.0; }) != "");
    CHECK(broken([&](json& events) { events[find(events, "X")]["dur"] = 3000.0; }) != "");
}
