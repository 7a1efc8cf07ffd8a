#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "host/latency/report.hpp"
#include "host/latency/words.hpp"
#include "tests/host/latency/run.hpp"

using namespace palpate::latency;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

Report report_of(std::vector<pal_tick> ticks) {
    Machine machine;
    machine.cpu = "Some CPU";
    machine.n_cores = 2;
    machine.kernel = "6.1.0";
    machine.preemption = "PREEMPT_RT";
    machine.real_time_kernel = true;
    const LoopWords loop{
        .granted = 1, .refused = 32, .n_minor_faults = 4, .n_major_faults = 0, .n_preempted = 2};
    return make_report(machine, 0.0, loop, measure(ticks, {}));
}

}  // namespace

TEST_CASE("the JSON of a run holds each quantity with its figures, or why not") {
    const json doc = json::parse(json_of(report_of(sample::run(2000))).dump());
    CHECK(doc["schema"] == "palpate.latency/1");
    CHECK(doc["verdict"]["suitability"] == "suitable");
    CHECK(doc["verdict"]["valid_for_latency"] == true);
    CHECK(doc["verdict"]["why_not_valid"].is_null());
    CHECK(doc["run"]["n_ticks"] == 2000);
    CHECK(doc["run"]["n_missed"] == 0);
    CHECK(doc["machine"]["governor"].is_null());
    CHECK(doc["stolen_s"] == 0.0);
    CHECK(doc["loop"]["realtime"][0] == json({{"what", "locked memory"}, {"outcome", "granted"}}));
    CHECK(doc["loop"]["realtime"][5] == json({{"what", "SCHED_FIFO"}, {"outcome", "refused"}}));
    CHECK(doc["loop"]["n_preempted"] == 2);
    CHECK(doc["replies"]["share"] == 1.0);
    CHECK(doc["replies"]["share_min_of_100"] == 1.0);
    const json& wake_up = doc["wake_up"];
    CHECK(wake_up["known"] == true);
    CHECK(wake_up["n"] == 2000);
    for (const char* key :
         {"min_us", "mean_us", "p50_us", "p90_us", "p99_us", "p99_9_us", "p99_99_us", "max_us"}) {
        CAPTURE(key);
        CHECK(wake_up[key] == 10.0);
    }
    CHECK(wake_up["histogram"] == json({{10000, 11000, 2000}}));
    CHECK(doc["tick_cost"]["p50_us"] == 23.0);
    CHECK(doc["tick_cost"]["histogram"] == json({{23000, 23250, 2000}}));
    CHECK(doc["publish_to_use"]["known"] == false);
    CHECK(doc["publish_to_use"]["why_unknown"] == "no table was used");
    CHECK_FALSE(doc["publish_to_use"].contains("p50_us"));
    for (const QuantityName& name : quantity_names()) CHECK(doc.contains(name.key));
}

TEST_CASE("the text names machine, rights, disturbances, figures, verdict and reasons") {
    const std::string text = text_of(report_of(sample::run(2000)));
    for (const char* part :
         {"Some CPU, 2 processors", "preemption PREEMPT_RT", "granted           locked memory",
          "refused           SCHED_FIFO", "4 page faults (0 from disk), 2 preemptions",
          "2000 ticks in 1.999 s", "wake_up ", "p99.99", "suitable",
          "p99.9 of the wake-up is 10.0 us, within 300 us", "governor not known",
          "not known: no table was used"}) {
        CHECK_THAT(text, Contains(part));
    }
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) CHECK(line.size() <= 140);
}

TEST_CASE("without a tick nothing is said of replies") {
    const Report none = report_of({});
    CHECK(json_of(none)["replies"]["share"].is_null());
    CHECK_THAT(text_of(none), Contains("replies in time   not known: no ticks") && !Contains("100 %"));
    CHECK(none.verdict.reasons == std::vector<std::string>{"no ticks"});
}

TEST_CASE("the text histogram has cyclictest's lines: a count for each us, then the totals") {
    Histogram histogram;
    histogram.add(13999, 37), histogram.add(14000), histogram.add(1999999), histogram.add(2000000, 2);
    std::istringstream in(cyclictest_text(histogram));
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    REQUIRE(lines.size() == 1 + 2000 + 5);
    CHECK(lines[0] == "# Histogram");
    CHECK(lines[1 + 13] == "000013 000037");
    CHECK(lines[1 + 14] == "000014 000001");
    CHECK(lines[1 + 15] == "000015 000000");
    CHECK(lines[1 + 1999] == "001999 000001");
    CHECK(lines[2001] == "# Total: 000000039");
    CHECK(lines[2002] == "# Min Latencies: 00013");
    CHECK(lines[2003] == "# Avg Latencies: 00159");  // (37 * 13.999 + 14 + 1999.999 + 4000) / 41
    CHECK(lines[2004] == "# Max Latencies: 02000");
    CHECK(lines[2005] == "# Histogram Overflows: 00002");
}

TEST_CASE("numbers are written with the digits that mean something") {
    CHECK(us_text(213.0) == "0.21");
    CHECK(us_text(34540.0) == "34.5");
    CHECK(us_text(1042300.0) == "1042");
    CHECK(us_text(999999.0) == "1000");
    CHECK(share_text(0.9512) == "95.12 %");
}

TEST_CASE("the picture is drawn where gnuplot is, and else there are words") {
    namespace fs = std::filesystem;
    const fs::path png = fs::path(PAL_TEST_FOLDER) / "latency.png";
    fs::remove(png);
    const std::string words = draw_histograms(png, report_of(sample::run(2000)), "It's a run");
    if (words.empty()) {
        std::ifstream in(png, std::ios::binary);
        char head[8] = {};
        in.read(head, sizeof head);
        CHECK(std::string(head + 1, 3) == "PNG");
    } else {
        CHECK_THAT(words, Contains("gnuplot"));
    }
    CHECK_THAT(draw_histograms(png, report_of({}), "none"), Contains("neither wake-up nor tick cost"));
}
