/// Error against run time: every method on every grid of every plate.
#pragma once
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host/study/contest.hpp"
#include "host/study/oracle.hpp"
#include "host/study/stopwatch.hpp"
#include "host/study/truth.hpp"

namespace palpate::study {

struct PlateStudy {
    std::vector<std::string> fields, methods;  ///< by name; empty: all
    std::vector<Eigen::Index> nodes{17, 33, 65};
    bool bare = true, on_foundation = true;
    /// More grids, of this field, bare, only: for the cost against n.
    std::string cost_field = "hyperbolic";
    std::vector<Eigen::Index> cost_nodes{129, 257};
    double budget_s = 0.1;   ///< for the repeats of each row
    double sweeps_s = 0.18;  ///< for one solution by sweeps, a fifth of it spare: 0.144 s, within 160 ms
    Eigen::Index reference_nodes_max = 257;
};

/// The first thing wrong with the names or numbers of a study; nullopt when it can run.
[[nodiscard]] std::optional<std::string> problem_with(const PlateStudy& study);

/// One method on one grid of one plate. A number that is not known is NaN, 0 repeats: not timed.
struct PlateRow {
    std::string field;
    double side_over_l = 0.0;
    std::string method;
    Eigen::Index nodes = 0;
    Outcome outcome;
    double error = std::numeric_limits<double>::quiet_NaN();  ///< relative, of the continuum's compliance
    std::optional<Truth> truth;
    double discrete_error = std::numeric_limits<double>::quiet_NaN();  ///< relative, of the same grid's
    std::string discrete_by;
    Timing timing;
    bool constructs = false;  ///< the time includes making the solver: D jumps on grid lines
    std::size_t memory_bytes = 0;
    std::string memory_how;
};

/// What goes on, for a person; may throw to stop.
using Watch = std::function<void(const std::string&)>;

/// Every field, bare, then on its foundation; grids and methods in the order asked.
[[nodiscard]] std::vector<PlateRow> run(const PlateStudy& study, const Oracle& oracle, const Watch& watch);

[[nodiscard]] std::vector<std::string> field_names();
/// Names of all methods, those of palpate-reference too.
[[nodiscard]] std::vector<std::string> method_names();

}  // namespace palpate::study
