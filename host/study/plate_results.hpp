/// A plate study as files: results.csv, results.json, results.md, and the script of pareto.png.
#pragma once
#include <filesystem>
#include <span>
#include <string>

#include "host/study/oracle.hpp"
#include "host/study/plate_study.hpp"

namespace palpate::study {

/// One header line, identifiers with units, an empty field where there is no number.
[[nodiscard]] std::string results_csv(std::span<const PlateRow> rows);

/// `about` (schema, palpate, build, command, started_utc, machine) first, then rows and tables. A number that
/// is not known is null, with ..._why beside it.
[[nodiscard]] Json results_json(const Json& about, std::span<const PlateRow> rows);

/// What 160 ms and 1 ms buy, and cost against n, for a person.
[[nodiscard]] std::string results_markdown(std::span<const PlateRow> rows);

/// gnuplot: error against time on a smooth and on a rough plate, one mark per method, the Pareto front, lines
/// at 1 ms and at 160 ms. Empty when neither plate was run.
[[nodiscard]] std::string pareto_script(std::span<const PlateRow> rows, const std::filesystem::path& picture);

}  // namespace palpate::study
