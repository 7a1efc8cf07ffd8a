// A table of arbitrary bytes: the check never fails to answer, and what it lets through gives a finite force
// everywhere, bounded by its own limits. The rest of an input whose first byte is odd are patches (place and
// four bytes) to a table that passes, so that more than the CRC is reached; its first 12 bytes are where the
// tool is.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>

#include "firmware/core/intake.h"
#include "firmware/core/lookup.h"

namespace {

using Bytes = std::span<const std::uint8_t>;

void require(bool holds) {
    if (!holds) std::abort();
}

template <class T>
T take(Bytes& bytes) {
    T value{};
    const std::size_t n = std::min(bytes.size(), sizeof value);
    std::memcpy(&value, bytes.data(), n);
    bytes = bytes.subspan(n);
    return value;
}

void fill_good(pal_table& table, std::uint32_t n_nodes) {
    table.id = 1;
    table.n_nodes = n_nodes;
    table.spacing_m = 0.001F;
    table.valid_radius_m = 0.0005F * static_cast<float>(n_nodes - 1);
    table.kappa_per_m = 20.0F;
    table.depth_scale_m = 0.0015F;
    for (std::size_t i = 0; i < 3; ++i) table.axes[4 * i] = 1.0F;
    const std::uint32_t n_plane = (n_nodes + 2) * (n_nodes + 2);
    for (std::uint32_t i = 0; i < n_plane; ++i) {
        table.coef[i] = 1.0e-5F * static_cast<float>(i % 7);
        table.coef[n_plane + i] = 500.0F + 0.1F * static_cast<float>(i % 5);
        table.coef[2 * n_plane + i] = 600.0F;
    }
}

void patch(pal_table& table, Bytes bytes) {
    while (bytes.size() >= 6) {
        const std::size_t place = take<std::uint16_t>(bytes) * 4U % pal_table_bytes(table.n_nodes);
        const auto word = take<std::uint32_t>(bytes);
        if (place / 4 == offsetof(pal_table, n_nodes) / 4) continue;  // the size stays; raw inputs change it
        std::memcpy(reinterpret_cast<std::uint8_t*>(&table) + place, &word, sizeof word);
    }
}

/// |F| <= K f |grad f| + f^2 |grad K| / 2, each factor at its largest; for a linear depth law.
double force_bound_n(const pal_table& table, const pal_table_limits& limits, const pal_touch& touch) {
    const double kappa_r = double{table.kappa_per_m} * double{table.valid_radius_m};
    const double grad_uv = 2.0 * 5.0 * std::sqrt(1.0 + kappa_r * kappa_r);  // q >= 1/5
    const double grad_f = 1.0 + double{limits.surface_slope_max} * grad_uv;
    const double f_m = double{touch.depth_m} * grad_f;
    return double{limits.stiffness_max_n_per_m} * f_m * grad_f +
           0.5 * f_m * f_m * double{limits.stiffness_slope_max_n_per_m2} * grad_uv;
}

void check_touch(const pal_table& table, const pal_table_limits& limits, const std::array<float, 3>& at_m) {
    pal_touch touch;
    pal_table_touch(&table, at_m.data(), &touch);
    const double n = std::sqrt(double{touch.force_n[0]} * double{touch.force_n[0]} +
                               double{touch.force_n[1]} * double{touch.force_n[1]} +
                               double{touch.force_n[2]} * double{touch.force_n[2]});
    require(std::isfinite(n) && std::isfinite(touch.potential_j));
    if (!(touch.depth_m > 0.0F)) require(n == 0.0);
    bool linear = true;
    for (const float c : table.psi) linear = linear && c == 0.0F;
    if (linear && n > 0.0) require(n <= 1.01 * force_bound_n(table, limits, touch));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static pal_table table;
    if (size < 13) return 0;
    std::memset(&table, 0, sizeof table);
    Bytes bytes(data, size);
    const auto kind = take<std::uint8_t>(bytes);
    const auto at_m = take<std::array<float, 3>>(bytes);
    if (kind % 2 == 0) {
        std::memcpy(&table, bytes.data(), std::min(bytes.size(), sizeof table));
    } else {
        fill_good(table, 5U + 2U * (kind / 2U % 31U));
        patch(table, bytes);
        pal_table_seal(&table);
    }
    const pal_table_limits limits = pal_intake_limits_default();
    const bool good = pal_table_check(&table, &limits) == PAL_OK;
    require(!good || pal_table_header_ok(&table));
    if (!good) return 0;
    check_touch(table, limits, at_m);
    for (int i = -4; i <= 4; ++i) {  // along the axis, and across it
        const float step = 0.25F * static_cast<float>(i) * table.valid_radius_m;
        check_touch(table, limits, {table.p0_m[0], table.p0_m[1], table.p0_m[2] + step});
        check_touch(table, limits, {table.p0_m[0] + step, table.p0_m[1] - step, table.p0_m[2] - 0.002F});
    }
    return 0;
}
