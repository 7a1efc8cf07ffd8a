/// What a compliance should have been.
#pragma once
#include <optional>
#include <string>

#include "host/study/oracle.hpp"
#include "host/study/plates.hpp"

namespace palpate::study {

struct Truth {
    double m_per_n;
    double relative_error;  ///< its own, estimated
    std::string how;
};

/// The centre's compliance in the continuum: closed form where D is uniform, else extrapolated from the
/// field's finest grid, `nodes_max` at most. Its error is the larger of what the extrapolation says and,
/// where D is not smooth, the change from the next coarser pair of grids.
[[nodiscard]] Truth continuum_truth(const RigidityField& field, const plate::Sheet& sheet,
                                    Eigen::Index nodes_max);

/// The same extrapolated even where there is a closed form: to judge the closed form by.
[[nodiscard]] Truth extrapolated_truth(const RigidityField& field, const plate::Sheet& sheet,
                                       Eigen::Index nodes_max);

/// The discrete plate by a road of its own: Ceres up to 65 nodes a side when it can be asked, else extended
/// precision up to 33. nullopt: neither.
[[nodiscard]] std::optional<Truth> discrete_truth(const plate::Problem& problem, const Oracle& oracle);

}  // namespace palpate::study
