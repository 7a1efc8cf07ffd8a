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

/// |F| <= K f |grad f| + f^2 |grad K| / 2, each factor at its largest; for a linear depth law.
double force_bound_n(const pal_table& table, const pal_table_limits& limits, const pal_touch& touch) {
    const double kappa_r = static_cast<double>(table.kappa_per_m) * static_cast<double>(table.valid_radius_m);
    const double grad_uv = 2.0 * 5.0 * std::sqrt(1.0 + kappa_r * kappa_r);  // q >= 1/5
    const double grad_f = 1.0 + static_cast<double>(limits.surface_slope_max) * grad_uv;
    const double f_m = static_cast<double>(touch.depth_m) * grad_f;
    return static_cast<double>(limits.stiffness_max_n_per_m) * f_m * grad_f +
           0.5 * f_m * f_m * static_cast<double>(limits.stiffness_slope_max_n_per_m2) * grad_uv;
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
    bool linear = true;
    for (const float c : table.psi) linear = linear && c == 0.0F;
    if (linear && n > 0.0) require(n <= 1.01 * force_bound_n(table, limits, touch));
}

void check(const pal_table& table, const std::array<float, 3>& at_m) {
    const pal_table_limits limits = pal_intake_limits_default();
    if (pal_table_check(&table, &limits) != PAL_OK) return;
    passed.note();
    require(pal_table_header_ok(&table));
    check_touch(table, limits, at_m);
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
    const auto at_m = fuzz::take<std::array<float, 3>>(bytes);
    if (kind % 3 == 2) {
        fuzz::fill_good(table, 5U + 2U * (kind / 3U % 31U), 1);
        fuzz::patch(table, bytes, bytes.size());
    } else {
        std::memset(&table, 0, sizeof table);
        std::memcpy(&table, bytes.data(), std::min(bytes.size(), sizeof table));
    }
    if (kind % 3 != 0) pal_table_seal(&table);
    check(table, at_m);
    return 0;
}
