#include "tests/host/plate/random_sheet.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/host/plate/fields.hpp"

namespace palpate::plate::fields {
namespace {

constexpr double TWO_PI = 6.283185307179586;

double between(Random& random, double low, double high) {
    return low + (high - low) * random.next();
}

/// A place in units of the sides.
struct Place {
    double x, z;
    Place(Random& random, double margin)
        : x(between(random, margin, 1.0 - margin)), z(between(random, margin, 1.0 - margin)) {}
};

/// D in [1, contrast] over the unit square.
Field unit_field(Random& random, Kind kind, double contrast, const Place& load) {
    const Place a(random, 0.2);
    const double angle = between(random, 0.0, TWO_PI), width = between(random, 0.1, 0.3);
    switch (kind) {
        case Kind::smooth: {
            const double kx = between(random, 1.0, 6.0), kz = between(random, 1.0, 6.0);
            return [=](double x, double z) {
                return std::pow(contrast, 0.5 + 0.5 * std::sin(kx * x + angle) * std::cos(kz * z));
            };
        }
        case Kind::jump:
            return [=](double x, double z) {
                return (x - a.x) * std::cos(angle) + (z - a.z) * std::sin(angle) > 0.0 ? contrast : 1.0;
            };
        case Kind::nodule:
            return [=](double x, double z) {
                return 1.0 + (contrast - 1.0) * bell(x, z, a.x, a.z, 0.5 * width);
            };
        case Kind::random: {
            struct Site {
                double x, z, value;
            };
            std::vector<Site> sites;
            for (int k = 0; k < 60; ++k)
                sites.push_back({random.next(), random.next(), std::pow(contrast, random.next())});
            return [sites](double x, double z) {
                const auto distance = [&](const Site& s) {
                    return (s.x - x) * (s.x - x) + (s.z - z) * (s.z - z);
                };
                return std::min_element(
                           sites.begin(), sites.end(),
                           [&](const Site& p, const Site& q) { return distance(p) < distance(q); })
                    ->value;
            };
        }
        case Kind::island:
            return [=](double x, double z) {
                return std::hypot(x - load.x, z - load.z) < width ? contrast : 1.0;
            };
        case Kind::hole:
            break;
    }
    return [=](double x, double) { return 1.0 + (contrast - 1.0) * x; };
}

Edge random_edge(Random& random) {
    const double u = random.next();
    return u < 0.6 ? Edge::clamped : u < 0.8 ? Edge::supported : Edge::free;
}

bool held(const std::array<Edge, 4>& edges) {
    int supported = 0;
    for (const Edge edge : edges) {
        if (edge == Edge::clamped) return true;
        supported += edge == Edge::supported;
    }
    return supported > 1;
}

}  // namespace

RandomCase random_case(std::uint64_t seed) {
    Random random(seed * 0x9E3779B97F4A7C15U + 1U);
    for (int k = 0; k < 4; ++k) (void)random.next();
    RandomCase c;
    c.kind = static_cast<Kind>(seed % N_KINDS);
    c.contrast = std::pow(10.0, between(random, 0.0, 6.0));
    const Place load(random, 0.15);
    const double side_m = std::pow(10.0, between(random, -3.0, 1.0)), aspect = std::pow(10.0, random.next());
    const double unit_n_m = std::pow(10.0, between(random, -6.0, 3.0));
    c.sheet.size_m = random.next() < 0.5 ? Eigen::Vector2d(side_m, side_m / aspect)
                                         : Eigen::Vector2d(side_m / aspect, side_m);
    c.sheet.poisson = between(random, -0.9, 0.49);
    const Field unit = unit_field(random, c.kind, c.contrast, load);
    const Eigen::Vector2d size_m = c.sheet.size_m;
    c.sheet.rigidity_n_m = [=](double x, double z) {
        return unit_n_m * unit(x / size_m.x(), z / size_m.y());
    };
    const double ratio = random.next() < 0.4 ? 0.0 : between(random, 1.0, 20.0);  // side over l at D = 1
    const bool patch = random.next() < 0.3;
    if (ratio > 0.0) {
        const double k = unit_n_m * std::pow(ratio / side_m, 4.0);
        c.sheet.foundation_n_per_m3 = [=](double x, double) {
            return patch && x < 0.4 * size_m.x() ? 0.0 : k;
        };
    }
    for (Edge& edge : c.sheet.edges) edge = random_edge(random);
    if (!held(c.sheet.edges)) c.sheet.edges[0] = Edge::clamped;
    if (c.kind == Kind::hole) {
        const double hole_x = load.x < 0.5 ? load.x + 0.3 : load.x - 0.3,
                     radius = between(random, 0.08, 0.15);
        c.sheet.solid = [=](double x, double z) {
            return std::hypot(x / size_m.x() - hole_x, z / size_m.y() - load.z) - radius;
        };
    }
    const Eigen::Index counts[3] = {9, 17, 33};
    c.nodes = {counts[static_cast<std::size_t>(3.0 * random.next())],
               counts[static_cast<std::size_t>(3.0 * random.next())]};
    c.load.at_m = {load.x * size_m.x(), load.z * size_m.y()};
    char words[160];
    std::snprintf(
        words, sizeof words, "seed %llu kind %d contrast %.3g nu %.2f sides %.3g x %.3g nodes %ld x %ld k %d",
        static_cast<unsigned long long>(seed), static_cast<int>(c.kind), c.contrast, c.sheet.poisson,
        size_m.x(), size_m.y(), static_cast<long>(c.nodes.nx), static_cast<long>(c.nodes.nz), ratio > 0.0);
    c.words = words;
    return c;
}

}  // namespace palpate::plate::fields
