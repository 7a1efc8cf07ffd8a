#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "host/scene/scene.hpp"

using namespace palpate;
namespace fs = std::filesystem;

namespace {

std::string text_in(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

const std::string SMALL = R"(scene = 1
[object]
points = "a.ply"
length_unit = "mm"
[skin]
young_pa = 1e5
thickness_m = 0.002
)";

scene::Scene of(const std::string& text) {
    return scene::parse(text, "folder/small.toml");
}

}  // namespace

TEST_CASE("the bunny scene has the values that its file shows") {
    const scene::Scene s = scene::load(PAL_BUNNY_SCENE);
    CHECK(s.title == "A hard lump in a soft ear");
    CHECK(s.object.points == "bunny.obj");
    CHECK(s.object.size_m == 0.15);
    CHECK(s.object.length_unit.empty());
    CHECK(s.object.package == "glmark2-data");
    CHECK(s.skin.model == scene::Model::shell);
    CHECK(s.skin.young_pa == 0.4e6);
    CHECK(s.skin.thickness_m == 0.0015);
    CHECK(s.skin.poisson == 0.45);
    CHECK(s.skin.foundation_n_per_m3 == 2e7);
    REQUIRE(s.changes.size() == 2);
    CHECK(s.changes[0].shape == scene::Change::Shape::gradient);
    CHECK(s.changes[0].from_m == scene::Vec3{0.075, -0.03, 0.0});
    CHECK(s.changes[0].to_m == scene::Vec3{-0.060, 0.03, 0.0});
    CHECK(s.changes[0].factor == std::array<double, 2>{0.8, 1.2});
    CHECK(s.changes[1].shape == scene::Change::Shape::nodule);
    CHECK(s.changes[1].at_m == scene::Vec3{-0.0468, 0.0580, -0.0388});
    CHECK(s.changes[1].radius_m == 0.006);
    CHECK(s.changes[1].edge_m == 0.002);
    CHECK(s.changes[1].factor[0] == 5.0);
    CHECK(s.placement.facing == "operator");
    CHECK(s.placement.focus_m == s.changes[1].at_m);
    CHECK(s.hand.grip == "firm");
    CHECK(s.hand.mass_kg == 0.15);
    CHECK(s.hand.stiffness_n_per_m == 500.0);
    CHECK(s.hand.damping_n_s_per_m == 8.0);
    REQUIRE(s.hand.path.size() == 5);
    CHECK(s.hand.path[2].t_s == 5.0);
    CHECK(s.hand.path[2].at_m == scene::Vec3{-0.0490, 0.0548, -0.0274});
    CHECK(s.hand.path[4].depth_m == -0.010);
    CHECK(scene::duration_s(s) == 10.0);
    REQUIRE(s.expect.size() == 3);
    CHECK(s.expect[0].name == "force_error_rms_relative");
    CHECK(s.expect[0].op == "<=");
    CHECK(s.expect[0].number == 0.03);
    CHECK(s.expect[2].name == "stop");
    CHECK(s.expect[2].word == "none");
    CHECK_FALSE(s.expect[2].number);
}

TEST_CASE("what a scene leaves out has the documented default") {
    const scene::Scene s = of(SMALL);
    CHECK(s.object.axes == "file");
    CHECK(s.object.sides == "both");
    CHECK(s.skin.poisson == 0.45);
    CHECK(s.touch.force_max_n == 8.0);
    CHECK(s.touch.law == scene::Law::potential);
    CHECK(s.patch.size_m == 0.016);
    CHECK(s.solver.delay_ticks == 8);
    CHECK(s.hand.grip == "light");
    CHECK(s.hand.stiffness_n_per_m == 150.0);
    CHECK(s.run.clock == "virtual");
    CHECK(s.run.seed == 1);
    CHECK(s.changes.empty());
    CHECK(scene::duration_s(s) == 0.0);
}

TEST_CASE("a grip can be a table of its own") {
    const scene::Scene s =
        of(SMALL + "[hand]\ngrip = { mass_kg = 0.2, stiffness_n_per_m = 300, damping_n_s_per_m = 5.5 }\n");
    CHECK(s.hand.grip == "custom");
    CHECK(s.hand.mass_kg == 0.2);
    CHECK(s.hand.stiffness_n_per_m == 300.0);
    CHECK(s.hand.damping_n_s_per_m == 5.5);
}

TEST_CASE("the resolved scene reads back to the same scene") {
    const std::string extra =
        "columns = []\n[touch]\nlaw = \"normal\"\n[hand]\ngrip = { mass_kg = 0.1, stiffness_n_per_m = 300, "
        "damping_n_s_per_m = 5.5 }\npath = [{ t_s = 0, at_m = [0.1, 1e-7, -876.015625], depth_m = -0.01 }]\n";
    const std::string text = GENERATE_COPY(as<std::string>{}, text_in(PAL_BUNNY_SCENE), SMALL,
                                           "title = \"tab? \\\\ \\\" é\"\n" + SMALL + extra.substr(13));
    const scene::Scene first = of(text);
    const std::string resolved = scene::resolved_toml(first, "elsewhere");
    const scene::Scene second = scene::parse(resolved, "elsewhere/scene.toml");
    CHECK(second.hash == first.hash);
    CHECK(second.title == first.title);
    CHECK(second.skin.young_pa == first.skin.young_pa);
    CHECK(second.touch.law == first.touch.law);
    CHECK(second.hand.damping_n_s_per_m == first.hand.damping_n_s_per_m);
    CHECK(second.hand.path.size() == first.hand.path.size());
    CHECK(second.changes.size() == first.changes.size());
    CHECK(second.expect.size() == first.expect.size());
    const auto body = [](const std::string& toml) { return toml.substr(toml.find("scene = 1")); };
    CHECK(body(scene::resolved_toml(second, "elsewhere")) == body(resolved));
}

TEST_CASE("every value of a scene is part of its hash, the folder of its points is not") {
    const std::uint64_t hash = of(SMALL).hash;
    const auto with = [](const char* set) {
        const std::string one[] = {set};
        return scene::parse(SMALL, "small.toml", one).hash;
    };
    CHECK(with("skin.young_pa=100000.00000000001") != hash);  // one ulp
    CHECK(with("skin.model=plate") != hash);
    CHECK(with("solver.delay_ticks=9") != hash);
    CHECK(with("run.seed=2") != hash);
    CHECK(with("hand.grip=firm") != hash);
    CHECK(with("expect.stop=== none") != hash);
    CHECK(with("object.points=b.ply") != hash);
    CHECK(with("object.points=/some/where/a.ply") == hash);
    CHECK(with("skin.young_pa=100000") == hash);
}

TEST_CASE("the resolved scene finds the same points from another folder") {
    const fs::path folder = fs::path(PAL_TEST_FOLDER) / "resolved_points";
    fs::create_directories(folder / "scenes");
    fs::create_directories(folder / "out");
    std::ofstream(folder / "scenes/a.ply") << "ply";
    std::ofstream(folder / "scenes/s.toml") << SMALL;
    const scene::Scene first = scene::load(folder / "scenes/s.toml");
    CHECK(fs::equivalent(scene::points_file(first), folder / "scenes/a.ply"));
    std::ofstream(folder / "out/scene.toml") << scene::resolved_toml(first, folder / "out");
    const scene::Scene second = scene::load(folder / "out/scene.toml");
    CHECK(fs::equivalent(scene::points_file(second), folder / "scenes/a.ply"));
    CHECK(second.hash == first.hash);
}

TEST_CASE("points that are missing are named with the line, the places and the package") {
    scene::Scene s = of(SMALL + "[run]\nseed = 2\n");
    CHECK_THROWS_WITH(
        scene::points_file(s),
        "folder/small.toml:3: a.ply: not found here or in /usr/share/glmark2/models; another file is "
        "expected in object.points");
    s.object.package = "glmark2-data";
    CHECK_THROWS_WITH(
        scene::points_file(s),
        "folder/small.toml:3: a.ply: not found here or in /usr/share/glmark2/models; install the "
        "package glmark2-data");
}

TEST_CASE("a value's place is known after reading") {
    const scene::Scene s = scene::load(PAL_BUNNY_SCENE);
    const std::string file = PAL_BUNNY_SCENE;
    CHECK(scene::where(s, "skin.young_pa") == file + ":11");
    CHECK(scene::where(s, "change[1].at_m") == file + ":25");
    CHECK(scene::where(s, "hand.path[3]") == file + ":40");
    CHECK(scene::where(s, "hand.path[3].at_m") == file + ":40");
    CHECK(scene::where(s, "skin.model") == file + ":10");   // not given: its section's
    CHECK(scene::where(s, "patch.size_m") == file + ":1");  // nor its section
}

TEST_CASE(
    "of several values at fault the first that a --set gave has the place, else the first that has one") {
    const std::vector<std::string> set{"hand.path.1.depth_m=0.004", "patch.projection=gall-peters"};
    const scene::Scene s = scene::load(PAL_BUNNY_SCENE, set);
    const std::string file = PAL_BUNNY_SCENE;
    const auto among = [&](const std::vector<std::string>& names) { return scene::where_among(s, names); };
    CHECK(among({"hand.path[0].at_m", "hand.path[1].depth_m"}) == "--set hand.path[1].depth_m");
    CHECK(among({"hand.path[0].at_m", "hand.path[1].at_m"}) == file + ":37");
    CHECK(among({"patch.size_m", "object.size_m"}) == file + ":7");  // [patch] is on no line
    CHECK(among({"patch.size_m", "run.seed"}) == file + ":1");
    CHECK(among({}) == file + ":1");
}

TEST_CASE("docs/SCENE.md is what the table of keys says") {
    CHECK(text_in(PAL_SCENE_MD) == scene::scene_markdown());
}

TEST_CASE("write docs/SCENE.md", "[.write]") {
    std::ofstream(PAL_SCENE_MD) << scene::scene_markdown();
}
