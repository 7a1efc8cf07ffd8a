#include <catch2/catch.hpp>
#include <vector>

#include "tests/host/sheets.hpp"

using namespace palpate;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double DEPTH_M = 4e-3;
constexpr double STEP_M = 2e-5;

/// A corner of a closed path: place on the sheet and depth.
struct Corner {
    double x_m, y_m, depth_m;
};

/// Five laps on the sheet; the first goes straight up the gradient of k at constant depth and returns in the
/// air.
const std::vector<std::vector<Corner>>& laps() {
    static const std::vector<std::vector<Corner>> all = {
        {{-0.005, 0, -1e-3},
         {-0.005, 0, DEPTH_M},
         {0.005, 0, DEPTH_M},
         {0.005, 0, -1e-3},
         {-0.005, 0, -1e-3}},
        {{0, -0.005, -1e-3}, {0, -0.005, 3e-3}, {0, 0.005, 3e-3}, {0, 0.005, -1e-3}, {0, -0.005, -1e-3}},
        {{-0.005, -0.004, -1e-3},
         {-0.005, -0.004, 3e-3},
         {0.005, 0.004, 3e-3},
         {0.005, 0.004, -1e-3},
         {-0.005, -0.004, -1e-3}},
        {{-0.005, -0.003, 1e-3},
         {0.005, -0.003, DEPTH_M},
         {0.005, 0.003, 2e-3},
         {-0.005, 0.003, 1e-3},
         {-0.005, -0.003, 1e-3}},
        {{-0.004, 0.002, 2e-3}, {0.002, -0.004, 2e-3}, {0.002, 0.004, 2e-3}, {-0.004, 0.002, 2e-3}}};
    return all;
}

struct Sheet {
    std::unique_ptr<scene::World> world;
    std::unique_ptr<table::StiffnessField> field;
    table::BuildOptions options;
};

/// Young's modulus rises along x so that k goes from about 500 to 800 N/m over 10 mm of one table.
Sheet stiffening_sheet() {
    scene::Scene scene = sheets::skin(0.4e6);
    scene.skin.foundation_n_per_m3 = 2e7;
    scene.changes.push_back({.shape = scene::Change::Shape::gradient,
                             .from_m = {-0.009, 0, 0},
                             .to_m = {0.009, 0, 0},
                             .factor = {0.6, 4.2}});
    Sheet sheet{scene::build(scene, sheets::flat(0.05)), nullptr, {}};
    sheet.field = std::make_unique<table::StiffnessField>(*sheet.world->surface, sheet.world->material);
    sheet.options = table::build_options(*sheet.world);
    sheet.options.n_nodes = 33;  // at the same spacing: twice as wide as in a run, for the whole lap
    return sheet;
}

struct Lap {
    double put_in_j = 0.0, net_j = 0.0, k_min = 1e9, k_max = 0.0;
};

/// Static force map: counts in, motor words out, no delay; trapezoid rule over the true path.
Lap lap_of(const Sheet& sheet, const pal_table& table, const std::vector<Corner>& corners) {
    const pal_stand_config config = sheets::stand();
    const auto place = [&](const Corner& c) {
        return Vector3d(c.x_m, c.y_m, sheet.options.tool_radius_m - c.depth_m);
    };
    const auto force_at = [&](const Vector3d& at) {
        double force[3];
        REQUIRE(pal_stand_static_force(&config, &table, at.data(), force));
        return Vector3d(force[0], force[1], force[2]);
    };
    Lap lap;
    Vector3d at = place(corners.front()), force = force_at(at);
    for (std::size_t leg = 1; leg < corners.size(); ++leg) {
        const Vector3d from = at, to = place(corners[leg]);
        const int n = static_cast<int>(std::ceil((to - from).norm() / STEP_M));
        for (int i = 1; i <= n; ++i) {
            const Vector3d next = from + (to - from) * (static_cast<double>(i) / n);
            const Vector3d then = force_at(next);
            const double work = 0.5 * (force + then).dot(next - at);  // of the device on the hand
            lap.net_j += work;
            lap.put_in_j += std::max(0.0, -work);
            at = next;
            force = then;
            const auto foot = sheet.world->surface->foot(at, sheet.world->tree->nearest(at));
            if (i % 50 == 0 && foot && foot->distance_m < sheet.options.tool_radius_m) {
                const double k = sheet.field->at(*foot).n_per_m;
                lap.k_min = std::min(lap.k_min, k);
                lap.k_max = std::max(lap.k_max, k);
            }
        }
    }
    return lap;
}

}  // namespace

TEST_CASE("five closed paths return the work put in within 1 %, where the normal law makes energy") {
    const Sheet sheet = stiffening_sheet();
    const auto table = sheets::table_at(*sheet.world, *sheet.field, sheet.options, Vector3d::Zero(), 3e-3);
    REQUIRE(table);
    int varied = 0;
    for (std::size_t i = 0; i < laps().size(); ++i) {
        table->law = PAL_LAW_POTENTIAL;
        const Lap conserving = lap_of(sheet, *table, laps()[i]);
        table->law = PAL_LAW_NORMAL;
        const Lap normal = lap_of(sheet, *table, laps()[i]);
        CAPTURE(i, conserving.net_j, normal.net_j, conserving.put_in_j, conserving.k_min, conserving.k_max);
        CHECK(std::abs(conserving.net_j) <= 0.01 * conserving.put_in_j);
        if (conserving.k_max < 1.5 * conserving.k_min) continue;
        ++varied;
        CHECK(std::abs(normal.net_j) > 10.0 * std::abs(conserving.net_j));
    }
    CHECK(varied >= 3);
}

TEST_CASE("the normal law makes (k2 - k1) d^2/2 a lap from soft to stiff") {
    const Sheet sheet = stiffening_sheet();
    const auto table = sheets::table_at(*sheet.world, *sheet.field, sheet.options, Vector3d::Zero(), DEPTH_M);
    REQUIRE(table);
    const auto k_at = [&](double x_m) {
        const Vector3d at(x_m, 0, 0);
        return sheet.field->at(*sheet.world->surface->foot(at, sheet.world->tree->nearest(at))).n_per_m;
    };
    // Ends chosen so that k goes from 500 to 800 N/m: 2.4 mJ at 4 mm.
    const auto where = [&](double k) {
        double low = -0.008, high = 0.008;
        for (int i = 0; i < 50; ++i) (k_at(0.5 * (low + high)) < k ? low : high) = 0.5 * (low + high);
        return 0.5 * (low + high);
    };
    const double soft = where(500.0), stiff = where(800.0);
    const std::vector<Corner> lap = {
        {soft, 0, -1e-3}, {soft, 0, DEPTH_M}, {stiff, 0, DEPTH_M}, {stiff, 0, -1e-3}, {soft, 0, -1e-3}};
    table->law = PAL_LAW_NORMAL;
    const double made = lap_of(sheet, *table, lap).net_j;
    CAPTURE(soft, stiff, made);
    CHECK(made == Approx(0.5 * (800.0 - 500.0) * DEPTH_M * DEPTH_M).epsilon(0.03));  // counts and words round
}
