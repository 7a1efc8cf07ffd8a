/// What `palpate solve` tells: a document for programs, a page for people.
#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "host/app/solve_answer.hpp"
#include "host/report/figures.hpp"

namespace palpate::app {

/// A file that was asked for.
struct SolveFile {
    std::filesystem::path path;  ///< empty: it was not asked for
    std::string missing_why;     ///< empty: it was written
};

struct SolveTold {
    std::string command, started_utc;
    SolveFile field, plot;
};

/// Schema palpate.solve/1, described in docs/PLATE_FILE.md. A number without a value is null, with a sibling
/// ..._why.
[[nodiscard]] report::Json solve_document(const scene::PlateFile& file, const SolveAnswer& answer,
                                          const SolveTold& told);

/// The same for a person, from the document. Ends with a line end.
[[nodiscard]] std::string solve_page(const report::Json& document);

}  // namespace palpate::app
