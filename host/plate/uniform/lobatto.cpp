#include "host/plate/uniform/lobatto.hpp"

#include <cmath>

namespace palpate::plate {
namespace {

/// cos(j pi/16), by halving angles: cos((a + b)/2) = (cos a + cos b)/(2 cos((b - a)/2)).
std::array<double, N_LOBATTO> cosines() {
    std::array<double, N_LOBATTO> c{};
    constexpr std::size_t LAST = N_LOBATTO - 1;
    c[0] = 1.0;
    c[LAST / 2] = 0.0;
    c[LAST] = -1.0;
    double cos_step = 0.0;  // of pi/2
    for (std::size_t step = LAST / 2; step > 1; step /= 2) {
        cos_step = std::sqrt(0.5 * (1.0 + cos_step));
        for (std::size_t j = step / 2; j < LAST; j += step) {
            c[j] = (c[j - step / 2] + c[j + step / 2]) / (2.0 * cos_step);
        }
    }
    return c;
}

}  // namespace

std::array<double, N_LOBATTO> lobatto_points(const Interval& interval) {
    std::array<double, N_LOBATTO> points = cosines();
    for (double& x : points)
        x = 0.5 * ((interval.begin + interval.end) + (interval.end - interval.begin) * x);
    points.front() = interval.end;
    points.back() = interval.begin;
    return points;
}

double interpolate(const Interval& interval, const std::array<double, N_LOBATTO>& values, double x) {
    const std::array<double, N_LOBATTO> points = lobatto_points(interval);
    double above = 0.0;
    double below = 0.0;
    for (std::size_t j = 0; j < N_LOBATTO; ++j) {
        if (x == points[j]) return values[j];
        const double sign = j % 2 == 0 ? 1.0 : -1.0;
        const double weight = (j == 0 || j + 1 == N_LOBATTO ? 0.5 * sign : sign) / (x - points[j]);
        above += weight * values[j];
        below += weight;
    }
    return above / below;
}

}  // namespace palpate::plate
