/// Fields of all kinds to be bounded: smooth, jumping, with nodules, of random nodes; foundations alike.
#pragma once
#include <cmath>
#include <functional>

#include "tests/host/plate/fields.hpp"

namespace palpate::plate::fields {

using Function = std::function<double(double, double)>;

enum class Kind { smooth, jump, nodule, wart, noise };
constexpr int N_KINDS = 5;

/// Log-uniform between 1/`most` and `most`.
[[nodiscard]] inline double log_uniform(Random& random, double most) {
    return std::pow(most, 2.0 * random.next() - 1.0);
}

/// Of x and z in [0, 1], between 1 and `ratio`, which may be below 1. Noise is of the place, not of the grid.
[[nodiscard]] inline Function random_field(Random& random, Kind kind, double ratio) {
    const double a = random.next(), b = random.next(), c = random.next(), d = random.next();
    const double x0 = 0.2 + 0.6 * a, z0 = 0.2 + 0.6 * b, radius = 0.05 + 0.2 * c;
    switch (kind) {
        case Kind::smooth:
            return [=](double x, double z) {
                return std::pow(ratio, 0.5 + 0.5 * std::sin(6.0 * d + 3.0 * a * x + 3.0 * b * z));
            };
        case Kind::jump:
            return [=, turn = 6.283 * a, shift = 0.5 * (b - 0.5)](double x, double z) {
                const double across = (x - 0.5) * std::cos(turn) + (z - 0.5) * std::sin(turn);
                return across > shift ? ratio : 1.0;
            };
        case Kind::nodule:
            return [=](double x, double z) {
                return (x - x0) * (x - x0) + (z - z0) * (z - z0) < radius * radius ? ratio : 1.0;
            };
        case Kind::wart:
            return [=](double x, double z) { return 1.0 + (ratio - 1.0) * bell(x, z, x0, z0, radius); };
        case Kind::noise:
            break;
    }
    return [=](double x, double z) {
        const double mixed = 43758.5453 * std::sin(12.9898 * (x + a) + 78.233 * (z + b));
        return std::pow(ratio, mixed - std::floor(mixed));
    };
}

}  // namespace palpate::plate::fields
