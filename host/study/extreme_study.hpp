/// Which methods hold at the extremes, which guard speaks, and whether any is silently wrong.
#pragma once
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "host/study/contest.hpp"
#include "host/study/extreme_cases.hpp"
#include "host/study/oracle.hpp"

namespace palpate::study {

struct ExtremeStudy {
    std::vector<std::string> groups, methods;  ///< by name; empty: all
    Eigen::Index nodes = 33;                   ///< 4 m + 1, at least 17
};

enum class Finding {
    holds,    ///< within the error that the method states
    refused,  ///< the problem was refused in words
    guarded,  ///< a guard took the number back
    status,   ///< not-converged or diverged, and it says so
    silent    ///< a wrong number, and nothing said
};
/// `holds refused guarded status silent`
[[nodiscard]] const char* name_of(Finding finding);

struct ExtremeRow {
    std::string group, name, method;
    Finding finding = Finding::holds;
    std::string words;  ///< of the refusal, the guard or the status
    double m_per_n = std::numeric_limits<double>::quiet_NaN();
    double truth_m_per_n = std::numeric_limits<double>::quiet_NaN();  ///< NaN: the problem has none
    std::string truth_how;
    double error = std::numeric_limits<double>::quiet_NaN();
    double stated_error = std::numeric_limits<double>::infinity();
    /// Of the same grid's exact answer about the continuum, where that is known: no method on it can do
    /// better.
    double grid_error = std::numeric_limits<double>::quiet_NaN();
};

/// The judgement of one outcome; `truth_m_per_n` NaN where the problem must be refused.
[[nodiscard]] ExtremeRow judged(const ExtremeCase& extreme, const std::string& method, const Outcome& outcome,
                                double truth_m_per_n);

/// cholesky multigrid eigen damped-jacobi jacobi eq7 on the grid; compliance (all grids up to this one) where
/// the continuum is known; bounds; ceres when it can be asked.
[[nodiscard]] std::vector<std::string> extreme_methods();

/// `watch` is told what goes on and may throw to stop.
[[nodiscard]] std::vector<ExtremeRow> run(const ExtremeStudy& study, const Oracle& oracle,
                                          const std::function<void(const std::string&)>& watch);

}  // namespace palpate::study
