#include "host/scene/world.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "tests/host/sheets.hpp"

using namespace palpate;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;
using Eigen::Vector3d;

namespace {

std::string words_of(const scene::Scene& scene, cloud::Cloud cloud) {
    try {
        static_cast<void>(scene::build(scene, std::move(cloud)));
    } catch (const scene::Error& error) {
        return error.what();
    }
    return "";
}

const std::string HEAD = R"(scene = 1
[object]
points = "a.ply"
length_unit = "m"
[skin]
young_pa = 1e6
thickness_m = 0.0015
)";                                             // seven lines
const std::string PATH = "[hand]\npath = [\n";  // its first point is on the scene's line 10
const std::string MEND = "move the object with [placement] or shorten the path";

std::string point(double t_s, double x_m, double depth_m) {
    return "{ t_s = " + std::to_string(t_s) + ", at_m = [" + std::to_string(x_m) +
           ", 0, 0], depth_m = " + std::to_string(depth_m) + " },\n";
}

/// What is said about a scene of HEAD and `rest`, "s.toml:9: patch ..."; empty when it can be built.
std::string refusal(const std::string& rest, cloud::Cloud cloud, const std::vector<std::string>& set = {}) {
    return words_of(scene::parse(HEAD + rest, "s.toml", set), std::move(cloud));
}

/// The top of a ball of 40 mm, its highest point at the origin.
cloud::Cloud dome() {
    constexpr double RADIUS_M = 0.04;
    cloud::Cloud cloud = sheets::flat(0.05);
    for (Vector3d& p : cloud.points_m) p.z() = std::sqrt(RADIUS_M * RADIUS_M - p.squaredNorm()) - RADIUS_M;
    return cloud;
}

}  // namespace

TEST_CASE("facing the operator turns the skin at the focus towards +z and puts it where it was asked") {
    scene::Scene scene = sheets::skin(1e6);
    cloud::Cloud wall;  // a sheet in the plane x = 0.1, facing +x
    for (const Vector3d& p : sheets::flat(0.04).points_m) wall.points_m.emplace_back(0.1, p.x(), p.y());
    scene.placement = {.focus_m = {0.1, 0.005, 0}, .at_m = {0.01, 0, 0.02}, .facing = "operator"};
    const auto world = scene::build(scene, wall);
    const Vector3d at(0.01, 0, 0.02);
    const auto foot = world->surface->foot(at, world->tree->nearest(at));
    REQUIRE(foot);
    CHECK((foot->point_m - at).norm() < 1e-9);
    CHECK(foot->normal.z() == Approx(1.0));
    CHECK((world->pose(Vector3d(0.1, 0.006, 0)) - at).normalized().y() == Approx(1.0));  // up stays up
}

TEST_CASE("size_m scales the longest side and centres the object; length_unit only scales") {
    cloud::Cloud sheet = sheets::flat(0.04);
    for (Vector3d& p : sheet.points_m) p = 1e3 * p + Vector3d(500, 0, 0);
    scene::Scene sized = sheets::skin(1e6);
    sized.object.length_unit = "";
    sized.object.size_m = 0.08;
    const auto big = scene::build(sized, sheet);
    CHECK(big->spacing_m == Approx(2e-3));
    CHECK(big->tree->nearest(Vector3d(0.04, 0.04, 0)) == big->cloud.points_m.size() - 1);
    scene::Scene in_mm = sheets::skin(1e6);
    in_mm.object.length_unit = "mm";
    CHECK(scene::build(in_mm, sheet)->cloud.points_m.front().x() == Approx(0.48));
}

TEST_CASE("changes multiply the modulus at the points") {
    scene::Scene scene = sheets::skin(1e6);
    scene.changes.push_back({.shape = scene::Change::Shape::gradient,
                             .from_m = {-0.01, 0, 0},
                             .to_m = {0.01, 0, 0},
                             .factor = {1.0, 3.0}});
    scene.changes.push_back({.shape = scene::Change::Shape::nodule,
                             .at_m = {0, 0, 0.0005},
                             .radius_m = 0.004,
                             .edge_m = 0.002,
                             .factor = {5.0, 1.0}});
    const auto world = scene::build(scene, sheets::flat(0.04));
    const auto young = [&](double x, double y) {
        return world->cloud.young_pa[world->tree->nearest(Vector3d(x, y, 0))];
    };
    CHECK(young(-0.02, 0) == Approx(1e6));
    CHECK(young(0.02, 0) == Approx(3e6));
    CHECK(young(0.005, 0.01) == Approx(2.5e6));
    CHECK(young(0, 0) == Approx(10e6));
    CHECK(young(0, 0.004) == Approx(2e6 * 3.0));  // half way through the rim
    CHECK(young(0, 0.006) == Approx(2e6));
}

TEST_CASE("the path keeps the tool at its depth below the skin") {
    scene::Scene scene = sheets::skin(1e6);
    scene.hand.path = {
        {0.0, {-0.005, 0, 0}, -0.01}, {0.1, {-0.005, 0, 0}, 0.002}, {0.2, {0.005, 0, 0}, 0.002}};
    const auto world = scene::build(scene, sheets::flat(0.04));
    REQUIRE(world->path.size() == 21);
    CHECK(world->path.front().tool_m.z() == Approx(0.013));
    CHECK(world->path[10].tool_m.z() == Approx(0.001));
    CHECK(world->path[15].tool_m.x() == Approx(0.0).margin(1e-9));
    CHECK(world->path.back().t_s == Approx(0.2));
}

TEST_CASE("a path beyond the workspace names the point, the axis and the excess") {
    const std::string path = PATH + point(0.0, 0.0, -0.01) + point(1.0, 0.02, 0.002) + "]\n";
    CHECK(refusal(path + "[placement]\nat_m = [0.0423, 0, 0]\n", sheets::flat(0.05)) ==
          "s.toml:11: hand.path[1] at t_s = 1 is 12.3 mm beyond the workspace along +x (limit 50.0 mm); " +
              MEND);
    CHECK(refusal(path + "[placement]\nat_m = [0, 0, -0.060]\n", sheets::flat(0.05)) ==
          "s.toml:11: hand.path[1] at t_s = 1 is 14.0 mm beyond the workspace along -z (limit -45.0 mm); " +
              MEND);  // the worse one, though the first is 2 mm out
    CHECK(refusal(path + "[placement]\nat_m = [0, 0.08, 0]\n", sheets::flat(0.05)) ==
          "s.toml:10: hand.path[0] at t_s = 0 is 30.0 mm beyond the workspace along +y (limit 50.0 mm); " +
              MEND);  // all of the path is: its first point
    CHECK(refusal(PATH + point(0.5, 0.02, -0.01) + "]\n[placement]\nat_m = [0.04, 0, 0]\n",
                  sheets::flat(0.05)) ==
          "s.toml:10: hand.path[0] at t_s = 0.5 is 10.0 mm beyond the workspace along +x (limit 50.0 mm); " +
              MEND);  // a path of one point
}

TEST_CASE("a path over a dome that leaves the workspace only between its points is refused") {
    const std::string path = PATH + point(0.0, -0.02, 0.0) + point(0.54, -0.02, -0.01) +
                             point(3.0, 0.02, -0.01) + point(3.5, 0.02, 0.0) + "]\n";
    const auto raised = [&](const char* z_m) { return path + "[placement]\nat_m = [0, 0, " + z_m + "]\n"; };
    CHECK(refusal(raised("0.0425"), dome()) ==
          "s.toml:11: hand.path[1] to [2] at t_s = 1.77 is 5.5 mm beyond the workspace along +z "
          "(limit 50.0 mm); " +
              MEND);  // at the top, halfway
    CHECK(refusal(raised("0.03705"), dome()) ==
          "s.toml:11: hand.path[1] to [2] at t_s = 1.77 is 0.05 mm beyond the workspace along +z "
          "(limit 50.0 mm); " +
              MEND);
    CHECK(refusal(raised("0.0369"), dome()).empty());
}

TEST_CASE("a path level in the workspace is told from one beyond it whatever the rounding") {
    cloud::Cloud slope = sheets::flat(0.05);  // turned back to level, with the last bits of that
    const Eigen::AngleAxisd tilt(0.5, Vector3d::UnitY());
    for (Vector3d& p : slope.points_m) p = tilt * p;
    const auto level = [&](double z_m, double depth_m = -0.01) {
        scene::Scene scene = sheets::skin(1e6);
        scene.placement = {.at_m = {0, 0, z_m}, .facing = "operator"};
        for (const double at_m : {-0.02, 0.01, 0.02}) {
            const Vector3d at = tilt * Vector3d(at_m, 0, 0);
            scene.hand.path.push_back({50.0 * at_m + 1.0, {at.x(), at.y(), at.z()}, depth_m});
        }
        return words_of(scene, slope);
    };
    for (int k = 1; k < 20; ++k) {  // 50 mm with tool and height, and a few ulps
        CHECK(level(0.047 - 1e-3 * k, -1e-3 * k).empty());
    }
    CHECK_THAT(level(0.0371), StartsWith("sheet:1: hand.path[0] at t_s = 0 is 0.1 mm beyond"));
    CHECK_THAT(level(0.04), StartsWith("sheet:1: hand.path[0] at t_s = 0 is 3.0 mm beyond"));
}

TEST_CASE("a path off the scan is named with its point or its leg") {
    const std::string start = PATH + point(0.0, 0.02, 0.0);
    CHECK_THAT(refusal(start + point(0.5, 0.03, 0.0) + "]\n", sheets::flat(0.04)),
               StartsWith("s.toml:10: hand.path[0] to [1] at t_s = 0.") &&
                   EndsWith(" has no smooth skin near it; choose points on one face of the scan"));
    CHECK(refusal(start + point(0.01, 0.03, 0.0) + "]\n", sheets::flat(0.04)) ==
          "s.toml:11: hand.path[1] at t_s = 0.01 has no smooth skin near it; choose points on one face of "
          "the scan");
}

TEST_CASE("a nodule and a focus off the scan are named with their line") {
    const std::string words = ": there is no smooth skin near this place; choose a point on the scan";
    CHECK(refusal("[[change]]\nshape = \"gradient\"\nfrom_m = [0, 0, 0]\nto_m = [1, 0, 0]\nfactor = [1, 2]\n"
                  "[[change]]\nshape = \"nodule\"\nat_m = [0.05, 0, 0]\nfactor = 2\n",
                  sheets::flat(0.04)) == "s.toml:15: change[1].at_m" + words);
    const std::string facing = "[placement]\nfacing = \"operator\"\n";
    CHECK(refusal(facing + "focus_m = [0.05, 0, 0]\n", sheets::flat(0.04)) ==
          "s.toml:10: placement.focus_m" + words);
    cloud::Cloud aside = sheets::flat(0.04);
    for (Vector3d& p : aside.points_m) p.x() += 0.1;
    CHECK(refusal(facing, aside) == "s.toml:8: placement.focus_m" + words);  // a default: its section
}

TEST_CASE("a patch larger than the object's longest side is refused with both sizes") {
    const std::string words =
        "patch.size_m = 50.0 mm is larger than the object (40.0 mm along its longest side); make the patch "
        "smaller or the object larger (object.size_m)";
    CHECK(refusal("[patch]\nsize_m = 0.05\n", sheets::flat(0.04)) == "s.toml:9: " + words);
    CHECK(refusal("[patch]\nsize_m = 0.04\n", sheets::flat(0.04)).empty());
    cloud::Cloud single = sheets::flat(0.04);
    for (Vector3d& p : single.points_m) p = p.cast<float>().cast<double>();
    CHECK(refusal("[patch]\nsize_m = 0.04\n", single).empty());
}

TEST_CASE("what a --set gave is named by it when it cannot be") {
    const std::string path = PATH + point(0.0, 0.0, 0.0) + point(1.0, 0.01, 0.0) + "]\n";
    const auto said = [&](const std::string& set) { return refusal(path, sheets::flat(0.04), {set}); };
    CHECK_THAT(said("hand.path.1.depth_m=-0.06"),
               StartsWith("--set hand.path[1].depth_m: hand.path[1] at t_s = 1 is 13.0 mm beyond"));
    CHECK_THAT(said("hand.path.0.at_m=[0.03,0,0]"), StartsWith("--set hand.path[0].at_m: hand.path[0] at "));
    CHECK_THAT(said("hand.path=[{t_s=0,at_m=[0,0,0],depth_m=0.06}]"),
               StartsWith("--set hand.path: hand.path[0] at t_s = 0 is 12.0 mm beyond"));
    CHECK_THAT(said("patch.size_m=0.05"), StartsWith("--set patch.size_m: patch.size_m = 50.0 mm is"));
    CHECK_THAT(said("object.size_m=0.01"), StartsWith("--set object.size_m: patch.size_m = 16.0 mm is"));
    CHECK_THAT(said("placement={focus_m=[0.05,0,0],facing=\"operator\"}"),
               StartsWith("--set placement: placement.focus_m: "));
}

TEST_CASE("a scene of no file still says where") {
    scene::Scene scene = sheets::skin(1e6);
    scene.patch.size_m = 0.05;
    CHECK_THAT(words_of(scene, sheets::flat(0.04)), StartsWith("sheet:1: patch.size_m = 50.0 mm"));
}

TEST_CASE("one ulp in one point's modulus, however far away, is another source, and so is one normal") {
    const scene::Scene scene = sheets::skin(1e6);
    auto world = scene::build(scene, sheets::flat(0.04));
    const std::uint64_t before = scene::source_hash_of(*world);
    CHECK(before == world->source_hash);
    world->cloud.young_pa.back() = std::nextafter(world->cloud.young_pa.back(), 2e6);
    const std::uint64_t other = scene::source_hash_of(*world);
    CHECK(other != before);
    world->cloud.normals.front() = -world->cloud.normals.front();  // decides what is inside
    CHECK(scene::source_hash_of(*world) != other);
}

namespace {

/// Two walls 0.6 mm apart, the upper one in z = 0, each facing away from the other.
cloud::Cloud thin_wall() {
    cloud::Cloud cloud = sheets::flat(0.04);
    cloud.normals.assign(cloud.points_m.size(), Vector3d::UnitZ());
    for (std::size_t i = 0, n = cloud.points_m.size(); i < n; ++i) {
        cloud.points_m.push_back(cloud.points_m[i] - Vector3d(0, 0, 0.6e-3));
        cloud.normals.push_back(-Vector3d::UnitZ());
    }
    return cloud;
}

}  // namespace

TEST_CASE("sides = outer makes of a thin double wall the single wall that is touched first") {
    scene::Scene scene = sheets::skin(1e6);
    const auto single = scene::build(scene, sheets::flat(0.04));
    const auto both = scene::build(scene, thin_wall());
    const std::size_t n = single->cloud.points_m.size();
    CHECK(both->n_other_side == 0);
    CHECK(both->cloud.points_m.size() == 2 * n);
    CHECK(both->spacing_m == Approx(0.6e-3));

    scene.object.sides = "outer";
    const auto upper = scene::build(scene, thin_wall());  // no path: from the focus, (0, 0, 0)
    CHECK(upper->n_other_side == n);
    CHECK(upper->source_hash == single->source_hash);
    CHECK(upper->object_hash == both->object_hash);  // the scan is the same
    CHECK(upper->spacing_m == Approx(1e-3));
    CHECK(upper->cloud.young_pa.size() == n);

    scene.hand.path = {{0.0, {0.0004, 0.0003, -0.0006}, -0.01}, {0.1, {0.005, 0, -0.0006}, 0.001}};
    const auto lower = scene::build(scene, thin_wall());
    CHECK(lower->n_other_side == n);
    CHECK(lower->cloud.normals.front().z() == -1.0);
    CHECK(lower->path.front().tool_m.z() == Approx(-0.0136));

    scene.hand.path.front().at_m[2] = 0.0;  // the path's own begin decides, not its rest
    CHECK(scene::build(scene, thin_wall())->cloud.normals.front().z() == 1.0);
}

TEST_CASE("a path is held to the hand's workspace, not to the object's, whatever the scale") {
    const std::string path = PATH + point(0.0, -0.02, -0.01) + point(1.0, 0.02, 0.002) + "]\n";
    const auto scaled = [&](const std::string& scale) {
        return refusal(path + "[placement]\nat_m = [0.02, 0, 0.02]\nposition_scale = " + scale + "\n",
                       sheets::flat(0.05));
    };
    CHECK(scaled("2").empty());
    CHECK(scaled("0.7").empty());
    CHECK_THAT(scaled("0.5"), StartsWith("s.toml:11: hand.path[1] at t_s = 1 is 10.0 mm beyond the workspace "
                                         "along +x (limit 50.0 mm)"));
}
