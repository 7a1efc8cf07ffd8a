/// Tables that pass their check, and patches to them that need not.
#pragma once
#include "common/table.h"
#include "tests/fuzz/input.hpp"

namespace fuzz {

/// Zeroes what a table of `n_nodes` uses and fills in a plane skin at the workspace's middle, facing the
/// user. Not sealed.
inline void fill_good(pal_table& table, std::uint32_t n_nodes, std::uint64_t id) {
    std::memset(&table, 0, pal_table_bytes(n_nodes));
    table.id = id;
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

/// Overwrites words: place (2 bytes, in words of 4) and value (4), until `bytes` or `n_most` end. The size
/// stays what it is.
inline void patch(pal_table& table, Bytes& bytes, std::size_t n_most) {
    for (std::size_t n = 0; n < n_most && bytes.size() >= 6; ++n) {
        const std::size_t place = take<std::uint16_t>(bytes) * sizeof(float) % pal_table_bytes(table.n_nodes);
        const auto word = take<std::uint32_t>(bytes);
        if (place == offsetof(pal_table, n_nodes)) continue;
        std::memcpy(reinterpret_cast<std::uint8_t*>(&table) + place, &word, sizeof word);
    }
}

}  // namespace fuzz
