/// A short run and what tests need around it.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "host/record/record.hpp"

namespace sample {

/// n ticks: homing, then the path from tick 3 on (path_tick 1), contact in the middle.
[[nodiscard]] std::vector<pal_tick> ticks(std::size_t n);
/// A sealed table of 5 x 5 nodes.
[[nodiscard]] std::unique_ptr<pal_table> table(std::uint64_t id);
[[nodiscard]] palpate::record::Record record();
[[nodiscard]] std::string text_in(const std::filesystem::path& file);
/// Empty folder of that name, for one test.
[[nodiscard]] std::filesystem::path folder(const std::string& name);

}  // namespace sample
