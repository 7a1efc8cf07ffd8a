#include "host/scene/world.hpp"

#include <catch2/catch.hpp>

#include <cmath>

#include "tests/host/sheets.hpp"

using namespace palpate;
using Catch::Matchers::Contains;
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

TEST_CASE("a path beyond the workspace names the axis and the excess") {
    scene::Scene scene = sheets::skin(1e6);
    scene.placement.at_m = {0.0423, 0, 0};
    scene.hand.path = {{0.0, {0, 0, 0}, -0.01}, {1.0, {0.02, 0, 0}, 0.002}};
    const std::string words = words_of(scene, sheets::flat(0.05));
    CHECK_THAT(words, Contains("+x") && Contains("12.3 mm"));
}

TEST_CASE("a patch larger than the object is refused with both sizes") {
    scene::Scene scene = sheets::skin(1e6);
    scene.patch.size_m = 0.1;
    CHECK_THAT(words_of(scene, sheets::flat(0.02)), Contains("100.0 mm") && Contains("28.3 mm"));
}

TEST_CASE("one ulp in one point's modulus, however far away, is another source") {
    const scene::Scene scene = sheets::skin(1e6);
    auto world = scene::build(scene, sheets::flat(0.04));
    const std::uint64_t before = scene::source_hash_of(*world);
    CHECK(before == world->source_hash);
    world->cloud.young_pa.back() = std::nextafter(world->cloud.young_pa.back(), 2e6);
    CHECK(scene::source_hash_of(*world) != before);
}
