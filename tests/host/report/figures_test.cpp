// What a run is judged by: bounds that hold and do not, and a stiffness ratio from forces and places alone.
#include "host/report/figures.hpp"

#include <catch2/catch.hpp>

#include "host/report/gnuplot.hpp"
#include "tests/host/sheets.hpp"

using namespace palpate;
using Catch::Matchers::Contains;

namespace {

std::vector<std::string> failed(const std::string& name, const std::string& op, std::optional<double> number,
                                const std::string& word = "") {
    scene::Scene scene;
    scene.expect.push_back({.name = name, .op = op, .number = number, .word = word});
    const report::Json summary = {{"rms", 0.02}, {"stop", "none"}, {"ratio", nullptr}};
    return report::failed_expectations(scene, summary);
}

/// Ticks of a hand that strokes 30 mm along x over a nodule at 0, with |F| = k(x) depth, after a press at the
/// start.
struct Stroke {
    std::unique_ptr<scene::World> world;
    std::vector<pal_tick> ticks;
    std::vector<report::Touch> touches;
};

Stroke stroke(bool nodule, double press_n) {
    scene::Scene scene = sheets::skin(0.4e6);
    if (nodule) {
        scene.changes.push_back({.shape = scene::Change::Shape::nodule,
                                 .at_m = {0, 0, 0},
                                 .radius_m = 0.005,
                                 .factor = {5.0, 1.0}});
    }
    scene.hand.path = {{.t_s = 0.0, .at_m = {-0.015, 0, 0}, .depth_m = -0.001},
                       {.t_s = 1.0, .at_m = {-0.015, 0, 0}, .depth_m = 0.002},
                       {.t_s = 2.0, .at_m = {0.015, 0, 0}, .depth_m = 0.002}};
    Stroke s{scene::build(scene, sheets::flat(0.05)), {}, {}};
    for (std::uint32_t t = 1; t < 2000; ++t) {
        const bool moving = t >= 1000;
        const double x_m = moving ? -0.015 + 3e-5 * (t - 1000) : -0.015;
        pal_tick tick{};
        tick.path_tick = t;
        tick.truth_valid = 1;
        tick.truth_position_m[0] = static_cast<float>(x_m);
        tick.truth_position_m[2] = static_cast<float>(scene.touch.tool_radius_m - 0.002);
        tick.truth_force_n[2] = static_cast<float>(moving ? (std::abs(x_m) < 0.006 ? 1.6 : 0.8) : press_n);
        s.ticks.push_back(tick);
    }
    s.touches = report::touches(*s.world, s.ticks);
    return s;
}

}  // namespace

TEST_CASE("a bound that does not hold, and a name that the summary lacks, fail in words") {
    CHECK(failed("rms", "<=", 0.03).empty());
    CHECK(failed("rms", ">=", 0.01).empty());
    CHECK(failed("rms", "==", 0.02).empty());
    CHECK(failed("stop", "==", std::nullopt, "none").empty());
    REQUIRE(failed("rms", "<=", 0.01).size() == 1);
    CHECK_THAT(failed("rms", "<=", 0.01).front(), Contains("rms <= 0.01") && Contains("it is 0.02"));
    CHECK(failed("rms", ">=", 0.03).size() == 1);
    CHECK(failed("rms", "==", 0.03).size() == 1);
    CHECK(failed("stop", "==", std::nullopt, "e-stop").size() == 1);
    CHECK(failed("stop", "<=", 1.0).size() == 1);
    CHECK(failed("ratio", ">=", 1.5).size() == 1);
    CHECK_THAT(failed("nothing", "<=", 1.0).front(), Contains("not in summary.json"));
}

TEST_CASE("the stiffness ratio is force over depth on the nodule against beside it, on strokes only") {
    const Stroke s = stroke(true, 0.8), pressed_hard = stroke(true, 8.0);
    const report::StiffnessRatio ratio = report::stiffness_ratio(*s.world, s.ticks, s.touches);
    REQUIRE(ratio.value);
    CHECK(*ratio.value == Approx(2.0).epsilon(1e-3));
    CHECK(ratio.n_over == Approx(333).margin(2));    // 10 mm at 0.03 mm a tick
    CHECK(ratio.n_beside == Approx(500).margin(3));  // 7.5 to 15 mm on both sides
    CHECK(*report::stiffness_ratio(*pressed_hard.world, pressed_hard.ticks, pressed_hard.touches).value ==
          *ratio.value);
}

TEST_CASE("without a nodule, or without a stroke over it, there is no stiffness ratio but a reason") {
    const Stroke plain = stroke(false, 0.8);
    const report::StiffnessRatio none = report::stiffness_ratio(*plain.world, plain.ticks, plain.touches);
    CHECK_FALSE(none.value);
    CHECK_THAT(none.why, Contains("no nodule"));
    Stroke short_of_it = stroke(true, 0.8);
    short_of_it.ticks.resize(1200);
    short_of_it.touches.resize(1200);
    const report::StiffnessRatio beside =
        report::stiffness_ratio(*short_of_it.world, short_of_it.ticks, short_of_it.touches);
    CHECK_FALSE(beside.value);
    CHECK_THAT(beside.why, Contains("over the nodule"));
}

TEST_CASE("no text ends gnuplot's quotes") {
    CHECK(report::gnuplot_quoted("it's") == "'it''s'");
    CHECK(report::gnuplot_quoted("a\n!touch b\r#") == "'a?!touch b?#'");
    CHECK(report::gnuplot_quoted("\xC3\xB6") == "'\xC3\xB6'");
}
