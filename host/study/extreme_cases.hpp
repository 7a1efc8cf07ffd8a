/// Plates at the end of what double, the model and the grid can take.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "host/plate/field.hpp"

namespace palpate::study {

/// How the truth of a case is known.
enum class Judge {
    discrete,   ///< the same grid in 113 bits
    continuum,  ///< the closed form
    refusal     ///< there is none: the problem must be refused
};

struct ExtremeCase {
    std::string group;  ///< contrast hole poisson aspect units one-node bad-input
    std::string name;
    plate::Problem problem;
    Judge judge = Judge::discrete;
    std::optional<plate::Sheet> sheet;  ///< of the same plate, Judge::continuum
};

/// In the order of the groups. `nodes`: along the shorter side, 4 m + 1.
[[nodiscard]] std::vector<ExtremeCase> extreme_cases(Eigen::Index nodes);
/// Names of the groups.
[[nodiscard]] std::vector<std::string> extreme_groups();

}  // namespace palpate::study
