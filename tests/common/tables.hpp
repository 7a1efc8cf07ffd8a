/// Tables made from plain functions, for tests.
#pragma once
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>

#include "common/table.h"

namespace tables {

struct Fields {
    std::function<double(double, double)> s_m = [](double, double) { return 0.0; };
    std::function<double(double, double)> k_n_per_m = [](double, double) { return 800.0; };
    std::function<double(double, double)> h_per_m = [](double, double) { return 0.0; };
};

inline pal_table_limits limits() {
    return {6000.0F, 3.0e6F, 4.0F};
}

/// A sealed table of `n_nodes` over +-10 mm. The functions are taken as coefficients: the field is their
/// B-spline.
inline std::unique_ptr<pal_table> make(const Fields& fields = {}, std::uint32_t n_nodes = 33,
                                       double kappa_per_m = 0.0, std::uint64_t id = 1) {
    auto table = std::make_unique<pal_table>();
    std::memset(table.get(), 0, sizeof(pal_table));
    table->id = id;
    table->n_nodes = n_nodes;
    table->spacing_m = static_cast<float>(0.02 / (n_nodes - 1));
    table->valid_radius_m = 0.01F;
    table->kappa_per_m = static_cast<float>(kappa_per_m);
    table->depth_scale_m = 1.0e-3F;
    for (int i = 0; i < 3; ++i) table->axes[4 * i] = 1.0F;
    const std::uint32_t side = n_nodes + 2;
    const double middle = 0.5 * (n_nodes - 1);
    for (std::uint32_t i = 0; i < side; ++i) {
        for (std::uint32_t j = 0; j < side; ++j) {
            const double u = (i - 1.0 - middle) * static_cast<double>(table->spacing_m);
            const double v = (j - 1.0 - middle) * static_cast<double>(table->spacing_m);
            table->coef[i * side + j] = static_cast<float>(fields.s_m(u, v));
            table->coef[side * side + i * side + j] = static_cast<float>(fields.k_n_per_m(u, v));
            table->coef[2 * side * side + i * side + j] = static_cast<float>(fields.h_per_m(u, v));
        }
    }
    pal_table_seal(table.get());
    return table;
}

}  // namespace tables
