#include "host/table/stiffness_field.hpp"

#include <catch2/catch.hpp>

#include "tests/host/sheets.hpp"

using namespace palpate;
using Eigen::Vector3d;

namespace {

/// A five times stiffer spot in a sheet on a foundation, as in the bunny's ear.
std::unique_ptr<scene::World> spotted_sheet() {
    scene::Scene scene = sheets::skin(0.4e6);
    scene.skin.foundation_n_per_m3 = 2e7;
    scene.changes.push_back({.shape = scene::Change::Shape::nodule,
                             .at_m = {0, 0, 0},
                             .radius_m = 0.006,
                             .edge_m = 0.002,
                             .factor = {5.0, 1.0}});
    return scene::build(scene, sheets::flat(0.05));
}

contact::Foot foot_at(const scene::World& world, double x_m, double y_m) {
    const Vector3d at(x_m, y_m, 0);
    const auto foot = world.surface->foot(at, world.tree->nearest(at));
    REQUIRE(foot);
    return *foot;
}

}  // namespace

TEST_CASE("between the scan's points the field is within 1 % of a fresh solve, over a lump's rim too") {
    const auto world = spotted_sheet();
    const table::StiffnessField field(*world->surface, world->material);
    double worst = 0.0;
    for (int i = 0; i <= 24; ++i) {
        const contact::Foot foot = foot_at(*world, 0.5e-3 * i + 2e-4, 3.7e-4);
        const double fresh = chart::point_stiffness(*world->surface, foot, world->material).n_per_m;
        worst = std::max(worst, std::abs(field.at(foot).n_per_m / fresh - 1.0));
    }
    CAPTURE(worst);
    CHECK(worst < 0.01);
    CHECK(field.at(foot_at(*world, 0, 0)).n_per_m > 1.8 * field.at(foot_at(*world, 0.012, 0)).n_per_m);
}

TEST_CASE("a point is solved once") {
    const auto world = spotted_sheet();
    const table::StiffnessField field(*world->surface, world->material);
    const contact::Foot foot = foot_at(*world, 1e-3, 2e-3);
    const double first = field.at(foot).n_per_m;
    const std::size_t solved = field.n_solved();
    CHECK(solved > 10);
    CHECK(field.at(foot).n_per_m == first);
    CHECK(field.n_solved() == solved);
}

TEST_CASE("what is baked is all that is asked for later") {
    const auto world = spotted_sheet();
    const table::StiffnessField field(*world->surface, world->material);
    const auto points = field.needed_for(foot_at(*world, 0, 0), 3e-3);
    std::size_t told = 0;
    field.bake(points, [&](std::size_t n) { told = n; });
    CHECK(told == points.size());
    const std::size_t solved = field.n_solved();
    for (const double x : {-2e-3, 0.0, 2e-3}) static_cast<void>(field.at(foot_at(*world, x, 1e-3)));
    CHECK(field.n_solved() == solved);
}

TEST_CASE("where no plate can be cut the field says so") {
    scene::Scene scene = sheets::skin(0.4e6);
    scene.patch.size_m = 0.016;
    cloud::Cloud strip = sheets::flat(0.04);
    std::erase_if(strip.points_m, [](const Vector3d& p) { return std::abs(p.y()) > 0.0025; });
    const auto world = scene::build(scene, strip);
    const table::StiffnessField field(*world->surface, world->material);
    CHECK(std::isnan(field.at(foot_at(*world, 0, 0)).n_per_m));
}

TEST_CASE("at a rim and beyond it there is a value near the skin's, or none") {
    scene::Scene scene = sheets::skin(0.4e6);
    scene.skin.foundation_n_per_m3 = 2e7;
    const auto world = scene::build(scene, sheets::flat(0.04));
    const table::StiffnessField field(*world->surface, world->material);
    const double middle = field.at(foot_at(*world, 0, 0)).n_per_m;
    int n_known = 0, n_none = 0;
    for (double x = 14e-3; x < 22e-3; x += 0.3e-3) {
        for (double y = 1e-3; y < 22e-3; y += 0.3e-3) {  // two rims and their corner
            const auto foot = world->surface->foot({x, y, 1e-3}, world->tree->nearest({x, y, 0}));
            const double k = foot ? field.at(*foot).n_per_m : std::nan("");
            CAPTURE(x, y, k, middle);
            if (std::isnan(k)) {
                ++n_none;
                CHECK(std::max(x, y) > 18e-3);
            } else {
                ++n_known;
                CHECK((k > 0.6 * middle && k < 1.02 * middle));
            }
        }
    }
    CHECK(n_known > 1200);
    CHECK(n_none > 100);
}
