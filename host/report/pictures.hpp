/// force.png and curve.png, drawn by gnuplot from ticks.csv.
#pragma once
#include <filesystem>
#include <string>

namespace palpate::report {

/// Force and depth over scene time, and force against depth, from `directory`/ticks.csv. Words for a person
/// when gnuplot is missing or fails; empty when both pictures were made.
[[nodiscard]] std::string draw_pictures(const std::filesystem::path& directory, const std::string& title);

}  // namespace palpate::report
