#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

using namespace palpate;
using Catch::Matchers::StartsWith;

namespace {

scene::Scene bunny(const std::vector<std::string>& set) {
    return scene::load(PAL_BUNNY_SCENE, set);
}

}  // namespace

TEST_CASE("--set replaces numbers, words, lists and items of lists") {
    const scene::Scene s =
        bunny({"skin.young_pa=1e5", "hand.grip=light", "touch.law = \"normal\"",
               "placement.at_m=[0.01, 0, 0]", "change.1.factor=3", "change.0.factor=[1, 2]",
               "hand.path.1.depth_m=0.004", "skin.model=plate", "solver.table_nodes=33"});
    CHECK(s.skin.young_pa == 1e5);
    CHECK(s.hand.grip == "light");
    CHECK(s.hand.stiffness_n_per_m == 150.0);
    CHECK(s.touch.law == scene::Law::normal);
    CHECK(s.placement.at_m == scene::Vec3{0.01, 0.0, 0.0});
    CHECK(s.changes[1].factor[0] == 3.0);
    CHECK(s.changes[0].factor == std::array<double, 2>{1.0, 2.0});
    CHECK(s.hand.path[1].depth_m == 0.004);
    CHECK(s.hand.path[2].depth_m == 0.006);
    CHECK(s.skin.model == scene::Model::plate);
    CHECK(s.solver.table_nodes == 33);
    CHECK(s.set.size() == 9);
}

TEST_CASE("--set gives a whole path, a grip and a condition") {
    const scene::Scene s =
        bunny({"hand.path=[{t_s=0,at_m=[0,0,0],depth_m=0},{t_s=2,at_m=[0,0,0],depth_m=0.001}]",
               "hand.grip={mass_kg=0.1,stiffness_n_per_m=1,damping_n_s_per_m=2}", "expect.stop=== e-stop",
               "expect.stiffness_ratio=>= 2", "change=[]"});
    CHECK(s.hand.path.size() == 2);
    CHECK(scene::duration_s(s) == 2.0);
    CHECK(s.hand.grip == "custom");
    CHECK(s.expect[1].number == 2.0);
    CHECK(s.expect[2].word == "e-stop");
    CHECK(s.changes.empty());
}

TEST_CASE("the last --set of a key wins and all are kept in the resolved scene") {
    const scene::Scene s = bunny({"run.seed=2", "run.seed=3"});
    CHECK(s.run.seed == 3);
    const std::string resolved = scene::resolved_toml(s, ".");
    CHECK(resolved.find("# --set run.seed=2\n# --set run.seed=3\n") != std::string::npos);
    CHECK(scene::parse(resolved, "scene.toml").hash == s.hash);
}

TEST_CASE("a --set cannot write a line of its own into the resolved scene") {
    const scene::Scene s = bunny({"placement.at_m=[0.0,\n0.0,\n0.02]"});
    CHECK(scene::parse(scene::resolved_toml(s, "."), "scene.toml").placement.at_m[2] == 0.02);
    CHECK_THROWS_AS(bunny({"run.seed=2\nclock=\"real\""}), scene::Error);
}

TEST_CASE("an error in a --set names its key") {
    const auto error = [](const std::string& set, const std::string& words) {
        INFO(set);
        CHECK_THROWS_WITH(bunny({set}), StartsWith(words));
    };
    error("skin.young_pa=soft", "--set skin.young_pa: skin.young_pa is a string; a number in Pa is expected");
    error("skin.young_pa=", "--set skin.young_pa: skin.young_pa is a string;");
    error("skin.young_pa=-1", "--set skin.young_pa: skin.young_pa is -1; a number in Pa above 0");
    error("skin.yuong_pa=1",
          "--set skin.yuong_pa: skin.yuong_pa is unknown; the nearest known key is skin.young_pa");
    error("layer.thickness_m=1", "--set layer.thickness_m: layer is unknown; the nearest known key is ");
    error("change.1.factor=nan", "--set change[1].factor: change[1].factor is nan; a number above 0");
    error("change.2.factor=1", "--set change.2.factor: there is no item 2; the array has 2, counted from 0");
    error("change.x=1", "--set change.x: there is no x in an array");
    error("title.x.y=1", "--set title.x.y: x is looked for in a string; a table is expected there");
    error("title.x=1", "--set title.x: there is no x in a string");
    error("hand.path.2.t_s=0.5",
          "--set hand.path[2].t_s: hand.path[2].t_s is 0.5; more than the 1 before it");
    error("hand.path.3=4", "--set hand.path[3]: hand.path[3] is an integer; a table is expected");
    error("hand.path=[1", "--set hand.path: ");
    error("hand.grip=\"a", "--set hand.grip: ");
    error("skin", "--set skin: KEY=VALUE is expected, such as skin.young_pa=0.4e6");
    error("=3", "--set =3: KEY=VALUE is expected");
    error("skin..young_pa=3", "--set skin..young_pa=3: KEY=VALUE is expected");
    error("a.b.c.d.e=3", "--set a.b.c.d.e=3: KEY=VALUE is expected");
    error("scene=2", "--set scene: scene = 2 is newer");
    error("title=\xff", "--set title: ");
}

TEST_CASE("a section that only a --set made is named by it") {
    const std::vector<std::string> set{"object.points=a.ply"};
    CHECK_THROWS_WITH(scene::parse("[skin]\nyoung_pa = 1e5\nthickness_m = 0.002\n", "s.toml", set),
                      StartsWith("--set object.points: object.length_unit is missing;"));
}
