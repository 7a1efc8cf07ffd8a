// The ear of the Stanford bunny (package glmark2-data), 15 cm long: the walk that the demonstration's hand
// makes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include "host/contact/proxy.hpp"
#include "host/contact/surface.hpp"
#include "tests/host/contact/clouds.hpp"
#include "tests/lacking.hpp"

using palpate::contact::Foot;

using palpate::contact::Proxy;
using palpate::contact::Surface;
using namespace palpate::testing;

namespace {

constexpr double step_m = 1e-4;
const Eigen::Vector3d from(-0.0443, 0.0618, -0.0521);
const Eigen::Vector3d to(-0.0490, 0.0548, -0.0274);

std::unique_ptr<Scan> bunny() {
    const auto file = palpate::test::installed_bunny();
    if (!file) return nullptr;
    palpate::cloud::Cloud c = palpate::cloud::read(*file);
    Eigen::Vector3d low = c.points_m.front();
    Eigen::Vector3d high = low;
    for (const Eigen::Vector3d& p : c.points_m) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    for (Eigen::Vector3d& p : c.points_m) p = (p - 0.5 * (low + high)) * (0.15 / (high - low).maxCoeff());
    palpate::cloud::orient(c, palpate::cloud::Tree(c.points_m));
    return std::make_unique<Scan>(std::move(c));
}

int n_steps() {
    return static_cast<int>((to - from).norm() / step_m);
}

Eigen::Vector3d place(int i) {
    return from + (to - from) * (static_cast<double>(i) / n_steps());
}

}  // namespace

TEST_CASE("along the bunny's ear every place has a foot and the normals turn smoothly by 31 degrees") {
    const auto scan = bunny();
    if (!scan) return;
    const double spacing = palpate::cloud::median_spacing_m(scan->cloud, scan->tree);
    const Surface surface(scan->cloud, scan->graph, 4.0 * spacing);
    std::optional<Foot> before;
    std::optional<Foot> first;
    auto seed = scan->tree.nearest(from);
    double worst_turn_deg = 0.0;
    double worst_distance_m = 0.0;
    double turn_all_deg = 0.0;
    for (int i = 0; i <= n_steps(); ++i) {
        const auto foot = surface.foot(place(i), seed);
        CAPTURE(i);
        REQUIRE(foot);
        worst_distance_m = std::max(worst_distance_m, std::fabs(foot->distance_m));
        if (before) {
            worst_turn_deg = std::max(worst_turn_deg, angle_deg(before->normal, foot->normal));
            REQUIRE(foot->normal.dot(before->normal) > 0.999);  // one face
            REQUIRE((foot->point_m - before->point_m).norm() < 2.0 * step_m);
        } else {
            first = foot;
        }
        turn_all_deg = std::max(turn_all_deg, angle_deg(first->normal, foot->normal));
        before = foot;
        seed = foot->nearest;
    }
    WARN("spacing " << spacing * 1e3 << " mm; farthest from the chord " << worst_distance_m * 1e3
                    << " mm; normals turn by " << worst_turn_deg << " degrees per 0.1 mm at most, "
                    << turn_all_deg << " in all, " << angle_deg(first->normal, before->normal)
                    << " from end to end");
    REQUIRE(worst_distance_m < 0.002);
    REQUIRE(worst_turn_deg < 2.0);
    REQUIRE(angle_deg(first->normal, before->normal) == Approx(31.0).margin(6.0));

    // Again with all neighbourhoods cached, 5 mm deep, for the cost of one foot. Printed, not judged.
    const auto start = std::chrono::steady_clock::now();
    seed = scan->tree.nearest(from);
    for (int i = 0; i <= n_steps(); ++i) {
        const auto foot = surface.foot(place(i) - 0.005 * first->normal, seed);
        REQUIRE(foot);
        seed = foot->nearest;
    }
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    WARN("one foot 5 mm deep: " << passed.count() * 1e6 / (n_steps() + 1) << " us");
}

TEST_CASE("the proxy strokes the bunny's ear on one face, its normal near the surface's, 1 to 6 mm deep") {
    const auto scan = bunny();
    if (!scan) return;
    const double radius_m = 0.003;
    const double depth_m = GENERATE(as<double>{}, 0.001, 0.003, 0.006);
    const Surface surface(scan->cloud, scan->graph,
                          4.0 * palpate::cloud::median_spacing_m(scan->cloud, scan->tree));
    Proxy proxy(scan->cloud, scan->tree, scan->graph, radius_m);
    auto seed = scan->tree.nearest(from);
    static_cast<void>(proxy.follow(from + 0.02 * surface.foot(from, seed)->normal));
    double worst_deg = 0.0;
    double worst_aside_m = 0.0;
    double worst_height_m = 0.0;
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i <= n_steps(); ++i) {
        const auto foot = surface.foot(place(i), seed);
        REQUIRE(foot);
        seed = foot->nearest;
        const auto c = proxy.follow(foot->point_m + (radius_m - depth_m) * foot->normal);
        CAPTURE(i);
        REQUIRE(c);
        REQUIRE(c->touching);
        const auto below = surface.foot(c->proxy_m, c->nearest);
        REQUIRE(below);
        worst_deg = std::max(worst_deg, angle_deg(c->normal, below->normal));
        worst_aside_m = std::max(worst_aside_m, (below->point_m - foot->point_m).norm());
        worst_height_m = std::max(worst_height_m, std::fabs(below->distance_m - radius_m));
        REQUIRE(foot->normal.dot(below->normal) > 0.9);
    }
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    WARN("depth " << depth_m * 1e3 << " mm: normal off by " << worst_deg << " degrees, proxy aside by "
                  << worst_aside_m * 1e3 << " mm, height off by " << worst_height_m * 1e3
                  << " mm; one step with two feet " << passed.count() * 1e6 / (n_steps() + 1) << " us");
    REQUIRE(worst_deg < 10.0);
    REQUIRE(worst_height_m < 0.2 * radius_m);
}
