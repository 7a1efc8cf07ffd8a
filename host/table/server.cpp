#include "host/table/server.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::table {
namespace {

constexpr std::uint32_t NODES = 17;
constexpr double SPACING_IN_SCAN_SPACINGS = 0.6;
constexpr double MOVED_SHARE = 0.25;  // of the table's half width
constexpr double DEEPER_M = 0.5e-3;

}  // namespace

BuildOptions build_options(const scene::World& world) {
    const scene::Scene& s = world.scene;
    return {.law = s.touch.law == scene::Law::potential ? PAL_LAW_POTENTIAL : PAL_LAW_NORMAL,
            .tool_radius_m = s.touch.tool_radius_m,
            .thickness_m = s.skin.thickness_m,
            .spacing_m = SPACING_IN_SCAN_SPACINGS * world.spacing_m,
            .n_nodes = s.solver.table_nodes != 0 ? s.solver.table_nodes : NODES,
            .source_hash = world.source_hash};
}

std::vector<cloud::Index> reachable_points(const scene::World& world, const StiffnessField& field,
                                           const BuildOptions& options) {
    const double half_m = 0.5 * static_cast<double>(options.n_nodes - 1) * options.spacing_m;
    std::vector<bool> wanted(world.cloud.points_m.size(), false);
    const scene::Target* last = nullptr;
    for (const scene::Target& target : world.path) {
        if (last != nullptr && (target.foot.point_m - last->foot.point_m).norm() < world.spacing_m) continue;
        for (const cloud::Index point : field.needed_for(target.foot, 1.5 * half_m)) wanted[point] = true;
        last = &target;
    }
    std::vector<cloud::Index> points;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        if (wanted[i]) points.push_back(static_cast<cloud::Index>(i));
    }
    return points;
}

Server::Server(const scene::World& world, const StiffnessField& field, const BuildOptions& options)
    : world_(&world),
      field_(&field),
      options_(options),
      proxy_(world.cloud, *world.tree, *world.graph, options.tool_radius_m) {}

bool Server::moved_on(const Eigen::Vector3d& tool_m, const contact::Foot& foot) const {
    if (!given_) return true;
    const double half_m = 0.5 * static_cast<double>(options_.n_nodes - 1) * options_.spacing_m;
    const double depth_m = options_.tool_radius_m - foot.distance_m;
    const double deeper_m = std::max(depth_m, 0.0) - std::max(last_depth_m_, 0.0);
    return (tool_m - last_tool_m_).norm() > MOVED_SHARE * half_m || std::abs(deeper_m) > DEEPER_M;
}

std::unique_ptr<pal_table> Server::update(const pal_tick& record) {
    if (record.state != PAL_STATE_ENABLED) return nullptr;
    const Eigen::Vector3d tool_m(record.position_m[0], record.position_m[1], record.position_m[2]);
    if (engaged_) contact_ = proxy_.follow(tool_m);
    const cloud::Index seed = contact_ ? contact_->nearest : world_->tree->nearest(tool_m);
    const auto foot = world_->surface->foot(tool_m, seed);
    engaged_ = engaged_ || (foot && foot->distance_m > options_.tool_radius_m);
    if (!engaged_) return nullptr;
    if (foot && moved_on(tool_m, *foot)) {
        auto table = build(*world_->surface, *field_, options_, tool_m, *foot, record.tick);
        if (table) {
            ++n_built_;
            given_ = true;
            last_tool_m_ = tool_m;
            last_depth_m_ = options_.tool_radius_m - foot->distance_m;
            return table;
        }
        ++n_refused_;
    }
    return nullptr;
}

}  // namespace palpate::table
