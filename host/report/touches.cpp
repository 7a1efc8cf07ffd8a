#include "host/report/touches.hpp"

#include "host/report/ticks.hpp"

namespace palpate::report {

std::vector<Touch> touches(const scene::World& world, std::span<const pal_tick> ticks) {
    const contact::Surface surface = world.another_surface();
    std::vector<Touch> found(ticks.size());
    std::optional<cloud::Index> seed;
    if (!world.path.empty()) seed = world.path.front().foot.nearest;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        if (ticks[i].path_tick == 0) continue;
        const Eigen::Vector3d tool_m = world.on_object(place_of(ticks[i]));
        Touch& touch = found[i];
        touch.foot = surface.foot(tool_m, seed ? *seed : world.tree->nearest(tool_m));
        if (!touch.foot) continue;
        seed = touch.foot->nearest;
        touch.depth_m = world.scene.touch.tool_radius_m - touch.foot->distance_m;
    }
    return found;
}

}  // namespace palpate::report
