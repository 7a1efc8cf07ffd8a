#include "host/contact/surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/host/contact/clouds.hpp"

using palpate::contact::Foot;
using palpate::contact::Surface;
using namespace palpate::testing;

namespace {

constexpr double spacing_m = 0.001;
constexpr double support_m = 0.004;
const Bumps bumps{0.0003, 0.02};  // curvature up to 30 /m, R 34 mm

/// Largest second difference of the distance along a straight walk, m.
double roughest_m(const Surface& surface, const Scan& scan, double height_m, double step_m, int n_steps,
                  double x_from_m = -0.01) {
    std::vector<double> distances;
    palpate::cloud::Index seed = scan.tree.nearest({x_from_m, 0.002, height_m});
    for (int i = 0; i <= n_steps; ++i) {
        const double x = x_from_m + step_m * i;
        const auto foot = surface.foot({x, 0.002 + 0.31 * (x + 0.01), height_m}, seed);
        REQUIRE(foot);
        distances.push_back(foot->distance_m);
        seed = foot->nearest;
    }
    double worst = 0.0;
    for (std::size_t i = 1; i + 1 < distances.size(); ++i) {
        worst = std::max(worst, std::fabs(distances[i + 1] - 2.0 * distances[i] + distances[i - 1]));
    }
    return worst;
}

/// How the roughest place of a 20 mm walk changes when the step is halved: a quarter where the distance is
/// smooth, no change where it jumps.
double halving_ratio(const Surface& surface, const Scan& scan, double height_m) {
    const double coarse = roughest_m(surface, scan, height_m, 1e-5, 2000);
    return roughest_m(surface, scan, height_m, 0.5e-5, 4000) / coarse;
}

}  // namespace

TEST_CASE("the surface through points of a sphere is the sphere, from outside and inside, convex and bowl") {
    const bool inward = GENERATE(false, true);
    const double radius = 0.03;
    const Scan scan(ball(radius, spacing_m, inward));
    const Surface surface(scan.cloud, scan.graph, support_m);
    const double sign = inward ? -1.0 : 1.0;
    std::mt19937 random(5);
    double worst_m = 0.0;
    double worst_deg = 0.0;
    for (int i = 0; i < 500; ++i) {
        const Eigen::Vector3d way =
            Eigen::Vector3d(uniform(random) - 0.5, uniform(random) - 0.5, uniform(random) - 0.5).normalized();
        const double height = 0.009 * uniform(random) - 0.006;
        const Eigen::Vector3d at = (radius + height) * way;
        const auto foot = surface.foot(at, scan.tree.nearest(at));
        REQUIRE(foot);
        worst_m = std::max(
            {worst_m, std::fabs(foot->distance_m - sign * height), (foot->point_m - radius * way).norm()});
        worst_deg = std::max(worst_deg, angle_deg(foot->normal, sign * way));
        REQUIRE(foot->kappa_per_m == Approx(sign / radius).epsilon(1e-9));
        REQUIRE(foot->nearest == scan.tree.nearest(foot->point_m));
    }
    CAPTURE(worst_m, worst_deg);
    REQUIRE(worst_m < 1e-10);
    REQUIRE(worst_deg < 1e-6);
}

TEST_CASE("the surface through points of a plane is the plane") {
    const Scan scan(sheet({}, 0.015, spacing_m));
    const Surface surface(scan.cloud, scan.graph, support_m);
    for (const double height : {-0.006, -0.0001, 0.0, 0.002}) {
        const Eigen::Vector3d at(0.0013, -0.0042, height);
        const auto foot = surface.foot(at, scan.tree.nearest(at));
        REQUIRE(foot);
        REQUIRE(foot->distance_m == Approx(height).margin(1e-15));
        REQUIRE((foot->point_m - Eigen::Vector3d(0.0013, -0.0042, 0.0)).norm() < 1e-15);
        REQUIRE(std::fabs(foot->kappa_per_m) < 1e-9);
    }
}

TEST_CASE("on a bumpy sheet the surface is near the truth and the normal is the gradient of the distance") {
    const Scan scan(sheet(bumps, 0.025, spacing_m));
    const Surface surface(scan.cloud, scan.graph, support_m);
    std::mt19937 random(17);
    const double step = 1e-6;
    double worst_gradient = 0.0;
    double worst_height_m = 0.0;
    double worst_normal_deg = 0.0;
    for (int i = 0; i < 200; ++i) {
        const Eigen::Vector3d at(0.03 * (uniform(random) - 0.5), 0.03 * (uniform(random) - 0.5),
                                 0.006 * uniform(random) - 0.004);
        const auto seed = scan.tree.nearest(at);
        const auto foot = surface.foot(at, seed);
        REQUIRE(foot);
        Eigen::Vector3d gradient;
        for (int axis = 0; axis < 3; ++axis) {
            const Eigen::Vector3d d = step * Eigen::Vector3d::Unit(axis);
            gradient(axis) =
                (surface.foot(at + d, seed)->distance_m - surface.foot(at - d, seed)->distance_m) /
                (2.0 * step);
        }
        worst_gradient = std::max(worst_gradient, (gradient - foot->normal).norm());
        const Eigen::Vector3d& p = foot->point_m;
        worst_height_m = std::max(worst_height_m, std::fabs(p.z() - bumps.height_m(p.x(), p.y())));
        worst_normal_deg = std::max(worst_normal_deg, angle_deg(foot->normal, bumps.normal(p.x(), p.y())));
        REQUIRE((at - p).cross(foot->normal).norm() < 1e-12);
        REQUIRE(foot->distance_m == Approx((at - p).dot(foot->normal)).margin(1e-14));
    }
    WARN("gradient - normal at most " << worst_gradient << ", height off by " << worst_height_m * 1e6
                                      << " um, normal by " << worst_normal_deg << " degrees");
    REQUIRE(worst_gradient < 1e-2);
    REQUIRE(worst_height_m < 1e-5);
    REQUIRE(worst_normal_deg < 1.0);
}

TEST_CASE("walking over a bumpy sheet the distance never jumps") {
    const double height = GENERATE(as<double>{}, 0.001, -0.003);
    const Scan scan(sheet(bumps, 0.025, spacing_m));
    const Surface surface(scan.cloud, scan.graph, support_m);
    const double ratio = halving_ratio(surface, scan, height);
    WARN("halving the step divides the largest second difference by " << 1.0 / ratio);
    REQUIRE(ratio < 0.35);

    // With a graph that measures 1.7 times too far the lists miss points within the support, and the check
    // sees the jumps.
    palpate::cloud::Cloud wide = scan.cloud;
    for (Eigen::Vector3d& p : wide.points_m) p *= 1.7;
    const Scan stretched(std::move(wide));
    const Surface truncated(scan.cloud, stretched.graph, support_m);
    REQUIRE(halving_ratio(truncated, scan, height) > 0.7);
}

TEST_CASE("where the scan gets sparse the support grows without a jump") {
    const Scan scan(sheet(bumps, 0.025, spacing_m, -0.002));
    const Surface surface(scan.cloud, scan.graph, 0.003);  // three spacings; the sparse half has 2.5 mm
    REQUIRE(halving_ratio(surface, scan, -0.001) < 0.35);
}

TEST_CASE("the foot stays on the sheet of its seed, however near the other wall is") {
    palpate::cloud::Cloud walls;
    add_sheet(walls, bumps, 0.0, 0.02, spacing_m, false, 1);
    const std::size_t n_upper = walls.points_m.size();
    add_sheet(walls, bumps, -0.003, 0.02, spacing_m, true, 2);
    const Scan scan(std::move(walls));
    const Surface surface(scan.cloud, scan.graph, support_m);
    const Scan alone(sheet(bumps, 0.02, spacing_m));
    const Surface upper(alone.cloud, alone.graph, support_m);
    for (const double depth : {0.0, 0.0012, 0.0018, 0.0029, 0.005}) {
        const Eigen::Vector3d at(0.0021, -0.0017, bumps.height_m(0.0021, -0.0017) - depth);
        const auto seed = alone.tree.nearest(Eigen::Vector3d(at.x(), at.y(), 0.0));
        REQUIRE(seed < n_upper);
        const auto foot = surface.foot(at, seed);
        const auto truth = upper.foot(at, seed);
        CAPTURE(depth);
        REQUIRE(foot);
        REQUIRE(truth);
        REQUIRE(foot->nearest < n_upper);
        REQUIRE(foot->distance_m == truth->distance_m);
        REQUIRE(foot->normal.z() > 0.8);
    }
}

TEST_CASE("over a rim that is as sharp as the support is wide the distance does not jump either") {
    // 3 mm thick: within 2 mm the normals of the rim turn by 76 degrees, so points leave the side on the way.
    const Scan scan(hairpin(0.003, 0.012, 0.0005));
    const Surface surface(scan.cloud, scan.graph, 0.002);
    const auto roughest = [&](double step_m, int n_steps) {
        return roughest_m(surface, scan, 0.002, step_m, n_steps, -0.004);
    };
    const double ratio = roughest(0.5e-5, 1000) / roughest(1e-5, 500);
    REQUIRE(ratio < 0.35);
    const auto foot = surface.foot({-0.004, 0.0, -0.001}, scan.tree.nearest({-0.004, 0.0, 0.0015}));
    REQUIRE(foot);
    REQUIRE(foot->distance_m == Approx(-0.0025).epsilon(1e-6));
}

TEST_CASE("past the edge of an open sheet there is no foot") {
    const Scan scan(sheet({}, 0.01, spacing_m));
    const Surface surface(scan.cloud, scan.graph, support_m);
    const auto seed = scan.tree.nearest({0.009, 0.0, 0.0});
    REQUIRE(surface.foot({0.0095, 0.0, 0.001}, seed));
    REQUIRE_FALSE(surface.foot({0.014, 0.0, 0.001}, seed));
}

TEST_CASE("a line meets the raised surface where its distance is the raise") {
    const Scan scan(ball(0.03, spacing_m));
    const Surface surface(scan.cloud, scan.graph, support_m);
    const Eigen::Vector3d at(0.001, -0.002, 0.0305);
    const Eigen::Vector3d direction = Eigen::Vector3d(0.2, -0.3, 0.9).normalized();
    const double raise = 0.003;
    const auto t = surface.along(at, direction, raise, 0.01, scan.tree.nearest(at));
    REQUIRE(t);
    REQUIRE((at + *t * direction).norm() == Approx(0.033).epsilon(1e-12));
    REQUIRE_FALSE(surface.along(at, direction, raise, 0.5 * std::fabs(*t), scan.tree.nearest(at)));
    REQUIRE_FALSE(surface.along(at, at.cross(direction).normalized(), raise, 0.01, scan.tree.nearest(at)));

    const Scan bumpy(sheet(bumps, 0.02, spacing_m));
    const Surface rough(bumpy.cloud, bumpy.graph, support_m);
    const Eigen::Vector3d from(0.0023, 0.0031, -0.002);
    const auto seed = bumpy.tree.nearest(from);
    const auto s = rough.along(from, direction, raise, 0.02, seed);
    REQUIRE(s);
    REQUIRE(rough.foot(from + *s * direction, seed)->distance_m == Approx(raise).epsilon(1e-7));
}
