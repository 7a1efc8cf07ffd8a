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

/// The force was cut to a limit.
[[nodiscard]] inline bool is_clamped(const pal_tick& tick) {
    return (tick.faults & (PAL_FAULT_FORCE_CLAMP | PAL_FAULT_MOTOR_CLAMP)) != 0;
}

/// The table in use was too old.
[[nodiscard]] inline bool is_stale(const pal_tick& tick) {
    return (tick.faults & (PAL_FAULT_TABLE_STALE | PAL_FAULT_TABLE_DROPPED)) != 0;
}

}  // namespace palpate::report
