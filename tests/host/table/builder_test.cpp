#include "host/table/builder.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "firmware/core/intake.h"
#include "tests/host/sheets.hpp"

using namespace palpate;
using Eigen::Vector3d;

namespace {

Vector3d table_force(const pal_table& table, const Vector3d& at_m) {
    const Eigen::Vector3f at = at_m.cast<float>();
    Eigen::Vector3f force;
    pal_stand_table_force(&table, at.data(), force.data());
    return force.cast<double>();
}

struct Bump {
    std::unique_ptr<scene::World> world;
    std::unique_ptr<table::StiffnessField> field;
    table::BuildOptions options;
};

/// A sphere's cap of 30 mm radius with a stiff spot, on a foundation.
Bump spotted_cap(const scene::Placement& placement = {}) {
    scene::Scene scene = sheets::skin(0.4e6);
    scene.skin.foundation_n_per_m3 = 2e7;
    scene.placement = placement;
    scene.changes.push_back({.shape = scene::Change::Shape::nodule,
                             .at_m = {0.003, 0, 0},
                             .radius_m = 0.005,
                             .edge_m = 0.002,
                             .factor = {5.0, 1.0}});
    cloud::Cloud cloud = sheets::flat(0.04);
    for (Vector3d& p : cloud.points_m) p.z() = std::sqrt(9e-4 - p.x() * p.x() - p.y() * p.y()) - 0.03;
    Bump bump{scene::build(scene, cloud), nullptr, {}};
    bump.field = std::make_unique<table::StiffnessField>(*bump.world->surface, bump.world->material);
    bump.options = table::build_options(*bump.world);
    return bump;
}

/// U = k d^2/2 from the skin and the field, no table.
double energy(const Bump& bump, const Vector3d& tool_m) {
    const auto foot = bump.world->surface->foot(tool_m, bump.world->tree->nearest(tool_m));
    const double depth = bump.options.tool_radius_m - foot->distance_m;
    return depth > 0.0 ? 0.5 * bump.field->at(*foot).n_per_m * depth * depth : 0.0;
}

Vector3d gradient_force(const Bump& bump, const Vector3d& tool_m) {
    Vector3d force;
    for (int axis = 0; axis < 3; ++axis) {
        const Vector3d step = 5e-5 * Vector3d::Unit(axis);
        force[axis] = -(energy(bump, tool_m + step) - energy(bump, tool_m - step)) / 1e-4;
    }
    return force;
}

}  // namespace

TEST_CASE("a table's force is the gradient of k d^2/2 within 2 % around the place it was made for") {
    const Bump bump = spotted_cap();
    const auto table = sheets::table_at(*bump.world, *bump.field, bump.options, {0, 0, 0}, 2e-3);
    REQUIRE(table);
    double worst = 0.0, largest = 0.0;
    for (const double x : {-1e-3, 0.0, 1e-3}) {
        for (const double y : {-1e-3, 0.3e-3}) {
            for (const double below : {1.6e-3, 2e-3, 2.4e-3}) {
                const Vector3d at(x, y, bump.options.tool_radius_m - below);
                const Vector3d truth = gradient_force(bump, at);
                worst = std::max(worst, (table_force(*table, at) - truth).norm());
                largest = std::max(largest, truth.norm());
            }
        }
    }
    CAPTURE(worst, largest);
    CHECK(worst < 0.02 * largest);
    CHECK(largest > 0.5);
}

TEST_CASE("a table passes the loop's check and says what it was made from") {
    const Bump bump = spotted_cap();
    const auto table = sheets::table_at(*bump.world, *bump.field, bump.options, {0, 0, 0}, 2e-3);
    REQUIRE(table);
    const pal_table_limits limits = pal_table_limits_default();
    CHECK(pal_table_check(table.get(), &limits) == PAL_OK);
    CHECK(table->source_hash == bump.world->source_hash);
    CHECK(static_cast<double>(table->kappa_per_m) ==
          Approx(1.0 / 0.033).epsilon(0.02));  // raised by the tool's radius
}

TEST_CASE("fewer nodes make a smaller table in the same frame, however fine they are") {
    Bump bump = spotted_cap();
    const auto full = sheets::table_at(*bump.world, *bump.field, bump.options, {1e-3, 0, 0}, 2e-3);
    bump.options.n_nodes = 7;
    bump.options.spacing_m = 0.2e-3;  // 1.2 mm wide, on a scan of 1 mm
    const auto small = sheets::table_at(*bump.world, *bump.field, bump.options, {1e-3, 0, 0}, 2e-3);
    REQUIRE(full);
    REQUIRE(small);
    CHECK(small->kappa_per_m == full->kappa_per_m);
    for (int i = 0; i < 3; ++i) CHECK(small->p0_m[i] == full->p0_m[i]);
    for (int i = 0; i < 9; ++i) CHECK(small->axes[i] == full->axes[i]);
    const Vector3d at(1.2e-3, -1e-4, bump.options.tool_radius_m - 2e-3);
    CHECK((table_force(*small, at) - table_force(*full, at)).norm() < 0.01 * table_force(*full, at).norm());
}

TEST_CASE("near a rim the table's valid radius ends before the skin does") {
    const Bump bump = spotted_cap();
    const auto inside = sheets::table_at(*bump.world, *bump.field, bump.options, {0, 0, 0}, 1e-3);
    const double r = 0.019, to_rim_m = 0.02 - r, raised = 33.0 / 30.0;
    const Vector3d near_rim(r, 0, std::sqrt(9e-4 - r * r) - 0.03);
    const auto rim = sheets::table_at(*bump.world, *bump.field, bump.options, near_rim, 1e-3);
    REQUIRE(inside);
    REQUIRE(rim);
    CHECK(inside->valid_radius_m > 0.0045F);
    // The skin is where a point of the scan is within 1.5 spacings.
    CHECK(static_cast<double>(rim->valid_radius_m) < raised * (to_rim_m + 1.5 * bump.world->spacing_m));
}

TEST_CASE("scales change what the hand feels by their product, and where by the first") {
    const Bump plain = spotted_cap();
    scene::Placement doubled;
    doubled.position_scale = 2.0;
    doubled.force_scale = 0.25;
    const Bump scaled = spotted_cap(doubled);
    const auto a = sheets::table_at(*plain.world, *plain.field, plain.options, {0, 0, 0}, 2e-3);
    const auto b = sheets::table_at(*scaled.world, *scaled.field, scaled.options, {0, 0, 0}, 2e-3);
    REQUIRE(a);
    REQUIRE(b);
    for (const Vector3d& at : {Vector3d(0, 0, 1e-3), Vector3d(1e-3, -5e-4, 0.8e-3)}) {
        const Vector3d on_object = table_force(*a, at), in_hand = table_force(*b, at / 2.0);
        CHECK((in_hand - 0.25 * on_object).norm() < 1e-4 * on_object.norm());
    }
}
