/// A run as frames for the viewer.
#pragma once
#include <memory>
#include <vector>

#include "common/tick.h"
#include "host/scene/world.hpp"
#include "host/table/stiffness_field.hpp"
#include "host/view/frame.hpp"

namespace palpate::app {

/// Frames by scene time (0: the path's begin). Borrows world and field; the dip under the tool is solved when
/// a frame is asked for (about 5 ms).
[[nodiscard]] view::Source view_source(const scene::World& world, const table::StiffnessField& field,
                                       std::vector<pal_tick> ticks);

/// Scene time of the largest force in contact, s; 0 without contact.
[[nodiscard]] double peak_time_s(const std::vector<pal_tick>& ticks);

}  // namespace palpate::app
