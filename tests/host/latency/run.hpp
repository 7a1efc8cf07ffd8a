/// Records of a loop in real time, made by hand: every time in them is known.
#pragma once
#include <cstdint>
#include <vector>

#include "common/tick.h"

namespace sample {

constexpr std::uint64_t T0_NS = 5000000000;  ///< programmed start of tick 0

/// n ticks on a grid of 1 ms, each woken `late_ns` late; then, all from the start on: reply after 5 us, table
/// after 6 us, force after 20 us, request after 23 us; a request completes 400 us after it was handed over.
[[nodiscard]] std::vector<pal_tick> run(std::size_t n, std::uint32_t late_ns = 10000);
/// Moves everything of one tick.
void shift(pal_tick& tick, std::int64_t by_ns);

}  // namespace sample
