/// What is concluded from the rows of a plate study.
#pragma once
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/study/fit.hpp"
#include "host/study/plate_study.hpp"

namespace palpate::study {

/// The best that a method does within a time, each on the grid that suits it best: error and that grid.
struct WithinTime {
    std::string method;
    struct Best {
        Eigen::Index nodes = 0;
        /// NaN: no row within the time
        double time_s = std::numeric_limits<double>::quiet_NaN(), error = time_s;
        double reference_error = 0.0;  ///< an error below it is not known better
        std::string status;
    };
    Best smooth;   ///< the hyperbolic field, bare
    Best rough;    ///< the random field, bare
    Best founded;  ///< the nodule on its foundation
};
/// Rows whose median time is at most `time_s`. Methods in the order in which they first appear.
[[nodiscard]] std::vector<WithinTime> within_time(std::span<const PlateRow> rows, double time_s);

/// Cost against the grid, of one field without a foundation: solved rows only.
struct Cost {
    std::string method;
    std::vector<Eigen::Index> nodes;
    std::vector<double> median_s;
    std::optional<PowerLaw> law;  ///< of the nodes along a side
};
[[nodiscard]] std::vector<Cost> cost_against_nodes(std::span<const PlateRow> rows, const std::string& field);

/// Rows of one field and foundation that have an error and a time.
[[nodiscard]] std::vector<PlateRow> comparable(std::span<const PlateRow> rows, const std::string& field,
                                               double side_over_l);
[[nodiscard]] std::vector<Trade> trades_of(std::span<const PlateRow> rows);

}  // namespace palpate::study
