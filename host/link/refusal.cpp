#include "host/link/refusal.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace palpate::link {
namespace {

template <class... Numbers>
std::string text(const char* format, Numbers... numbers) {
    std::array<char, 160> line{};
    std::snprintf(line.data(), line.size(), format, numbers...);
    return line.data();
}

/// Largest coefficient of a plane, and largest slope between neighbours.
struct Steepest {
    double value = 0.0, slope_per_m = 0.0;

    Steepest(const pal_table& table, std::uint32_t plane) {
        const std::uint32_t side = table.n_nodes + 2;
        const float* c = table.coef + static_cast<std::size_t>(plane) * side * side;
        const auto step = [&](std::uint32_t a, std::uint32_t b) {
            const double change = std::fabs(static_cast<double>(c[a]) - static_cast<double>(c[b]));
            slope_per_m = std::max(slope_per_m, change / static_cast<double>(table.spacing_m));
        };
        for (std::uint32_t i = 0; i < side; ++i) {
            for (std::uint32_t j = 0; j < side; ++j) {
                const std::uint32_t at = i * side + j;
                value = std::max(value, static_cast<double>(c[at]));
                if (i > 0) step(at, at - side);
                if (j > 0) step(at, at - 1);
            }
        }
    }
};

/// Which of the limits `table` breaks; the header and the numbers are good.
std::string broken_limit(const pal_table& table, const pal_table_limits& limits, const std::string& place) {
    const Steepest s(table, 0), k(table, 1);
    const auto k_max = static_cast<double>(limits.stiffness_max_n_per_m);
    if (k.value > k_max)
        return text("stiffness %.1f kN/m", 1e-3 * k.value) + place +
               text(" is above what the loop accepts (%.1f kN/m)", 1e-3 * k_max);
    const auto k_slope_max = static_cast<double>(limits.stiffness_slope_max_n_per_m2);
    if (k.slope_per_m > k_slope_max)
        return text("stiffness that changes by %.1f kN/m in a mm", 1e-6 * k.slope_per_m) + place +
               text(" is steeper than the loop accepts (%.1f kN/m in a mm)", 1e-6 * k_slope_max);
    const auto s_slope_max = static_cast<double>(limits.surface_slope_max);
    if (s.slope_per_m > s_slope_max)
        return text("skin with a slope of %.1f", s.slope_per_m) + place +
               text(" is steeper than the loop accepts (%.1f)", s_slope_max);
    return pal_err_words(PAL_ERR_RANGE) + place;
}

}  // namespace

std::optional<std::string> refusal_of(const pal_table& table) {
    const pal_table_limits limits = pal_table_limits_default();
    const pal_err err = pal_table_check(&table, &limits);
    if (err == PAL_OK) return std::nullopt;
    const auto mm = [&](int axis) { return 1e3 * static_cast<double>(table.made_for_m[axis]); };
    const std::string place = text(" at (%.1f, %.1f, %.1f) mm", mm(0), mm(1), mm(2));
    if (err != PAL_ERR_RANGE) return "a broken table" + place + ": " + pal_err_words(err);
    return broken_limit(table, limits, place);
}

}  // namespace palpate::link
