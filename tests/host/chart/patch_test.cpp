#include "host/chart/patch.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "host/cloud/neighbours.hpp"

using namespace palpate;
using Eigen::Vector3d;

namespace {

/// Points, graph and smooth skin, with one modulus.
struct Skin {
    cloud::Cloud cloud;
    std::unique_ptr<cloud::Tree> tree;
    std::unique_ptr<cloud::Graph> graph;
    std::unique_ptr<contact::Surface> surface;

    [[nodiscard]] contact::Foot foot(const Vector3d& at) const {
        const auto found = surface->foot(at, tree->nearest(at));
        REQUIRE(found);
        return *found;
    }
};

Skin skin_of(std::vector<Vector3d> points_m) {
    Skin s;
    s.cloud.points_m = std::move(points_m);
    s.cloud.young_pa.assign(s.cloud.points_m.size(), 1e6);
    s.tree = std::make_unique<cloud::Tree>(s.cloud.points_m);
    cloud::orient(s.cloud, *s.tree);
    s.graph = std::make_unique<cloud::Graph>(s.cloud, *s.tree);
    s.surface = std::make_unique<contact::Surface>(s.cloud, *s.graph, 4e-3);
    return s;
}

using Height = std::function<double(double, double)>;

/// z = height(x, y), points 1 mm apart, turned about the middle.
Skin skin(double half_x_m, double half_y_m, const Height& height,
          const Eigen::Quaterniond& turn = Eigen::Quaterniond::Identity()) {
    std::vector<Vector3d> points_m;
    const int nx = static_cast<int>(std::lround(1e3 * half_x_m)),
              ny = static_cast<int>(std::lround(1e3 * half_y_m));
    for (int i = -nx; i <= nx; ++i) {
        for (int j = -ny; j <= ny; ++j) {
            points_m.push_back(turn * Vector3d(1e-3 * i, 1e-3 * j, height(1e-3 * i, 1e-3 * j)));
        }
    }
    return skin_of(std::move(points_m));
}

double flat(double, double) {
    return 0.0;
}

chart::Material thin() {
    return {.thickness_m = 1.5e-3, .poisson = 0.3, .shell = false};
}

chart::Material thin_shell() {
    chart::Material m = thin();
    m.shell = true;
    return m;
}

double rigidity(const chart::Material& m, double young_pa) {
    return young_pa * std::pow(m.thickness_m, 3) / (12.0 * (1.0 - m.poisson * m.poisson));
}

}  // namespace

TEST_CASE("a flat patch is a clamped square plate, centred wherever the contact is") {
    const Skin s = skin(0.02, 0.02, flat);
    const chart::Material m = thin();
    const double exact = rigidity(m, 1e6) / (0.005612024 * m.patch_size_m * m.patch_size_m);
    for (const Vector3d& at :
         {Vector3d(0, 0, 0), Vector3d(3.3e-4, -4.1e-4, 0), Vector3d(2e-3, 1.5e-3, 1e-3)}) {
        const chart::Stiffness k = chart::point_stiffness(*s.surface, s.foot(at), m);
        CHECK(k.n_per_m == Approx(exact).epsilon(1e-6));
        CHECK(k.covered == 1.0);
    }
}

TEST_CASE("the paper's projection shows the plate other skin: 2:1 at the contact") {
    const Skin s = skin(0.025, 0.025, flat);
    chart::Material m = thin();
    m.projection = chart::Projection::gall_peters;
    const chart::Patch patch = chart::cut_patch(*s.surface, s.foot({0, 0, 0}), m, 33);
    int seen = 0;
    for (const chart::PlatePoint& p : patch.points) {
        const Vector3d local = patch.frame.local_m(s.cloud.points_m[p.point]);
        CHECK(p.at_m.x() == Approx(local.x() / std::sqrt(2.0)).margin(1e-12));
        CHECK(p.at_m.y() == Approx(local.y() * std::sqrt(2.0)).margin(1e-12));
        ++seen;
    }
    CHECK(seen > 100);
}

TEST_CASE("Gaussian curvature is found on spheres, bowls, cylinders and saddles") {
    const double r = 0.03;
    const auto check = [&](const Skin& s, double expected) {
        const chart::Patch patch = chart::cut_patch(*s.surface, s.foot({0, 0, 0}), thin_shell(), 17);
        CHECK(patch.gauss_per_m2 == Approx(expected).margin(0.03 / (r * r)));
        CHECK(patch.saddle == (expected < 0.0));
    };
    check(skin(0.018, 0.018, [=](double x, double y) { return std::sqrt(r * r - x * x - y * y) - r; }),
          1.0 / (r * r));
    check(skin(0.018, 0.018, [=](double x, double y) { return r - std::sqrt(r * r - x * x - y * y); }),
          1.0 / (r * r));
    check(skin(0.018, 0.018, [=](double x, double) { return std::sqrt(r * r - x * x) - r; }), 0.0);
    check(skin(0.018, 0.018, [=](double x, double y) { return 0.5 * (x * x - y * y) / r; }), -1.0 / (r * r));
}

TEST_CASE("saddles are told from rounding: none on a turned sheet or a cylinder, all on a saddle") {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(M_PI / 6.0, Vector3d(1.0, 0.4, -0.2).normalized()));
    const auto share = [&](const Height& height) {
        const Skin s = skin(0.014, 0.014, height, turn);
        int n = 0, n_saddles = 0;
        for (int i = -4; i <= 4; i += 2) {
            for (int j = -4; j <= 4; ++j) {
                const double x = 1e-3 * i, y = 1e-3 * j;
                const contact::Foot foot = s.foot(turn * Vector3d(x, y, height(x, y)));
                n_saddles += chart::cut_patch(*s.surface, foot, thin_shell(), 9).saddle ? 1 : 0;
                ++n;
            }
        }
        return static_cast<double>(n_saddles) / n;
    };
    CHECK(share(flat) == 0.0);
    for (const double r : {0.02, -0.02, 0.04, -0.04, 0.1, -0.1}) {
        CAPTURE(r);
        CHECK(share([=](double x, double) { return std::copysign(std::sqrt(r * r - x * x), r) - r; }) == 0.0);
    }
    CHECK(share([](double x, double y) { return 0.5 * (x * x - y * y) / 0.03; }) == 1.0);
    CHECK(share([](double x, double y) { return 0.5 * (x * x - y * y) / 0.3; }) == 1.0);
}

TEST_CASE("a saddle has what lies under the skin as its foundation, and no more") {
    const Skin s = skin(0.018, 0.018, [](double x, double y) { return 0.5 * (x * x - y * y) / 0.03; });
    chart::Material m = thin_shell();
    m.foundation_n_per_m3 = 2e7;
    const chart::Patch patch = chart::cut_patch(*s.surface, s.foot({0, 0, 0}), m, 17);
    CHECK(patch.covered == 1.0);
    CHECK(patch.problem.foundation_n_per_m3.minCoeff() == 2e7);
    CHECK(patch.problem.foundation_n_per_m3.maxCoeff() == 2e7);
}

TEST_CASE("nodes without skin are a free edge: a millionth of the rigidity and no foundation") {
    const Skin s = skin(0.02, 0.004, [](double x, double y) {
        return std::sqrt(9e-4 - x * x - y * y) - 0.03;  // a strip of a sphere: shell and Winkler
    });
    chart::Material m = thin_shell();
    m.foundation_n_per_m3 = 2e7;
    const chart::Patch patch = chart::cut_patch(*s.surface, s.foot({0, 0, 0}), m, 17);
    const Eigen::ArrayXXd &k_f = patch.problem.foundation_n_per_m3, &d = patch.problem.rigidity_n_m;
    int n_free = 0;
    for (Eigen::Index i = 0; i < 17; ++i) {
        for (Eigen::Index j = 0; j < 17; ++j) {
            const bool has_skin = d(i, j) > 0.5 * d.maxCoeff();
            CHECK(d(i, j) == Approx((has_skin ? 1.0 : 1e-6) * d.maxCoeff()));
            if (has_skin) CHECK(k_f(i, j) > 2e7);
            if (!has_skin) CHECK(k_f(i, j) == 0.0);
            n_free += has_skin ? 0 : 1;
        }
    }
    CHECK(n_free == 17 * 17 - std::lround(patch.covered * 17 * 17));
    CHECK(n_free >= 17 * 4);
}

TEST_CASE("a spherical skin carries itself as Reissner says") {
    // Sphere R 30 mm, h 1 mm, E 1 MPa, nu 0.2: c = R/(8 sqrt(D E h)) = 0.0127279 m/N, patch of 13.5 l.
    const double r = 0.03;
    Skin s = skin(0.021, 0.021, [=](double x, double y) { return std::sqrt(r * r - x * x - y * y) - r; });
    const chart::Material m{.thickness_m = 1e-3, .poisson = 0.2, .shell = true, .patch_size_m = 0.04};
    const double c = 1.0 / chart::point_stiffness(*s.surface, s.foot({0, 0, 0}), m).n_per_m;
    CHECK(c == Approx(0.0127279).epsilon(0.02));  // the curvature comes from points: 1 % of kappa is 1 % of c
}

TEST_CASE("a rim is a free edge: a strip is softer than the full patch, and half a patch is refused") {
    const chart::Material m = thin();
    const Skin full = skin(0.02, 0.02, flat), strip = skin(0.02, 0.005, flat),
               thread = skin(0.02, 0.001, flat);
    const double k_full = chart::point_stiffness(*full.surface, full.foot({0, 0, 0}), m).n_per_m;
    const chart::Stiffness k_strip = chart::point_stiffness(*strip.surface, strip.foot({0, 0, 0}), m);
    CHECK(k_strip.n_per_m < 0.8 * k_full);
    CHECK(k_strip.covered > 0.5);
    CHECK(k_strip.covered < 0.9);
    CHECK_THROWS_AS(chart::point_stiffness(*thread.surface, thread.foot({0, 0, 0}), m), chart::NoPatch);
}

TEST_CASE("the other wall of a thin object is no part of a patch") {
    Skin s = skin(0.015, 0.015, flat);
    const std::size_t one_wall = s.cloud.points_m.size();
    for (std::size_t i = 0; i < one_wall; ++i)
        s.cloud.points_m.push_back(s.cloud.points_m[i] - Vector3d(0, 0, 3e-3));
    s.cloud.normals.resize(one_wall);
    for (std::size_t i = 0; i < one_wall; ++i) s.cloud.normals.push_back(-s.cloud.normals[i]);
    s.cloud.young_pa.resize(2 * one_wall, 1e9);  // would be felt at once
    s.tree = std::make_unique<cloud::Tree>(s.cloud.points_m);
    s.graph = std::make_unique<cloud::Graph>(s.cloud, *s.tree);
    s.surface = std::make_unique<contact::Surface>(s.cloud, *s.graph, 4e-3);
    const chart::Patch patch = chart::cut_patch(*s.surface, s.foot({0, 0, 1e-3}), thin(), 33);
    for (const chart::PlatePoint& p : patch.points) CHECK(p.point < one_wall);
}

TEST_CASE("a patch ends where a rim has turned by 75 degrees from the contact") {
    // A fold: two walls 4 mm apart and the half cylinder that joins them at x = 0.
    constexpr double R = 2e-3;
    std::vector<Vector3d> points_m;
    for (int j = -12; j <= 12; ++j) {
        for (int i = 0; i <= 12; ++i) {
            for (const double z : {R, -R}) points_m.emplace_back(1e-3 * i, 1e-3 * j, z);
        }
        for (int k = 1; k < 6; ++k) {
            points_m.emplace_back(-R * std::sin(k * M_PI / 6.0), 1e-3 * j, R * std::cos(k * M_PI / 6.0));
        }
    }
    const Skin s = skin_of(std::move(points_m));
    const contact::Foot foot = s.foot({4e-3, 0, R});
    REQUIRE(foot.normal.z() > 0.99);
    const chart::Patch patch = chart::cut_patch(*s.surface, foot, thin(), 17);
    int n_turned = 0;
    for (const chart::PlatePoint& p : patch.points) {
        const double cosine = s.cloud.normals[p.point].dot(s.cloud.normals[foot.nearest]);
        CHECK(cosine > std::cos(75.0 * M_PI / 180.0));
        n_turned += cosine < 0.9 ? 1 : 0;
    }
    CHECK(n_turned > 10);  // the rim itself is there
}

TEST_CASE("a patch smaller than the scan's spacing is no patch, in words") {
    const Skin s = skin(0.01, 0.01, flat);
    chart::Material m = thin();
    m.patch_size_m = 1e-3;
    CHECK_THROWS_AS(chart::point_stiffness(*s.surface, s.foot({0, 0, 0}), m), chart::NoPatch);
    CHECK_THROWS_WITH(chart::point_stiffness(*s.surface, s.foot({3e-4, 0, 0}), m),
                      Catch::Matchers::Contains("1.0 mm"));
}

TEST_CASE("a plate that no guard can vouch for is no patch, with the guard's reason") {
    Skin s = skin(0.014, 0.014, flat);
    for (std::size_t i = 0; i < s.cloud.points_m.size(); ++i) {
        if (s.cloud.points_m[i].norm() < 3e-3) s.cloud.young_pa[i] *= 1e5;
    }
    chart::Material m = thin();
    m.foundation_n_per_m3 = 2e7;
    std::string why;
    for (int i = 0; i < 10 && why.empty(); ++i) {
        const contact::Foot foot = s.foot({5e-4 * i, 0, 0});
        try {
            static_cast<void>(chart::point_stiffness(*s.surface, foot, m, 17));
        } catch (const chart::NoPatch& no) {
            why = no.what();
        }
    }
    CHECK_THAT(why, Catch::Matchers::Contains("compliance is not positive") ||
                        Catch::Matchers::Contains("badly conditioned"));
}

TEST_CASE("the dip is deepest at the contact, where it is force times compliance, and dies out at the edge") {
    const Skin s = skin(0.02, 0.02, flat);
    const chart::Material m = thin();
    const contact::Foot foot = s.foot({0, 0, 0});
    const double k = chart::point_stiffness(*s.surface, foot, m).n_per_m;
    double deepest = 0.0, at_edge = 0.0;
    for (const chart::Displaced& d : chart::dip(*s.surface, foot, m, 2.0)) {
        CHECK(d.by_m.dot(foot.normal) <= 0.0);
        const double away = s.cloud.points_m[d.point].norm();
        if (away < 1e-9) deepest = d.by_m.norm();
        if (away > 7.5e-3) at_edge = std::max(at_edge, d.by_m.norm());
    }
    CHECK(deepest == Approx(2.0 / k).epsilon(0.02));  // drawn from one grid, not extrapolated
    CHECK(at_edge < 0.1 * deepest);
}
