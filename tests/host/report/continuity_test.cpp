#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "tests/host/sheets.hpp"

using namespace palpate;
using Eigen::Vector3d;

namespace {

/// A bumpy, unevenly stiff sheet, so that every field of the table varies.
std::unique_ptr<pal_table> bumpy_table() {
    scene::Scene scene = sheets::skin(0.4e6);
    scene.skin.foundation_n_per_m3 = 2e7;
    scene.changes.push_back({.shape = scene::Change::Shape::nodule,
                             .at_m = {0.002, 0, 0},
                             .radius_m = 0.003,
                             .edge_m = 0.002,
                             .factor = {5.0, 1.0}});
    cloud::Cloud cloud = sheets::flat(0.05);
    for (Vector3d& p : cloud.points_m)
        p.z() = 1e-3 * std::sin(p.x() / 2e-3) * std::cos(p.y() / 3e-3) - 8.0 * p.x() * p.x();
    const auto world = scene::build(scene, cloud);
    const table::StiffnessField field(*world->surface, world->material);
    return sheets::table_at(*world, field, table::build_options(*world), Vector3d::Zero(), 2e-3);
}

Vector3d force_at(const pal_table& table, const Vector3d& local_m) {
    Vector3d at(table.p0_m[0], table.p0_m[1], table.p0_m[2]);
    for (int row = 0; row < 3; ++row) {
        at += local_m[row] * Vector3d(table.axes[3 * row], table.axes[3 * row + 1], table.axes[3 * row + 2]);
    }
    const Eigen::Vector3f where = at.cast<float>();
    Eigen::Vector3f force;
    pal_stand_table_force(&table, where.data(), force.data());
    return force.cast<double>();
}

/// dF over each of 1000 crossings of cell lines, the same ones for every step.
std::vector<Vector3d> changes_over(const pal_table& table, double step_m) {
    std::mt19937 random(7);
    const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
    const int half = (static_cast<int>(table.n_nodes) - 1) / 2;
    std::vector<Vector3d> changes;
    for (int i = 0; i < 1000; ++i) {
        const int line = static_cast<int>(unit() * (half - 2)) - (half - 2) / 2;
        const double height = -1e-3 - 2e-3 * unit(),
                     along = (unit() - 0.5) * 0.8 * half * static_cast<double>(table.spacing_m);
        const double q = 1.0 + static_cast<double>(table.kappa_per_m) * height;
        const double cross = line * static_cast<double>(table.spacing_m) * q;  // u = x1/q on a cell line
        const bool in_u = i % 2 == 0;
        const auto at = [&](double d) {
            return in_u ? Vector3d(cross + d, along, height) : Vector3d(along, cross + d, height);
        };
        changes.emplace_back(force_at(table, at(0.5 * step_m)) - force_at(table, at(-0.5 * step_m)));
    }
    return changes;
}

double largest(const std::vector<Vector3d>& changes) {
    double size = 0.0;
    for (const Vector3d& change : changes) size = std::max(size, change.norm());
    return size;
}

}  // namespace

TEST_CASE("across a thousand cell lines the force changes in proportion to the step, at every one") {
    const auto table = bumpy_table();
    REQUIRE(table);
    const auto coarse = changes_over(*table, 4e-5), middle = changes_over(*table, 2e-5),
               fine = changes_over(*table, 1e-5);
    CAPTURE(largest(coarse), largest(middle), largest(fine));
    CHECK(largest(coarse) / largest(middle) == Approx(2.0).epsilon(0.05));
    CHECK(largest(middle) / largest(fine) == Approx(2.0).epsilon(0.05));
    CHECK(largest(fine) > 1e-3);  // the force does vary: a table of nothing would pass the rest
    // A jump J on one line makes dF(2 step) - 2 dF(step) = -J there. The force's own noise is 2e-5 N (float).
    double jump = 0.0;
    for (std::size_t i = 0; i < middle.size(); ++i) {
        jump = std::max(jump, (middle[i] - 2.0 * fine[i]).norm());
    }
    CAPTURE(jump);
    CHECK(jump < 5e-5);
}
