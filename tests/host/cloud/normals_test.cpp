#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>

#include "host/cloud/neighbours.hpp"
#include "tests/host/cloud/hull.hpp"
#include "tests/host/cloud/samples.hpp"
#include "tests/lacking.hpp"

namespace palpate::cloud {
namespace {

constexpr double COS_15_DEGREES = 0.96592582628906829;

Cloud sphere(std::size_t n) {
    Cloud cloud;
    test::Random random(20);
    const Eigen::Vector3d centre_m(0.3, -0.1, 0.2);
    for (std::size_t i = 0; i < n; ++i)
        cloud.points_m.emplace_back(centre_m + 0.05 * random.on_unit_sphere());
    return cloud;
}

/// Smallest cosine between a point's normal and the direction from the sphere's centre.
double worst_cosine(const Cloud& cloud) {
    const Eigen::Vector3d centre_m(0.3, -0.1, 0.2);
    double worst = 1.0;
    for (std::size_t i = 0; i < cloud.points_m.size(); ++i)
        worst = std::min(worst, cloud.normals[i].dot((cloud.points_m[i] - centre_m).normalized()));
    return worst;
}

}  // namespace

TEST_CASE("normals on a sphere of random points point outwards, from its faces") {
    Cloud cloud = sphere(1500);
    cloud.triangles = test::convex_hull(cloud.points_m);
    REQUIRE(cloud.triangles.size() == 2 * cloud.points_m.size() - 4);  // Euler, every point on the hull
    orient(cloud, Tree(cloud.points_m));
    CHECK(worst_cosine(cloud) > COS_15_DEGREES);
    for (std::array<Index, 3>& triangle : cloud.triangles) std::swap(triangle[0], triangle[1]);
    orient(cloud, Tree(cloud.points_m));
    CHECK(worst_cosine(cloud) < -0.9);  // the check above can fail: faces are believed
}

TEST_CASE("normals on a sphere of random points point outwards, without faces") {
    Cloud cloud = sphere(4000);
    orient(cloud, Tree(cloud.points_m));
    CHECK(worst_cosine(cloud) > COS_15_DEGREES);
}

TEST_CASE("a point in no face takes the normal of the nearest point in one") {
    Cloud cloud;
    cloud.points_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0},     {0, 0, 5},
                      {0, 1, 5}, {1, 0, 5}, {0.2, 0.2, 4}, {0.2, 0.2, 1}};
    cloud.triangles = {{0, 1, 2}, {3, 4, 5}};
    orient(cloud, Tree(cloud.points_m));
    CHECK(cloud.normals[0] == Eigen::Vector3d(0, 0, 1));
    CHECK(cloud.normals[3] == Eigen::Vector3d(0, 0, -1));
    CHECK(cloud.normals[6] == Eigen::Vector3d(0, 0, -1));
    CHECK(cloud.normals[7] == Eigen::Vector3d(0, 0, 1));
}

TEST_CASE("a large face counts more than a small one") {
    Cloud cloud;  // two faces share point 0: area 50 facing z, area 0.5 facing x
    cloud.points_m = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 1, 0}, {0, 0, 1}};
    cloud.triangles = {{0, 1, 2}, {0, 3, 4}};
    orient(cloud, Tree(cloud.points_m));
    CHECK(cloud.normals[0].isApprox(Eigen::Vector3d(0.01, 0.0, 1.0).normalized(), 1e-12));
}

// At two spacings only the mirror rule gets round the rim; a wall as thin as the spacing needs faces.
TEST_CASE("both walls of a thin closed box are oriented outwards without faces") {
    const int thickness = GENERATE(as<int>{}, 2, 3, 4);
    Cloud cloud;  // 40 mm square, spacing 1 mm
    for (int i = 0; i <= 40; ++i) {
        for (int j = 0; j <= 40; ++j) {
            const bool on_rim = i == 0 || i == 40 || j == 0 || j == 40;
            for (int k = 0; k <= thickness; ++k) {
                if (on_rim || k == 0 || k == thickness)
                    cloud.points_m.emplace_back(1e-3 * i, 1e-3 * j, 1e-3 * k);
            }
        }
    }
    orient(cloud, Tree(cloud.points_m));
    std::size_t n_inward = 0;
    for (std::size_t i = 0; i < cloud.points_m.size(); ++i) {
        const Eigen::Vector3d from_middle_m =
            cloud.points_m[i] - 1e-3 * Eigen::Vector3d(20, 20, 0.5 * thickness);
        n_inward += cloud.normals[i].dot(from_middle_m) > 0.0 ? 0U : 1U;
    }
    CAPTURE(thickness);
    CHECK(n_inward == 0);
}

TEST_CASE("on the bunny the orientation without faces agrees with the faces") {
    const auto file = palpate::test::installed_bunny();
    if (!file) return;
    Cloud cloud = read(*file);
    const Tree tree(cloud.points_m);
    orient(cloud, tree);
    Cloud bare;
    bare.points_m = cloud.points_m;
    orient(bare, tree);
    std::size_t n_agree = 0;
    for (std::size_t i = 0; i < cloud.points_m.size(); ++i)
        n_agree += cloud.normals[i].dot(bare.normals[i]) > 0.0 ? 1U : 0U;
    const double share = static_cast<double>(n_agree) / static_cast<double>(cloud.points_m.size());
    std::cout << "bunny: " << 100.0 * share << " % of the points oriented without faces as with them\n";
    CHECK(share > 0.99);
}

TEST_CASE("normals have length one, also where points coincide or lie on a line") {
    Cloud cloud;
    for (int i = 0; i < 20; ++i) cloud.points_m.emplace_back(i / 2, 0.0, 0.0);
    orient(cloud, Tree(cloud.points_m));
    for (const Eigen::Vector3d& normal : cloud.normals) CHECK(normal.norm() == Approx(1.0).margin(1e-12));
}

}  // namespace palpate::cloud
