#include "host/contact/proxy.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>

#include "tests/host/contact/clouds.hpp"

using palpate::contact::Contact;
using palpate::contact::Proxy;
using namespace palpate::testing;

namespace {

constexpr double radius_m = 0.003;
constexpr double spacing_m = 0.001;  // a third of the radius

struct Slid {
    double worst_normal_deg = 0.0;
    double lowest_m = 1.0;  ///< of the proxy over the true surface
    double highest_m = -1.0;
    double worst_aside_m = 0.0;  ///< of the proxy from the true normal through the tool
    double worst_jump = 0.0;     ///< proxy's way over the tool's
    int n_untouched = 0;
};

/// What is true at a tool position: normal and height of the tool over the surface.
struct Truth {
    Eigen::Vector3d normal;
    double height_m;
};

/// Approaches `from` from outside along its normal, then slides to the end of the path.
Slid slide(Proxy& proxy, const std::function<Eigen::Vector3d(double)>& path,
           const std::function<Truth(const Eigen::Vector3d&)>& truth, int n_steps = 300) {
    const Truth first = truth(path(0.0));
    for (int i = 0; i <= 50; ++i) {
        const auto c = proxy.follow(path(0.0) + (0.02 * (50 - i) / 50.0) * first.normal);
        REQUIRE((c.has_value() || i < 45));
    }
    Slid result;
    Eigen::Vector3d before = Eigen::Vector3d::Zero();
    for (int i = 0; i <= n_steps; ++i) {
        const Eigen::Vector3d tool = path(static_cast<double>(i) / n_steps);
        const auto c = proxy.follow(tool);
        REQUIRE(c);
        const Truth t = truth(tool);
        const Truth above = truth(c->proxy_m);
        result.n_untouched += c->touching ? 0 : 1;
        result.worst_normal_deg = std::max(result.worst_normal_deg, angle_deg(c->normal, above.normal));
        result.lowest_m = std::min(result.lowest_m, above.height_m);
        result.highest_m = std::max(result.highest_m, above.height_m);
        const Eigen::Vector3d way = c->proxy_m - tool;
        result.worst_aside_m = std::max(result.worst_aside_m, (way - way.dot(t.normal) * t.normal).norm());
        if (i > 0) {
            const double tool_way = (tool - path(static_cast<double>(i - 1) / n_steps)).norm();
            result.worst_jump = std::max(result.worst_jump, (c->proxy_m - before).norm() / tool_way);
        }
        before = c->proxy_m;
    }
    return result;
}

Truth over_plane(const Eigen::Vector3d& at) {
    return {Eigen::Vector3d::UnitZ(), at.z()};
}

}  // namespace

TEST_CASE("away from everything nothing is reported, near it the proxy is the tool") {
    const Scan scan(sheet({}, 0.01, spacing_m));
    Proxy proxy(scan.cloud, scan.tree, scan.graph, radius_m);
    REQUIRE_FALSE(proxy.follow({0.0, 0.0, 0.05}));
    REQUIRE_FALSE(proxy.follow({0.0, 0.0, 0.0065}));
    const Eigen::Vector3d tool(0.001, 0.002, 0.0045);
    const auto c = proxy.follow(tool);
    REQUIRE(c);
    REQUIRE_FALSE(c->touching);
    REQUIRE((c->proxy_m - tool).norm() < 1e-12);
    REQUIRE(c->nearest == scan.tree.nearest(tool));
    REQUIRE(c->normal == Eigen::Vector3d::UnitZ());
}

TEST_CASE("sliding 30 mm over a plane at any depth the proxy stays on it, above the tool") {
    const double depth = GENERATE(as<double>{}, 0.001, 0.003, 0.006);
    const Scan scan(sheet({}, 0.025, spacing_m));
    Proxy proxy(scan.cloud, scan.tree, scan.graph, radius_m);
    const Slid s = slide(
        proxy, [&](double t) { return Eigen::Vector3d(-0.015 + 0.03 * t, 0.004 * t, radius_m - depth); },
        over_plane);
    WARN("plane, depth " << depth * 1e3 << " mm: normal off by " << s.worst_normal_deg << " degrees, height "
                         << s.lowest_m * 1e3 << " to " << s.highest_m * 1e3 << " mm, aside "
                         << s.worst_aside_m * 1e3 << " mm, jump " << s.worst_jump);
    REQUIRE(s.n_untouched == 0);
    REQUIRE(s.worst_normal_deg < 10.0);
    REQUIRE(s.lowest_m > 0.85 * radius_m);
    REQUIRE(s.highest_m < 1.02 * radius_m);
    REQUIRE(s.worst_aside_m < 0.18 * (depth + radius_m));  // tan 10 degrees
}

TEST_CASE("sliding over a ball and inside a bowl the proxy stays on the surface") {
    const bool inward = GENERATE(false, true);
    const double big = 0.03;
    const Scan scan(ball(big, spacing_m, inward));
    Proxy proxy(scan.cloud, scan.tree, scan.graph, radius_m);
    const double sign = inward ? -1.0 : 1.0;
    const double depth = 0.003;
    const auto path = [&](double t) {
        const double angle = t * 1.1;  // 33 mm of surface
        const Eigen::Vector3d way(std::sin(angle), 0.3 * t, std::cos(angle));
        return Eigen::Vector3d((big + sign * (radius_m - depth)) * way.normalized());
    };
    const Slid s = slide(proxy, path, [&](const Eigen::Vector3d& at) {
        return Truth{sign * at.normalized(), sign * (at.norm() - big)};
    });
    WARN((inward ? "bowl" : "ball") << ": normal off by " << s.worst_normal_deg << " degrees, height "
                                    << s.lowest_m * 1e3 << " to " << s.highest_m * 1e3 << " mm, aside "
                                    << s.worst_aside_m * 1e3 << " mm, jump " << s.worst_jump);
    REQUIRE(s.n_untouched == 0);
    REQUIRE(s.worst_normal_deg < 10.0);
    REQUIRE(s.lowest_m > 0.85 * radius_m);
    REQUIRE(s.highest_m < 1.02 * radius_m);
}

TEST_CASE("in a bowl so narrow that a full step goes too far the proxy still settles above the tool") {
    // Proxy 3 mm from the centre, tool 9 mm: one full step turns it by three times what is missing.
    const Scan scan(ball(0.006, 0.0007, true));
    Proxy proxy(scan.cloud, scan.tree, scan.graph, radius_m);
    static_cast<void>(proxy.follow(Eigen::Vector3d::Zero()));
    const Eigen::Vector3d way = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
    const auto c = proxy.follow(0.009 * way);
    REQUIRE(c);
    REQUIRE(c->touching);
    REQUIRE(angle_deg(c->normal, -way) < 3.0);
    REQUIRE(angle_deg(c->proxy_m.normalized(), way) < 5.0);
    const auto again = proxy.follow(0.009 * way);
    REQUIRE((again->proxy_m - c->proxy_m).norm() < 1e-5);
}

TEST_CASE("on a thin sheet with two sides the proxy stays on the side that it touched, until it is free") {
    const double thickness = GENERATE(as<double>{}, 0.0, 0.001, 0.003);
    palpate::cloud::Cloud walls;
    add_sheet(walls, {}, 0.0, 0.025, spacing_m, false, 1);
    const std::size_t n_upper = walls.points_m.size();
    add_sheet(walls, {}, -thickness, 0.025, spacing_m, true, 2);
    const Scan scan(std::move(walls));
    Proxy proxy(scan.cloud, scan.tree, scan.graph, radius_m);
    // 3 mm deep, then 6: the tool's centre is past the lower wall.
    for (const double depth : {0.003, 0.006}) {
        proxy.reset();
        const Slid s = slide(
            proxy, [&](double t) { return Eigen::Vector3d(-0.015 + 0.03 * t, 0.0, radius_m - depth); },
            over_plane);
        CAPTURE(thickness, depth);
        REQUIRE(s.n_untouched == 0);
        REQUIRE(s.worst_normal_deg < 10.0);
        REQUIRE(s.lowest_m > 0.85 * radius_m);
        REQUIRE(s.highest_m < 1.02 * radius_m);
        const auto c = proxy.follow({0.015, 0.0, radius_m - depth});
        REQUIRE(c->nearest < n_upper);
    }
    // Lifted off and led round the edge it touches the other side.
    for (const Eigen::Vector3d& tool :
         {Eigen::Vector3d(0.015, 0.0, 0.02), Eigen::Vector3d(0.04, 0.0, 0.02),
          Eigen::Vector3d(0.04, 0.0, -0.02), Eigen::Vector3d(0.0, 0.0, -0.02)}) {
        REQUIRE_FALSE(proxy.follow(tool));
    }
    const auto c = proxy.follow({0.0, 0.0, -thickness - 0.001});
    REQUIRE(c);
    REQUIRE(c->touching);
    REQUIRE(c->nearest >= n_upper);
    REQUIRE(c->normal.z() < -0.98);
    REQUIRE(c->proxy_m.z() < -thickness - 0.85 * radius_m);
}

TEST_CASE("a jump through a thin sheet in one call is caught by it") {
    palpate::cloud::Cloud walls;
    add_sheet(walls, {}, 0.0, 0.02, spacing_m, false, 1);
    add_sheet(walls, {}, -0.001, 0.02, spacing_m, true, 2);
    const Scan scan(std::move(walls));
    Proxy proxy(scan.cloud, scan.tree, scan.graph, radius_m);
    REQUIRE_FALSE(proxy.follow({0.0, 0.0, 0.03}));
    const auto c = proxy.follow({0.002, 0.001, -0.03});
    REQUIRE(c);
    REQUIRE(c->touching);
    REQUIRE(c->proxy_m.z() > 0.85 * radius_m);
}

TEST_CASE("in a corner the proxy rests a radius from both walls") {
    // Floor z = 0 and wall x = 0, both seen from x, z > 0.
    palpate::cloud::Cloud c = sheet({}, 0.015, spacing_m);
    const std::size_t n_floor = c.points_m.size();
    for (std::size_t i = 0; i < n_floor; ++i) {
        const Eigen::Vector3d p = c.points_m[i];
        c.points_m[i].x() += 0.0155;
        c.points_m.emplace_back(0.0, p.y(), p.x() + 0.0155);
        c.normals.emplace_back(1.0, 0.0, 0.0);
    }
    const Scan scan(std::move(c));
    Proxy proxy(scan.cloud, scan.tree, scan.graph, radius_m);
    static_cast<void>(proxy.follow({0.008, 0.0, 0.008}));
    const auto contact = proxy.follow({-0.001, 0.0, -0.001});
    REQUIRE(contact);
    REQUIRE(contact->touching);
    REQUIRE(contact->proxy_m.x() == Approx(radius_m).epsilon(0.15));
    REQUIRE(contact->proxy_m.z() == Approx(radius_m).epsilon(0.15));
}

TEST_CASE("a first position inside the object is put out through the nearest side") {
    const Scan scan(ball(0.03, spacing_m));
    Proxy proxy(scan.cloud, scan.tree, scan.graph, radius_m);
    const auto c = proxy.follow({0.0, 0.0, 0.028});
    REQUIRE(c);
    REQUIRE(c->touching);
    REQUIRE(c->proxy_m.norm() == Approx(0.033).epsilon(0.02));
    REQUIRE(c->normal.z() > 0.98);
}
