#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "host/cloud/neighbours.hpp"
#include "tests/host/cloud/samples.hpp"
#include "tests/lacking.hpp"

namespace palpate::cloud {
namespace {

constexpr double COS_75_DEGREES = 0.25881904510252074;

/// n x n points 1 mm apart in the plane z, all facing `normal`.
void add_sheet(Cloud& cloud, int n, double z_m, const Eigen::Vector3d& normal) {
    for (int i = 0; i < n * n; ++i) {
        cloud.points_m.emplace_back(1e-3 * (i % n), 1e-3 * (i / n), z_m);
        cloud.normals.push_back(normal);
    }
}

Index at(int n, int x, int y) {
    return static_cast<Index>(y * n + x);
}

}  // namespace

TEST_CASE("a region never crosses to the other wall of a thin object, and covers its own wall") {
    const double gap_m = GENERATE(as<double>{}, 3e-3, 1e-3);
    const int n = 30;
    Cloud cloud;
    add_sheet(cloud, n, gap_m, Eigen::Vector3d::UnitZ());
    add_sheet(cloud, n, 0.0, -Eigen::Vector3d::UnitZ());
    const Graph graph(cloud, Tree(cloud.points_m));
    const bool same_side = GENERATE(as<bool>{}, false, true);
    for (const Index seed : {at(n, 15, 15), at(n, 0, 0), static_cast<Index>(n * n + 5)}) {
        const std::vector<Reached> region = graph.grow(seed, 0.1, same_side);
        CHECK(region.size() == static_cast<std::size_t>(n * n));
        for (const Reached& reached : region)
            REQUIRE(cloud.points_m[reached.point].z() == cloud.points_m[seed].z());
    }
}

TEST_CASE(
    "walls that face the same way do join where they are nearest neighbours, so the check above can fail") {
    const int n = 30;
    Cloud cloud;
    add_sheet(cloud, n, 1e-3, Eigen::Vector3d::UnitZ());
    add_sheet(cloud, n, 0.0, Eigen::Vector3d::UnitZ());
    const Graph graph(cloud, Tree(cloud.points_m));
    CHECK(graph.grow(at(n, 15, 15), 0.1, true).size() == static_cast<std::size_t>(2 * n * n));
}

// With 8 or more neighbours a step is along a side or a diagonal at least, so the path is never longer than
// the octile distance, which exceeds the straight one by at most 1 / cos(22.5 degrees) = 1.0824; no path is
// shorter than straight.
TEST_CASE("distances on a flat grid lie between the straight one and 1.0824 times that") {
    const int n = 41;
    Cloud cloud;
    add_sheet(cloud, n, 0.0, Eigen::Vector3d::UnitZ());
    const Graph graph(cloud, Tree(cloud.points_m));
    const Index seed = at(n, 20, 20);
    const std::vector<Reached> region = graph.grow(seed, 0.015, true);
    std::size_t n_inside = 0;
    for (const Eigen::Vector3d& point_m : cloud.points_m)
        n_inside += (point_m - cloud.points_m[seed]).norm() * 1.0824 <= 0.015 ? 1U : 0U;
    CHECK(region.size() >= n_inside);
    for (const Reached& reached : region) {
        const double straight_m = (cloud.points_m[reached.point] - cloud.points_m[seed]).norm();
        REQUIRE(reached.distance_m >= straight_m * (1.0 - 1e-12));
        REQUIRE(reached.distance_m <= straight_m * 1.0824);
        REQUIRE(reached.distance_m <= 0.015);
    }
    const auto is_before = [](const Reached& a, const Reached& b) {
        return std::pair(a.distance_m, a.point) < std::pair(b.distance_m, b.point);
    };
    CHECK(std::is_sorted(region.begin(), region.end(), is_before));
    CHECK(region.front().point == seed);
    CHECK(region.front().distance_m == 0.0);
}

TEST_CASE("the graph is symmetric, without loops, sorted, and joins only normals within 75 degrees") {
    Cloud cloud;
    test::Random random(3);
    for (int i = 0; i < 800; ++i) {
        cloud.normals.push_back(random.on_unit_sphere());
        cloud.points_m.push_back(0.05 * cloud.normals.back());
    }
    const std::size_t k = 10;
    const Tree tree(cloud.points_m);
    const Graph graph(cloud, tree, k);
    for (Index i = 0; i < cloud.points_m.size(); ++i) {
        const auto near = graph.neighbours(i);
        REQUIRE(std::is_sorted(near.begin(), near.end()));
        for (const Index j : near) {
            REQUIRE(j != i);
            REQUIRE(cloud.normals[i].dot(cloud.normals[j]) > COS_75_DEGREES);
            const auto back = graph.neighbours(j);
            REQUIRE(std::binary_search(back.begin(), back.end(), i));
        }
        for (const Index j :
             tree.nearest(cloud.points_m[i], k + 1)) {  // far denser than 75 degrees: all are joined
            REQUIRE((j == i || std::binary_search(near.begin(), near.end(), j)));
        }
    }
}

TEST_CASE(
    "a region of no radius is its seed, of a negative one nothing, and without normals there is no graph") {
    Cloud cloud;
    add_sheet(cloud, 5, 0.0, Eigen::Vector3d::UnitZ());
    const Tree tree(cloud.points_m);
    const Graph graph(cloud, tree);
    CHECK(graph.grow(7, 0.0, true).size() == 1);
    CHECK(graph.grow(7, -1.0, true).empty());
    CHECK(graph.grow(7, std::nan(""), true).empty());
    cloud.normals.clear();
    CHECK_THROWS_AS(Graph(cloud, tree), std::invalid_argument);
}

TEST_CASE("on the bunny's ear a 16 mm region stays on the face that was touched") {
    const auto file = palpate::test::installed_bunny();
    if (!file) return;
    Cloud cloud = read(*file);
    test::scale_to_15_cm(cloud);
    const Tree tree(cloud.points_m);
    orient(cloud, tree);
    const Graph graph(cloud, tree);
    const Index seed = tree.nearest(Eigen::Vector3d(-0.0468, 0.0580, -0.0388));
    const std::vector<Reached> region = graph.grow(seed, 0.016, true);
    CHECK(region.size() > 200);
    for (const Reached& reached : region) {
        REQUIRE(cloud.normals[seed].dot(cloud.normals[reached.point]) > COS_75_DEGREES);
        REQUIRE(reached.distance_m >=
                (cloud.points_m[reached.point] - cloud.points_m[seed]).norm() * (1.0 - 1e-12));
    }
    std::size_t n_facing_away = 0;  // a ball of that radius does reach the other wall
    for (const Index point : tree.within(cloud.points_m[seed], 0.016))
        n_facing_away += cloud.normals[seed].dot(cloud.normals[point]) < 0.0 ? 1U : 0U;
    CHECK(n_facing_away > 50);
}

}  // namespace palpate::cloud
