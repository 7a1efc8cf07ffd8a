/// An extreme study as files: results.csv, results.json, results.md.
#pragma once
#include <span>
#include <string>

#include "host/study/extreme_study.hpp"

namespace palpate::study {

/// One header line, an empty field where there is no number.
[[nodiscard]] std::string extreme_csv(std::span<const ExtremeRow> rows);
/// `about` first; then "silent", the count of wrong numbers without a word, and rows.
[[nodiscard]] Json extreme_json(const Json& about, std::span<const ExtremeRow> rows);
/// A line per case, a column per method: its error, or who spoke; the words below.
[[nodiscard]] std::string extreme_markdown(std::span<const ExtremeRow> rows);
[[nodiscard]] std::size_t count_silent(std::span<const ExtremeRow> rows);

}  // namespace palpate::study
