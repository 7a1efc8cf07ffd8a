// A table of arbitrary bytes: the check never fails to answer, and what it lets through gives a finite force
// everywhere, bounded by its own limits. The first byte says what follows: the table's bytes as they are (0
// mod 3), the same with a right header and CRC (1), or patches to a table that passes, sealed again (2). The
// 12 bytes after it are where the tool is.
#include <cmath>

#include "firmware/core/intake.h"
#include "firmware/core/lookup.h"
#include "tests/fuzz/good_table.hpp"

namespace {

using fuzz::require;

fuzz::Reached passed("table passed"), pressed("with a force");

constexpr float REACH_M =
    10.0F;  // far beyond any device; pal_blend_touch answers for what is not finite there

/// |F| <= K f |grad f| + f^2 |grad K| / 2, each factor at its largest; for a linear depth law.
double force_bound_n(const pal_table& table, const pal_table_limits& limits, const pal_touch& touch) {
    const double kappa_r = static_cast<double>(table.kappa_per_m) * static_cast<double>(table.valid_radius_m);
    const double grad_uv = 2.0 * 5.0 * std::sqrt(1.0 + kappa_r * kappa_r);  // q >= 1/5
    const double grad_f = 1.0 + static_cast<double>(limits.surface_slope_max) * grad_uv;
    const double f_m = static_cast<double>(touch.depth_m) * grad_f;
    return static_cast<double>(limits.stiffness_max_n_per_m) * f_m * grad_f +
           0.5 * f_m * f_m * static_cast<double>(limits.stiffness_slope_max_n_per_m2) * grad_uv;
}

/// U >= 0 to eight thicknesses of depth but for rounding, which counts where terms of the depth law cancel.
bool never_pulls(const pal_table& table, const pal_touch& touch) {
    if (touch.potential_j >= 0.0F) return true;
    const std::uint32_t n_plane = (table.n_nodes + 2) * (table.n_nodes + 2);
    const std::span k(table.coef + n_plane, n_plane), h(table.coef + std::size_t{2} * n_plane, n_plane);
    const double depth_m = static_cast<double>(touch.depth_m),
                 k_n_per_m = static_cast<double>(touch.k_n_per_m);
    const double k_min = static_cast<double>(*std::ranges::min_element(k));
    const double f_max = depth_m * std::sqrt(k_n_per_m / k_min);
    const double x = static_cast<double>(*std::ranges::max_element(h)) * f_max;
    const auto term = [&](std::size_t i) { return std::fabs(static_cast<double>(table.psi[i])); };
    const double size = 1.0 + x * (term(0) + x * (term(1) + x * x * term(2)));
    const bool plain = term(3) == 0.0 && term(4) == 0.0;
    const double rounding_j = 1.0e-5 * size * 0.5 * k_n_per_m * f_max * f_max;
    return x > 8.0 || (plain && static_cast<double>(touch.potential_j) >= -rounding_j) ||
           (!plain && size > 1.0);  // the denominator alone must never make it negative
}

void check_touch(const pal_table& table, const pal_table_limits& limits, const std::array<float, 3>& at_m) {
    pal_touch touch;
    pal_table_touch(&table, at_m.data(), &touch);
    const double n = std::sqrt(static_cast<double>(touch.force_n[0]) * static_cast<double>(touch.force_n[0]) +
                               static_cast<double>(touch.force_n[1]) * static_cast<double>(touch.force_n[1]) +
                               static_cast<double>(touch.force_n[2]) * static_cast<double>(touch.force_n[2]));
    require(std::isfinite(n) && std::isfinite(touch.potential_j));
    if (!(touch.depth_m > 0.0F)) require(n == 0.0);
    if (n > 0.0) pressed.note();
    if (n > 0.0) require(never_pulls(table, touch));
    bool linear = true;
    for (const float c : table.psi) linear = linear && c == 0.0F;
    if (linear && n > 0.0) require(n <= 1.01 * force_bound_n(table, limits, touch));
}

/// In slices of any size the check says what it says at once, and ends.
void check_slices(const pal_table& table, const pal_table_limits& limits, std::uint32_t n_words_max) {
    const pal_err whole = pal_table_check(&table, &limits);
    pal_table_checking checking{};
    pal_err err = PAL_OK;
    std::uint32_t n_slices = 1;
    while (!pal_table_check_slice(&checking, &table, &limits, n_words_max, &err)) {
        require(err == PAL_OK && n_slices * n_words_max < 3U * PAL_TABLE_COEFS_MAX + 35U);
        ++n_slices;
    }
    require(err == whole);
}

void check(const pal_table& table, const std::array<float, 3>& at_m) {
    const pal_table_limits limits = pal_table_limits_default();
    if (pal_table_check(&table, &limits) != PAL_OK) return;
    passed.note();
    require(pal_table_header_ok(&table));
    check_touch(table, limits, at_m);
    float down_m = table.valid_radius_m;
    for (int i = 0; i < 20; ++i) {  // from 1 to 0.001 radii deep
        down_m *= 0.7F;
        check_touch(table, limits, {table.p0_m[0], table.p0_m[1], table.p0_m[2] - down_m});
    }
    for (int i = -4; i <= 4; ++i) {  // along the axis, and across it
        const float step = 0.25F * static_cast<float>(i) * table.valid_radius_m;
        check_touch(table, limits, {table.p0_m[0], table.p0_m[1], table.p0_m[2] + step});
        check_touch(table, limits, {table.p0_m[0] + step, table.p0_m[1] - step, table.p0_m[2] - 0.002F});
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static pal_table table;
    fuzz::Bytes bytes(data, size);
    const auto kind = fuzz::take<std::uint8_t>(bytes);
    auto at_m = fuzz::take<std::array<float, 3>>(bytes);
    for (float& x_m : at_m) x_m = std::fabs(x_m) <= REACH_M ? x_m : 0.0F;
    if (kind % 3 == 2) {
        fuzz::fill_good(table, 5U + 2U * (kind / 3U % 31U), 1);
        fuzz::patch(table, bytes, bytes.size());
    } else {
        std::memset(&table, 0, sizeof table);
        std::memcpy(&table, bytes.data(), std::min(bytes.size(), sizeof table));
    }
    if (kind % 3 != 0) pal_table_seal(&table);
    check_slices(table, pal_table_limits_default(), 1U + kind * kind);
    check(table, at_m);
    return 0;
}
