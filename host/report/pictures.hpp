/// force.png and curve.png, drawn by gnuplot from ticks.csv.
#pragma once
#include <filesystem>
#include <span>
#include <string>

#include "common/tick.h"

namespace palpate::report {

/// Force and depth over scene time, and force against depth, from `directory`/ticks.csv, which holds `ticks`.
/// Words for a person when one of them was not made and why; empty when both were.
[[nodiscard]] std::string draw_pictures(const std::filesystem::path& directory, const std::string& title,
                                        std::span<const pal_tick> ticks);

}  // namespace palpate::report
