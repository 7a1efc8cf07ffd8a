#include <catch2/catch.hpp>

#include "host/plate/plate.hpp"
#include "tests/host/sheets.hpp"

using namespace palpate;
using Eigen::Vector3d;

namespace {

constexpr double SQUARE = 0.005612024;  // centre deflection of a clamped square, P a^2/D (PLATE, anchor 2)

/// Least-squares slope of the normal force against true depth, 50 depths of 1 to 5 mm, through encoder counts
/// and motor words; the place lies beside the grid's points.
double felt_stiffness(const scene::World& world, const Vector3d& at_m) {
    const table::StiffnessField field(*world.surface, world.material);
    const table::BuildOptions options = table::build_options(world);
    const auto table = sheets::table_at(world, field, options, at_m, 3e-3);
    REQUIRE(table);
    const pal_stand_config config = sheets::stand();
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (int i = 0; i < 50; ++i) {
        const double depth = 1e-3 + 4e-3 * i / 49.0;
        const double tool[3] = {at_m.x(), at_m.y(), at_m.z() + options.tool_radius_m - depth};
        double force[3];
        REQUIRE(pal_stand_static_force(&config, table.get(), tool, force));
        n += 1;
        sx += depth;
        sy += force[2];
        sxx += depth * depth;
        sxy += depth * force[2];
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

Vector3d workspace_point(int i) {
    const Vector3d points[5] = {
        {0, 0, 0}, {0.02, 0.01, 0.005}, {-0.02, 0.015, -0.01}, {0.01, -0.02, 0.01}, {-0.015, -0.015, 0}};
    return points[i];
}

}  // namespace

TEST_CASE("a clamped flat patch feels as stiff as the closed form, at five places of the workspace") {
    const int place = GENERATE(0, 1, 2, 3, 4);
    scene::Scene scene = sheets::skin(1.2e6);
    scene.skin.model = scene::Model::plate;
    const Vector3d at = workspace_point(place);
    scene.placement.at_m = {at.x() + 3e-4, at.y() - 2e-4, at.z()};  // the contact lies between grid points
    const auto world = scene::build(scene, sheets::flat(0.05));
    const double exact =
        sheets::rigidity_n_m(scene, 1.2e6) / (SQUARE * scene.patch.size_m * scene.patch.size_m);
    const double felt = felt_stiffness(*world, at);
    CAPTURE(place, exact, felt);
    CHECK(felt == Approx(exact).epsilon(0.01));
}

TEST_CASE("a large flat patch on a foundation feels as stiff as Hertz's plate on springs, at five places") {
    const int place = GENERATE(0, 1, 2, 3, 4);
    scene::Scene scene = sheets::skin(0.4e6);
    scene.skin.foundation_n_per_m3 = 2e7;
    scene.patch.size_m = 0.024;  // 14.7 l: the edge no longer matters
    const Vector3d at = workspace_point(place);
    scene.placement.at_m = {at.x() + 3e-4, at.y() - 2e-4, at.z()};
    const auto world = scene::build(scene, sheets::flat(0.06));
    const double exact = 8.0 * std::sqrt(sheets::rigidity_n_m(scene, 0.4e6) * 2e7);
    const double felt = felt_stiffness(*world, at);
    CAPTURE(place, exact, felt);
    CHECK(felt == Approx(exact).epsilon(0.01));
}
