/// Where the tool truly touched the scan, tick by tick.
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "common/tick.h"
#include "host/contact/surface.hpp"
#include "host/scene/world.hpp"

namespace palpate::report {

/// From places and points alone, whatever tables the loop had: a tick whose table was missing, left or stale
/// is a touch like any other.
struct Touch {
    std::optional<contact::Foot> foot;  ///< of the tool's centre, once the path has begun
    double depth_m = 0.0;               ///< of the tool's lowest point below the skin, object metres
    [[nodiscard]] bool contact() const { return foot.has_value() && depth_m > 0.0; }
};

/// One for each tick, at the true place where a simulated device tells it and at the sensed one otherwise.
/// The foot starts on the path's own sheet and stays on the sheet of the tick before. About 50 us a tick.
[[nodiscard]] std::vector<Touch> touches(const scene::World& world, std::span<const pal_tick> ticks);

}  // namespace palpate::report
