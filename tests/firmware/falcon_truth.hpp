/// The Falcon's geometry once more, in double and straight from docs/PROTOCOL.md 4: what the driver's float
/// kinematics are judged by.
#pragma once
#include <array>
#include <cmath>
#include <optional>

namespace truth {

using Three = std::array<double, 3>;

inline constexpr double PI = 3.14159265358979323846;
inline constexpr double COUNTS_PER_RAD = 320.0 * 4.0 * 110.0 / 14.25 / (2.0 * PI);
inline constexpr double THETA_ZERO_RAD = 35.0 * PI / 180.0;

/// Angle of each arm at a position; nullopt where the mechanism cannot be, or not within -25 to 90 degrees.
inline std::optional<Three> theta_rad(const Three& p) {
    constexpr double a = 0.060, b = 0.1025, c = 0.01443, de = 0.0225, f = -0.025, r = 0.0400, s = -0.02309;
    Three theta{};
    for (std::size_t i = 0; i < 3; ++i) {
        const double phi = (105.0 - 120.0 * static_cast<double>(i)) * PI / 180.0;
        const double u = p[0] * std::cos(phi) + p[1] * std::sin(phi) - r + c;
        const double v = -p[0] * std::sin(phi) + p[1] * std::cos(phi) - s + f;
        if (!(std::abs(v) < b)) return std::nullopt;
        const double k = de + b * std::sin(std::acos(v / b));
        const double rho = std::hypot(u, p[2]);
        const double lag = (rho * rho + a * a - k * k) / (2.0 * a * rho);
        if (!(std::abs(lag) < 1.0)) return std::nullopt;
        theta[i] = std::atan2(p[2], u) - std::acos(lag);
        if (theta[i] < -25.0 * PI / 180.0 || theta[i] > 90.0 * PI / 180.0) return std::nullopt;
    }
    return theta;
}

/// Encoder readings, not rounded.
inline std::optional<Three> counts(const Three& p) {
    auto theta = theta_rad(p);
    if (theta) {
        for (double& t : *theta) t = (t - THETA_ZERO_RAD) * COUNTS_PER_RAD;
    }
    return theta;
}

/// Force on the hand of motor words, by virtual work: F . dx = tau . dtheta, tau = -words / 4200, with the
/// derivatives of theta_rad by central differences.
inline std::optional<Three> force_n(const Three& p, const Three& words) {
    constexpr double H = 1.0e-6;
    Three force{};
    for (std::size_t c = 0; c < 3; ++c) {
        Three more = p;
        Three less = p;
        more[c] += H;
        less[c] -= H;
        const auto up = theta_rad(more);
        const auto down = theta_rad(less);
        if (!up || !down) return std::nullopt;
        for (std::size_t i = 0; i < 3; ++i) {
            force[c] += -words[i] / 4200.0 * ((*up)[i] - (*down)[i]) / (2.0 * H);
        }
    }
    return force;
}

}  // namespace truth
