// Of a double wall one side stays: the one that is touched first, whole, and nothing of the other.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>

#include "host/cloud/outer_side.hpp"
#include "tests/host/cloud/samples.hpp"

namespace palpate::cloud {
namespace {

using Eigen::Vector3d;

constexpr double SPACING_M = 1e-3, THIN_M = 0.6e-3, PI = 3.14159265358979323846;

/// Points whose side is known: 1 outside, -1 inside, 0 between the two on a rim.
struct Walls {
    Cloud cloud;
    std::vector<int> side;
    void add(const Vector3d& at_m, const Vector3d& normal, int of_side) {
        cloud.points_m.push_back(at_m);
        cloud.normals.push_back(normal.normalized());
        side.push_back(of_side);
    }
    [[nodiscard]] std::size_t n(int of_side) const {
        return static_cast<std::size_t>(std::count(side.begin(), side.end(), of_side));
    }
};

std::vector<Index> kept_of(const Cloud& cloud, const Vector3d& from_m) {
    const Tree tree(cloud.points_m);
    return outer_side(cloud, tree, from_m);
}

std::size_t n_of(int side, const std::vector<Index>& points, const Walls& walls) {
    std::size_t n = 0;
    for (const Index point : points) n += walls.side[point] == side ? 1U : 0U;
    return n;
}

/// Points 1 mm apart on a circle about z, turned by a random phase; the normal leans up by `lean`.
void add_ring(Walls& walls, test::Random& random, double radius_m, double z_m, double out, double lean,
              int side) {
    const int n = static_cast<int>(2.0 * PI * radius_m / SPACING_M);
    const double phase = random.uniform();
    for (int i = 0; i < n; ++i) {
        const double angle = 2.0 * PI * (i + phase) / n, c = std::cos(angle), s = std::sin(angle);
        walls.add({radius_m * c, radius_m * s, z_m}, {out * c, out * s, lean}, side);
    }
}

/// 40 mm wide, 30 mm high, its wall and bottom `wall_m` thick, open at the top; the rim's normals turn from
/// one wall to the other by way of a ring that faces up, so that the graph goes over it.
Walls cup(double wall_m) {
    constexpr double RADIUS_M = 0.020;
    Walls walls;
    test::Random random(7);
    add_ring(walls, random, RADIUS_M, 0.0, 1.0, -1.0, 1);
    for (int i = 1; i < 30; ++i) add_ring(walls, random, RADIUS_M, 1e-3 * i, 1.0, 0.0, 1);
    add_ring(walls, random, RADIUS_M, 0.030, 1.0, 1.0, 1);
    add_ring(walls, random, RADIUS_M - 0.5 * wall_m, 0.0303, 0.0, 1.0, 0);
    add_ring(walls, random, RADIUS_M - wall_m, 0.030, -1.0, 1.0, -1);
    for (double z_m = wall_m + 1e-3; z_m < 0.0295; z_m += 1e-3)
        add_ring(walls, random, RADIUS_M - wall_m, z_m, -1.0, 0.0, -1);
    add_ring(walls, random, RADIUS_M - wall_m, wall_m, -1.0, 1.0, -1);
    for (int i = -20; i <= 20; ++i) {
        for (int j = -20; j <= 20; ++j) {
            const Vector3d at_m(1e-3 * i, 1e-3 * j, 0.0);
            if (at_m.norm() < RADIUS_M - 0.5e-3) walls.add(at_m, -Vector3d::UnitZ(), 1);
            if (at_m.norm() < RADIUS_M - wall_m - 0.5e-3)
                walls.add(at_m + Vector3d(0, 0, wall_m), Vector3d::UnitZ(), -1);
        }
    }
    return walls;
}

/// 30 x 30 mm, `height_m` high, the two faces joined by edges of points 1 mm apart at most.
Walls slab(double height_m) {
    Walls walls;
    const int n = 30, n_up = std::max(2, static_cast<int>(std::lround(height_m / SPACING_M)));
    for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= n; ++j) {
            const Vector3d at_m(1e-3 * i, 1e-3 * j, 0.0);
            const Vector3d out((i == n) - (i == 0), (j == n) - (j == 0), 0.0);
            walls.add(at_m + Vector3d(0, 0, height_m), out + Vector3d::UnitZ(), 1);
            walls.add(at_m, out - Vector3d::UnitZ(), -1);
            if (out.isZero()) continue;
            for (int k = 1; k < n_up; ++k) walls.add(at_m + Vector3d(0, 0, height_m * k / n_up), out, 0);
        }
    }
    return walls;
}

}  // namespace

TEST_CASE("of a thin cup the wall that was touched stays whole, with its rim, and nothing of the other") {
    const Walls walls = cup(GENERATE(as<double>{}, THIN_M, 0.1e-3, 2e-3));
    const double angle = GENERATE(as<double>{}, 0.0, 2.0);
    const double height_m = GENERATE(as<double>{}, 0.0295, 0.015, 0.002);
    CAPTURE(angle, height_m, walls.n(1), walls.n(-1));
    const Vector3d around(std::cos(angle), std::sin(angle), 0.0), up(0.0, 0.0, height_m);
    SECTION("from outside") {
        const auto kept = kept_of(walls.cloud, 0.0202 * around + up);
        CHECK(n_of(1, kept, walls) == walls.n(1));
        CHECK(n_of(0, kept, walls) == walls.n(0));
        CHECK(n_of(-1, kept, walls) == 0);
        CHECK(std::is_sorted(kept.begin(), kept.end()));
    }
    SECTION("from inside") {
        const auto kept = kept_of(walls.cloud, 0.0175 * around + up);
        CHECK(n_of(-1, kept, walls) == walls.n(-1));
        CHECK(n_of(0, kept, walls) == walls.n(0));
        CHECK(n_of(1, kept, walls) == 0);
    }
}

TEST_CASE("the touched side of a thin wall is told from a place on it, wherever between the points") {
    const Walls walls = slab(THIN_M);
    const double x_m = GENERATE(as<double>{}, 0.015, 0.0155, 0.0152),
                 y_m = GENERATE(as<double>{}, 0.015, 0.0155);
    CHECK(n_of(-1, kept_of(walls.cloud, {x_m, y_m, THIN_M}), walls) == 0);
    CHECK(n_of(1, kept_of(walls.cloud, {x_m, y_m, 0.0}), walls) == 0);
}

TEST_CASE("a thin slab loses its back, a thick one nothing") {
    const Walls thin = slab(THIN_M), thick = slab(0.010);
    const auto kept = kept_of(thin.cloud, {0.015, 0.015, 0.001});
    CHECK(n_of(1, kept, thin) == thin.n(1));
    CHECK(n_of(0, kept, thin) == thin.n(0));
    CHECK(n_of(-1, kept, thin) == 0);
    CHECK(kept_of(thick.cloud, {0.015, 0.015, 0.011}).size() == thick.cloud.points_m.size());
}

TEST_CASE(
    "what lies across air, or apart from all, stays; the back of what stays goes though nothing joins it") {
    Walls walls;
    for (int i = 0; i < 900; ++i) {
        const Vector3d at_m(1e-3 * (i % 30), 1e-3 * (i / 30), 0.0);
        walls.add(at_m, Vector3d::UnitZ(), 1);
        walls.add(at_m - Vector3d(0, 0, THIN_M), -Vector3d::UnitZ(), -1);
        walls.add(at_m + Vector3d(0, 0, 2e-3), -Vector3d::UnitZ(), 0);  // faces the first
        walls.add(at_m + Vector3d(1.0, 0, 0), Vector3d::UnitZ(), 2);
    }
    const auto kept = kept_of(walls.cloud, {0.015, 0.015, 0.0});
    CHECK(n_of(1, kept, walls) == 900);
    CHECK(n_of(-1, kept, walls) == 0);
    CHECK(n_of(0, kept, walls) == 900);
    CHECK(n_of(2, kept, walls) == 900);
}

TEST_CASE("a part of a cloud has what is known of its points, and the triangles that are whole in it") {
    Cloud cloud;
    cloud.points_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    cloud.normals = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, -1}};
    cloud.young_pa = {1, 2, 3, 4};
    cloud.triangles = {{0, 1, 2}, {3, 2, 1}};
    cloud.n_duplicates = 5;
    const Cloud part = subset(cloud, std::vector<Index>{1, 2, 3});
    CHECK(part.points_m == std::vector<Vector3d>(cloud.points_m.begin() + 1, cloud.points_m.end()));
    CHECK(part.normals == std::vector<Vector3d>(cloud.normals.begin() + 1, cloud.normals.end()));
    CHECK(part.young_pa == std::vector<double>{2, 3, 4});
    CHECK(part.triangles == std::vector<std::array<Index, 3>>{{2, 1, 0}});
    CHECK(part.n_duplicates == 5);
}

TEST_CASE("touched on its very rim a thin cup still keeps one wall, whole") {
    const Walls walls = cup(THIN_M);
    const auto kept = kept_of(walls.cloud, {0.0, 0.0197, 0.031});
    CHECK(kept.size() == walls.n(0) + std::max(n_of(1, kept, walls), n_of(-1, kept, walls)));
    CHECK((n_of(1, kept, walls) == walls.n(1) || n_of(-1, kept, walls) == walls.n(-1)));
}

namespace {

/// Points with another behind them that faces the other way, 1.5 mm off at most: walls are 0.57 mm thick.
std::size_t n_double(const Cloud& cloud) {
    const Tree tree(cloud.points_m);
    std::size_t n = 0;
    for (std::size_t i = 0; i < cloud.points_m.size(); ++i) {
        const std::vector<Index> near = tree.within(cloud.points_m[i], 1.5e-3);
        n += static_cast<std::size_t>(std::any_of(near.begin(), near.end(), [&](Index other) {
            return cloud.normals[i].dot(cloud.normals[other]) < -0.5 &&
                   (cloud.points_m[other] - cloud.points_m[i]).dot(cloud.normals[i]) < 0.0;
        }));
    }
    return n;
}

}  // namespace

TEST_CASE("of the scanned cup one wall stays, from outside and from inside, and no point of it is double") {
    const auto file = test::shared_file("cup/plastic_cup.obj");  // 76 mm wide, 111 mm high, about z
    if (!file) return;
    Cloud cloud = read(*file);
    const Tree tree(cloud.points_m);
    orient(cloud, tree);
    const std::size_t n = cloud.points_m.size();
    CHECK(n_double(cloud) > n * 9 / 10);
    for (const double x_m : {0.040, 0.025}) {
        const std::vector<Index> kept = outer_side(cloud, tree, {x_m, 0.0, 0.0});
        const Cloud part = subset(cloud, kept);
        CHECK(n_double(part) == 0);
        CHECK(kept.size() > n * 45 / 100);
        CHECK(kept.size() < n * 55 / 100);
        std::size_t n_facing = 0;  // the side that was touched; the rest is bottom and rim
        for (std::size_t i = 0; i < kept.size(); ++i) {
            const Vector3d& p = part.points_m[i];
            const double out = part.normals[i].head<2>().dot(p.head<2>().normalized());
            n_facing += (x_m > 0.03 ? out : -out) > 0.5 ? 1U : 0U;
            CHECK_FALSE((x_m > 0.03 ? out : -out) < -0.9);
        }
        CHECK(n_facing > kept.size() / 2);
        std::cout << "cup from x = " << x_m << " m: " << kept.size() << " of " << n << " points stay\n";
    }
}

}  // namespace palpate::cloud
