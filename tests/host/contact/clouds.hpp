/// Clouds whose surface is known, for the tests of contact.
#pragma once
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "host/cloud/cloud.hpp"
#include "host/cloud/neighbours.hpp"

namespace palpate::testing {

/// A cloud with its tree and graph; stays where it was made, because they point to it.
struct Scan {
    cloud::Cloud cloud;
    cloud::Tree tree;
    cloud::Graph graph;
    explicit Scan(cloud::Cloud c, std::size_t k = 10)
        : cloud(std::move(c)), tree(cloud.points_m), graph(cloud, tree, k) {}
    Scan(const Scan&) = delete;
    Scan& operator=(const Scan&) = delete;
};

inline double uniform(std::mt19937& random) {
    return static_cast<double>(random()) / 4294967296.0;
}

/// Fibonacci points on a sphere about zero, about `spacing_m` apart; normals outward, or inward for a bowl.
inline cloud::Cloud ball(double radius_m, double spacing_m, bool inward = false) {
    cloud::Cloud c;
    const double area = 4.0 * M_PI * radius_m * radius_m;
    const int n = static_cast<int>(area / (spacing_m * spacing_m));
    const double golden = M_PI * (3.0 - std::sqrt(5.0));
    for (int i = 0; i < n; ++i) {
        const double z = 1.0 - (2.0 * i + 1.0) / n;
        const double r = std::sqrt(1.0 - z * z);
        const Eigen::Vector3d p(r * std::cos(golden * i), r * std::sin(golden * i), z);
        c.points_m.push_back(radius_m * p);
        c.normals.push_back(inward ? Eigen::Vector3d(-p) : p);
    }
    return c;
}

/// Height of the bumpy sheet: amplitude and wavelength; 0 is a plane.
struct Bumps {
    double amplitude_m = 0.0;
    double wavelength_m = 0.02;
    [[nodiscard]] double height_m(double x, double y) const {
        const double k = 2.0 * M_PI / wavelength_m;
        return amplitude_m * std::sin(k * x) * std::cos(0.8 * k * y + 0.3);
    }
    [[nodiscard]] Eigen::Vector3d normal(double x, double y) const {
        const double k = 2.0 * M_PI / wavelength_m;
        const double dx = amplitude_m * k * std::cos(k * x) * std::cos(0.8 * k * y + 0.3);
        const double dy = -0.8 * amplitude_m * k * std::sin(k * x) * std::sin(0.8 * k * y + 0.3);
        return Eigen::Vector3d(-dx, -dy, 1.0).normalized();
    }
};

/// Adds a square sheet at height z, half-side `half_m`, jittered by up to a quarter of the spacing; facing
/// down if `down`. Points with x > sparse_from_m are spaced 2.5 times wider.
inline void add_sheet(cloud::Cloud& c, const Bumps& bumps, double z_m, double half_m, double spacing_m,
                      bool down, unsigned seed = 1, double sparse_from_m = 1.0) {
    std::mt19937 random(seed);
    for (const bool sparse : {false, true}) {
        const double step = sparse ? 2.5 * spacing_m : spacing_m;
        const int n = static_cast<int>(2.0 * half_m / step);
        for (int i = 0; i <= n; ++i) {
            for (int j = 0; j <= n; ++j) {
                const double x = -half_m + step * (i + 0.5 * (uniform(random) - 0.5));
                const double y = -half_m + step * (j + 0.5 * (uniform(random) - 0.5));
                if ((x > sparse_from_m) != sparse) continue;
                const Eigen::Vector3d normal = bumps.normal(x, y);
                c.points_m.emplace_back(x, y, z_m + bumps.height_m(x, y));
                c.normals.push_back(down ? Eigen::Vector3d(-normal) : normal);
            }
        }
    }
}

inline cloud::Cloud sheet(const Bumps& bumps, double half_m, double spacing_m, double sparse_from_m = 1.0) {
    cloud::Cloud c;
    add_sheet(c, bumps, 0.0, half_m, spacing_m, false, 1, sparse_from_m);
    return c;
}

/// A plate of the given thickness whose edge at x > 0 is round: two walls and half a cylinder, jittered.
inline cloud::Cloud hairpin(double thickness_m, double half_m, double spacing_m) {
    std::mt19937 random(3);
    cloud::Cloud c;
    const double radius = 0.5 * thickness_m;
    const double length = 2.0 * half_m + M_PI * radius;  // of the profile, from the upper wall to the lower
    const int n = static_cast<int>(length / spacing_m);
    const int m = static_cast<int>(2.0 * half_m / spacing_m);
    for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= m; ++j) {
            const double s = spacing_m * (i + 0.5 * (uniform(random) - 0.5)) - half_m;
            const double y = spacing_m * (j + 0.5 * (uniform(random) - 0.5)) - half_m;
            const double angle = std::clamp(s / radius, 0.0, M_PI);
            const Eigen::Vector3d normal(std::sin(angle), 0.0, std::cos(angle));
            const double x = s < 0.0 ? s : std::min(0.0, M_PI * radius - s);
            c.points_m.push_back(Eigen::Vector3d(x, y, 0.0) + radius * normal);
            c.normals.push_back(normal);
        }
    }
    return c;
}

/// Angle between unit vectors, degrees.
inline double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::atan2((a - b).norm(), (a + b).norm()) * 360.0 / M_PI;
}

}  // namespace palpate::testing
