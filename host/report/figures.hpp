/// summary.json: the verdict first, then the numbers it rests on.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

#include "common/tick.h"
#include "host/report/force_error.hpp"
#include "host/report/touches.hpp"
#include "host/scene/world.hpp"

namespace palpate::report {

using Json = nlohmann::ordered_json;  ///< keys stay in the order in which they are written

/// Felt stiffness over the first nodule against beside it: median |F|/depth over the stroke's contact ticks
/// whose foot lies within the nodule's radius, over the median between 1.5 and 3 radii. Stroke: the legs of
/// the path that stay in contact and move. |F| is what the motor words did, depth comes from the tool's place
/// and the scan: neither E nor k is asked.
struct StiffnessRatio {
    std::optional<double> value;
    std::string why;  ///< why there is no value
    std::size_t n_over = 0, n_beside = 0;
};
[[nodiscard]] StiffnessRatio stiffness_ratio(const scene::World& world, std::span<const pal_tick> ticks,
                                             std::span<const Touch> touches);

/// Counts and ranges over all ticks: contact, forces, depth/h with its warning, k, faults, missed periods,
/// table ages. Depths in object metres; forces and k as the hand
/// feels them, k = position_scale force_scale times the object's.
[[nodiscard]] Json run_figures(const scene::World& world, std::span<const pal_tick> ticks,
                               std::span<const Touch> touches);

/// force_error_rms_relative, force_error_max_relative, force_error_parts, ...; null with ..._why where there
/// is none.
void add_force_error(Json& summary, const std::optional<ForceError>& error, const std::string& why_not);

/// Bounds of [expect] that do not hold, in words. A name that the summary lacks or that is null does not
/// hold.
[[nodiscard]] std::vector<std::string> failed_expectations(const scene::Scene& scene, const Json& summary);

}  // namespace palpate::report
