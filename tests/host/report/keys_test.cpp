// Every key of a scene does what its name says, seen in the world that is built or in a short virtual run.
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <functional>
#include <set>

#include "firmware/core/step.h"
#include "host/app/run.hpp"
#include "host/report/figures.hpp"
#include "host/scene/keys.hpp"
#include "tests/host/report/felt_sheet.hpp"
#ifdef PALPATE_HAS_VIEW
#include "host/app/view_source.hpp"
#endif

using namespace palpate;
using namespace palpate::test;

namespace {

void check_length_unit() {
    const std::pair<const char*, double> units[] = {
        {"m", 1.0}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}, {"inch", 0.0254}};
    for (const auto& [unit, metres] : units) {
        const auto world = world_of({std::string("object.length_unit=") + unit, "hand.path=[]",
                                     "patch.size_m=" + scene::number_text(0.01 * metres)});
        CAPTURE(unit);
        CHECK(world->spacing_m == Approx(1e-3 * metres).epsilon(1e-4));
    }
}

void check_size() {
    const auto world = world_of({"object.size_m=0.08"});  // of 40 mm
    CHECK(world->spacing_m == Approx(2e-3).epsilon(1e-4));
    CHECK(world->cloud.points_m.front().x() == Approx(-0.04).epsilon(1e-4));
}

void check_axes() {
    const Set still{"hand.path=[]"};
    same(landmark(still), {0.007, -0.003, 0.0});
    same(landmark({"object.axes=LPS", "hand.path=[]"}), {0.007, 0.0, 0.003});
    same(landmark({"object.axes=RAS", "hand.path=[]"}), {-0.007, 0.0, -0.003});
}

void check_points() {
    std::ofstream(std::filesystem::path(PAL_TEST_FOLDER) / "three.obj") << "v 0 0 0\nv 0.04 0 0\nv 0 1 0\n";
    CHECK(world_of({"object.points=three.obj", "hand.path=[]"})->cloud.points_m.size() == 3);
}

void check_sides() {
    std::ofstream out(std::filesystem::path(PAL_TEST_FOLDER) / "wall.ply");
    out << "ply\nformat ascii 1.0\nelement vertex 882\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 1600\nproperty list uchar int vertex_indices\nend_header\n";
    for (int i = 0; i < 882; ++i)
        out << 1e-3 * (i % 21 - 10) << ' ' << 1e-3 * (i / 21 % 21 - 10) << ' ' << (i < 441 ? 0 : -6e-4)
            << '\n';
    for (int i = 0; i < 800; ++i) {
        const int wall = i / 400, at = 441 * wall + (i % 400) / 20 * 21 + i % 20, a = wall == 0 ? 1 : 22;
        out << "3 " << at << ' ' << at + a << ' ' << at + 23 - a << "\n3 " << at + 22 << ' ' << at + 23 - a
            << ' ' << at + a << '\n';
    }
    out.close();
    const Set wall{"object.points=wall.ply", "hand.path=[]"};
    CHECK(world_of(wall)->cloud.points_m.size() == 882);
    const auto outer = world_of({wall[0], wall[1], "object.sides=outer"});
    CHECK(outer->cloud.points_m.size() == 441);
    CHECK(outer->n_other_side == 441);
}

/// The ratio of the stiffness in the middle of the sheet with `set` to that without.
double ratio(const std::string& set, const Set& base) {
    Set with = base;
    with.push_back(set);
    return k_n_per_m(*world_of(with)) / k_n_per_m(*world_of(base));
}

void check_model() {
    const Set shell{"skin.model=shell", BARE}, plate{"skin.model=plate", BARE};
    CHECK(k_n_per_m(*cap_of(plate)) == Approx(k_n_per_m(*world_of(plate))).epsilon(0.05));
    CHECK(k_n_per_m(*cap_of(shell)) > 1.15 * k_n_per_m(*cap_of(plate)));
}

void check_young() {
    CHECK(ratio("skin.young_pa=0.8e6", {BARE}) == Approx(2.0).epsilon(1e-3));  // k = D / (0.0056 a^2)
}
void check_thickness() {
    CHECK(ratio("skin.thickness_m=0.003", {BARE}) == Approx(8.0).epsilon(1e-3));
}
void check_poisson() {
    CHECK(ratio("skin.poisson=0.1", {BARE}) == Approx((1 - 0.45 * 0.45) / (1 - 0.01)).epsilon(1e-3));
}
void check_foundation() {  // k = 8 sqrt(D k_f) for a patch of many l
    const std::string wide = "patch.size_m=0.024";
    CHECK(ratio("skin.foundation_n_per_m3=8e7", {wide, SPRINGS}) == Approx(2.0).epsilon(0.01));
}
void check_patch_size() {
    CHECK(ratio("patch.size_m=0.012", {BARE}) == Approx(16.0 / 9.0).epsilon(1e-3));
}
/// Stiff skin beyond 8 mm to both sides: outside the 16 mm of an isometric patch, inside one that is
/// stretched 2 to 1 and takes in 22.6 mm.
void check_projection() {
    const std::string walls =
        "change=[{ shape = \"gradient\", from_m = [0.0085, 0, 0], to_m = [0.0095, 0, 0], factor = [1, 50] }, "
        "{ shape = \"gradient\", from_m = [-0.0085, 0, 0], to_m = [-0.0095, 0, 0], factor = [1, 50] }]";
    CHECK(ratio(walls, {BARE}) < 1.1);
    CHECK(ratio(walls, {BARE, "patch.projection=gall-peters"}) > 1.3);
}

void check_placement() {
    same(landmark({"placement.at_m=[0.01,0.02,0.03]", "hand.path=[]"}), {0.017, 0.017, 0.03});
    same(landmark({"placement.focus_m=[0.007,-0.003,0]", "hand.path=[]"}), {0, 0, 0});
    const std::string on_edge = "placement.turn_deg=[0,90,0]";  // faces +x
    CHECK(world_of({on_edge, "hand.path=[]"})->cloud.normals.front().x() == Approx(1.0));
}
void check_facing() {
    const Set lps{"object.axes=LPS", "hand.path=[]"};  // the sheet faces +-y
    CHECK(std::abs(world_of(lps)->cloud.normals.front().y()) == Approx(1.0));
    CHECK(world_of({lps[0], lps[1], "placement.facing=operator"})->cloud.normals.front().z() == Approx(1.0));
}
void check_turn() {  // each pair of turns, where the other order ends elsewhere
    same(landmark({"placement.turn_deg=[90,90,0]", "hand.path=[]"}), {-0.003, 0.0, -0.007});
    same(landmark({"placement.turn_deg=[90,0,90]", "hand.path=[]"}), {0.0, 0.007, -0.003});
    same(landmark({"placement.turn_deg=[0,90,90]", "hand.path=[]"}), {0.003, 0.0, -0.007});
}

/// What the hand feels with scales: as right as without, and as stiff as their product says.
void check_scales(double position_scale, double force_scale) {
    CAPTURE(position_scale, force_scale);
    const Felt felt = feel({"placement.position_scale=" + std::to_string(position_scale),
                            "placement.force_scale=" + std::to_string(force_scale)});
    const scene::World& world = *felt.prepared.world;
    CHECK(position_scale * world.path.front().tool_m.z() == Approx(0.007));  // 4 mm above the skin
    const auto touches = report::touches(world, felt.run.ticks);
    const auto error = report::force_error(world, felt.run.ticks, touches, felt.run.tables,
                                           app::loop_model(felt.prepared), report::SAMPLE / 4, [](double) {});
    REQUIRE(error);
    CHECK(error->n_without_reference == 0);
    CHECK(error->n_without_table == 0);
    CHECK(error->total.rms_relative < 0.03);
    const double product = position_scale * force_scale, on_object = k_n_per_m(world);
    CHECK(felt.median([](const pal_tick& t) { return t.k_n_per_m; }) ==
          Approx(product * on_object).epsilon(0.01));
    CHECK(felt.median([](const pal_tick& t) { return t.force_n[2] / t.depth_m; }) ==
          Approx(product * on_object).epsilon(0.02));
    double deepest = 0.0;
    for (std::size_t i = 1; i < touches.size(); ++i) {
        deepest = std::max(deepest, touches[i].depth_m);
        if (!touches[i - 1].contact() || felt.run.ticks[i].table_id == 0) continue;
        // A tick tells, in the hand's metres, where the tool was at its begin, to an encoder's count.
        const double told_m = position_scale * static_cast<double>(felt.run.ticks[i].depth_m);
        if (!(std::abs(told_m - touches[i - 1].depth_m) < 3e-5 * position_scale))
            FAIL(i << ": " << told_m << " m told, " << touches[i - 1].depth_m << " m true");
    }
    CHECK(report::run_figures(world, felt.run.ticks, touches)["depth_m"]["max"] == Approx(deepest));
#ifdef PALPATE_HAS_VIEW
    // The picture is the object's: tool, dip, depth and stiffness fit together there.
    const view::Frame frame = app::view_source(world, *felt.prepared.field, felt.run.ticks).frame_at(1.0);
    const auto depth_m = static_cast<double>(frame.depth_m);
    CHECK(static_cast<double>(frame.tool_m.z()) == Approx(0.003 - depth_m).margin(2e-5 * position_scale));
    CHECK(static_cast<double>(frame.k_n_per_m) == Approx(on_object).epsilon(0.01));
    float deepest_dip_m = 0.0F;
    for (const view::Moved& moved : frame.dip) deepest_dip_m = std::max(deepest_dip_m, moved.by_m.norm());
    CHECK(static_cast<double>(deepest_dip_m) == Approx(depth_m).epsilon(0.1));
#endif
}

void check_tool_radius() {
    const auto top_m = [](const Set& set) { return world_of(set)->path.front().tool_m.z(); };
    CHECK(top_m({QUICK, "touch.tool_radius_m=0.005"}) - top_m({QUICK}) == Approx(0.002));
    CHECK(feel({QUICK, "touch.tool_radius_m=0.005"}).lowest_m() - plain().lowest_m() ==
          Approx(0.002).epsilon(0.05));
}

void check_law() {  // beside a slope of E the potential pushes sideways, the normal law does not
    const std::string slope =
        "change=[{ shape = \"gradient\", from_m = [-0.01, 0, 0], to_m = [0.01, 0, 0], factor = [0.2, 1.8] }]";
    const auto sideways = [](const Felt& felt) {
        return felt.median(
            [](const pal_tick& t) { return std::abs(t.table_force_n[0] / t.table_force_n[2]); });
    };
    for (const auto& [law, id] : {std::pair("potential", PAL_LAW_POTENTIAL), {"normal", PAL_LAW_NORMAL}}) {
        CAPTURE(law);
        const Felt felt = feel({QUICK, slope, std::string("touch.law=") + law});
        REQUIRE_FALSE(felt.run.tables.empty());
        for (const auto& [number, bytes] : felt.run.tables)
            CHECK(record::table_from(bytes)->law == static_cast<std::uint32_t>(id));
        if (id == PAL_LAW_NORMAL) CHECK(sideways(felt) < 1e-3);
        if (id == PAL_LAW_POTENTIAL) CHECK(sideways(felt) > 0.02);
    }
}

void check_force_max() {
    CHECK(plain().force_max_n() > 0.6);
    const double most = feel({QUICK, "touch.force_max_n=0.5"}).force_max_n();
    CHECK(most <= 0.5 + 1e-6);  // single precision
    CHECK(most > 0.499);
}

void check_ramp() {
    for (const double ramp_s : {0.05, 0.2}) {
        CAPTURE(ramp_s);
        std::uint32_t pause = 0;
        app::Operator rig;  // pauses for 20 ms while the hand presses
        rig.show = [&](const pal_tick& tick, double) { pause = tick.path_tick; };
        rig.enable = [&] { return pause < 220 || pause >= 240; };
        const Felt felt = feel({QUICK, "touch.ramp_s=" + std::to_string(ramp_s)}, rig);
        const auto n = static_cast<std::size_t>(std::lround(1e3 * ramp_s));
        CHECK(felt.n_in(PAL_STATE_RAMP) == 2 * n);  // after homing and after the pause
        std::vector<float> gains;
        for (const pal_tick& tick : felt.run.ticks) {
            if (tick.state == PAL_STATE_RAMP && tick.path_tick > 200) gains.push_back(tick.gain);
        }
        REQUIRE(gains.size() == n);
        for (std::size_t i = 0; i < n; ++i)
            CHECK(gains[i] == Approx(static_cast<double>(i) / static_cast<double>(n)).margin(1e-6));
    }
}

void check_tables() {
    const auto nodes = [](const Set& set) {
        const Felt felt = feel(set);
        REQUIRE_FALSE(felt.run.tables.empty());
        return record::table_from(felt.run.tables.begin()->second)->n_nodes;
    };
    CHECK(nodes({QUICK, "solver.table_nodes=9"}) == 9);
    const std::uint32_t coarse = record::table_from(plain().run.tables.begin()->second)->n_nodes;
    CHECK(nodes({QUICK, "solver.tolerance=1e-4"}) > coarse);
}

void check_delay() {
    const std::uint32_t soon = feel({QUICK, "solver.delay_ticks=0"}).first_use();
    CHECK(plain().first_use() == soon + 8);
    CHECK(feel({QUICK, "solver.delay_ticks=40"}).first_use() == soon + 40);
}

void check_grip() {  // a softer hand is held off sooner; k is about 480 N/m
    const Felt light = feel({QUICK, "hand.grip=light"});
    const auto force_n = [](const pal_tick& t) { return t.force_n[2]; };
    CHECK(plain().median(force_n) > 1.2 * light.median(force_n));
    const Felt own = feel({QUICK,
                           "hand.grip={ mass_kg = 0.05, stiffness_n_per_m = 150.0, "
                           "damping_n_s_per_m = 2.0 }"});
    CHECK(own.run.digest_io == light.run.digest_io);
    for (const char* other : {"{ mass_kg = 0.2, stiffness_n_per_m = 150.0, damping_n_s_per_m = 2.0 }",
                              "{ mass_kg = 0.05, stiffness_n_per_m = 150.0, damping_n_s_per_m = 6.0 }"}) {
        CHECK(feel({QUICK, std::string("hand.grip=") + other}).run.digest_io != light.run.digest_io);
    }
}

void check_path() {
    const auto world = world_of({QUICK});
    CHECK(world->path.size() == 61);                                // every 10 ms
    CHECK(world->path[20].tool_m.z() == Approx(0.0).margin(1e-9));  // radius - depth
    CHECK(plain().lowest_m() > 0.0);                                // held off
    CHECK(plain().lowest_m() < 0.003);                              // in contact
}

void check_duration() {
    const auto last = [](const Felt& felt) { return felt.run.ticks.back().path_tick; };
    const std::uint32_t tail = last(plain()) - 600;  // the path's 0.6 s, and a little
    CHECK(tail < 200);
    CHECK(last(feel({QUICK, "run.duration_s=0.25"})) == 250 + tail);
}

void check_seed() {
    CHECK(feel({QUICK}).run.digest_io == plain().run.digest_io);
    CHECK(feel({QUICK, "run.seed=2"}).run.digest_io != plain().run.digest_io);
}

struct Row {
    std::string key;
    std::function<void()> check;
};

const std::vector<Row>& rows() {
    static const std::vector<Row> all{
        {"object.points", check_points},
        {"object.length_unit", check_length_unit},
        {"object.size_m", check_size},
        {"object.axes", check_axes},
        {"object.sides", check_sides},
        {"skin.model", check_model},
        {"skin.young_pa", check_young},
        {"skin.thickness_m", check_thickness},
        {"skin.poisson", check_poisson},
        {"skin.foundation_n_per_m3", check_foundation},
        {"placement.focus_m", check_placement},
        {"placement.at_m", check_placement},
        {"placement.facing", check_facing},
        {"placement.turn_deg", check_turn},
        {"placement.position_scale", [] { check_scales(2.0, 1.0); }},
        {"placement.force_scale", [] { check_scales(0.8, 0.5); }},
        {"touch.tool_radius_m", check_tool_radius},
        {"touch.law", check_law},
        {"touch.force_max_n", check_force_max},
        {"touch.ramp_s", check_ramp},
        {"patch.size_m", check_patch_size},
        {"patch.projection", check_projection},
        {"solver.tolerance", check_tables},
        {"solver.table_nodes", check_tables},
        {"solver.delay_ticks", check_delay},
        {"hand.grip", check_grip},
        {"hand.path", check_path},
        {"run.duration_s", check_duration},
        {"run.seed", check_seed},
    };
    return all;
}

/// Keys with one value so far, or that change words only.
const std::set<std::string> ELSEWHERE{
    "title",                          // view, record: tests/host/app
    "object.columns",                 // PLY and OBJ refuse it: tests/host/scene/bad_input_test.cpp
    "object.package",                 // in the words of an error: likewise
    "skin.depth_law", "patch.edges",  // one value each
    "device.backend", "device.model", "device.serial", "device.firmware",  // tests/host/app/usb_run_test.cpp
    "run.clock",  // tests/host/app: ends_test, rig_test
};

}  // namespace

TEST_CASE("a key that changes shows, and as its name says") {
    for (std::size_t i = 0; i < rows().size(); ++i) {
        DYNAMIC_SECTION(rows()[i].key) {
            rows()[i].check();
        }
    }
}

TEST_CASE("no key of a scene is without a test") {
    std::set<std::string> known, tested = ELSEWHERE;
    for (const auto& key : scene::scene_keys()) known.insert(key.name);
    for (const Row& row : rows()) tested.insert(row.key);
    CHECK(tested == known);
}

TEST_CASE("changes reach the run: a nodule is felt, at its factor") {
    const auto nodule = [](const char* factor) {
        return std::string("change=[{ shape = \"nodule\", at_m = [0, 0, 0], radius_m = 0.02, factor = ") +
               factor + " }]";
    };
    const Set scenes[] = {{QUICK, BARE, nodule("4.0")}, {QUICK, BARE, nodule("2.0")}};
    const auto k = [](const pal_tick& tick) { return tick.k_n_per_m; };
    CHECK(feel(scenes[0]).median(k) / feel(scenes[1]).median(k) == Approx(2.0).epsilon(0.01));
}

TEST_CASE("the scene's force limit and soft start are those of the loop, by default and at most") {
    const pal_loop_config loop = pal_loop_config_default();
    const scene::Touch touch;
    CHECK(touch.force_max_n == static_cast<double>(loop.force_max_n));
    CHECK(touch.ramp_s == 1.0);
    CHECK(loop.ramp_ticks == 1000);
}
