/// Builds the local stiffness-response table around a contact.
#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>

#include "common/table.h"
#include "host/contact/surface.hpp"
#include "host/table/stiffness_field.hpp"

namespace palpate::table {

struct BuildOptions {
    pal_law law = PAL_LAW_POTENTIAL;
    double tool_radius_m = 0.003;
    double thickness_m = 0.0015;
    double spacing_m = 0.0006;     ///< between nodes
    std::uint32_t n_nodes = 17;    ///< odd
    double fit_radius_m = 0.0077;  ///< of the sphere's weights; several spacings of the scan
    std::uint64_t source_hash = 0;
    double position_scale = 1.0;  ///< object metres per hand metre
    double force_scale = 1.0;     ///< newtons in the hand per newton on the object
};

/// The table for a tool centre at `tool_m` above the foot `foot`, for the tick `made_for_tick`; not sealed,
/// id 0. Node (u, v): the ray from the fitted sphere's centre meets the skin raised by the tool's radius at
/// height s; K is chosen so that K f^2/2 equals k d^2/2 at the tool's present depth, with the true
/// perpendicular depth d and the stiffness k at its foot (MATH.md, matched depth). nullptr when the skin
/// there is not good enough for a table. `tool_m` and `foot` in object metres; the table speaks of the
/// hand's: F = force_scale F_object(position_scale x), again the gradient of a potential.
[[nodiscard]] std::unique_ptr<pal_table> build(const contact::Surface& surface, const StiffnessField& field,
                                               const BuildOptions& options, const Eigen::Vector3d& tool_m,
                                               const contact::Foot& foot, std::uint32_t made_for_tick);

}  // namespace palpate::table
