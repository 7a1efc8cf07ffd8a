/// What a record's numbers are, as vectors.
#pragma once
#include <Eigen/Core>

#include "common/tick.h"

namespace palpate::report {

[[nodiscard]] inline Eigen::Vector3d vec(const float (&v)[3]) {
    return Eigen::Map<const Eigen::Vector3f>(v).cast<double>();
}

/// Tool centre: the true one where a simulated device tells, the sensed one otherwise. Workspace frame, m.
[[nodiscard]] inline Eigen::Vector3d place_of(const pal_tick& tick) {
    return tick.truth_valid != 0 ? vec(tick.truth_position_m) : vec(tick.position_m);
}

/// What the motor words did where a simulated device tells, what was commanded otherwise, N.
[[nodiscard]] inline Eigen::Vector3d force_of(const pal_tick& tick) {
    return tick.truth_valid != 0 ? vec(tick.truth_force_n) : vec(tick.force_n);
}

}  // namespace palpate::report
