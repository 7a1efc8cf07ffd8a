#include "host/table/server.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::table {
namespace {

// In spacings of the scan: half width of a table, radius of its sphere's fit, between its nodes for
// NODE_TOLERANCE.
constexpr double HALF_WIDTH = 4.8, FIT_RADIUS = 1.6 * HALF_WIDTH, NODE_SPACING = 0.6;
constexpr double NODE_TOLERANCE = 1e-3;  // of k; the spline is of fourth order
// A new table is due after so many spacings of the scan, or this share of the last one's valid radius.
constexpr double MOVED = 1.2, MOVED_IN_TABLE = 0.25;
constexpr double DEEPER_M = 0.5e-3;

/// Nodes along a side that keep the spline's share of the error in step with the tolerance.
std::uint32_t nodes_for(double tolerance) {
    const double finer = std::sqrt(std::sqrt(std::max(1.0, NODE_TOLERANCE / tolerance)));
    const double half = std::ceil(HALF_WIDTH / NODE_SPACING * finer - 1e-9);
    return std::min(2U * static_cast<std::uint32_t>(half) + 1U,
                    static_cast<std::uint32_t>(PAL_TABLE_NODES_MAX));
}

}  // namespace

BuildOptions build_options(const scene::World& world) {
    const scene::Scene& s = world.scene;
    const std::uint32_t n_nodes =
        s.solver.table_nodes != 0 ? s.solver.table_nodes : nodes_for(s.solver.tolerance);
    const double spacing = 2.0 * HALF_WIDTH / static_cast<double>(n_nodes - 1);
    return {.law = s.touch.law == scene::Law::potential ? PAL_LAW_POTENTIAL : PAL_LAW_NORMAL,
            .tool_radius_m = s.touch.tool_radius_m,
            .thickness_m = s.skin.thickness_m,
            .spacing_m = spacing * world.spacing_m,
            .n_nodes = n_nodes,
            .fit_radius_m = FIT_RADIUS * world.spacing_m,
            .source_hash = world.source_hash,
            .position_scale = s.placement.position_scale,
            .force_scale = s.placement.force_scale};
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
    const double depth_m = options_.tool_radius_m - foot.distance_m;
    const double deeper_m = std::max(depth_m, 0.0) - std::max(last_depth_m_, 0.0);
    return (tool_m - last_tool_m_).norm() > last_serves_m_ || std::abs(deeper_m) > DEEPER_M;
}

std::optional<Server::Place> Server::track(const pal_tick& record) {
    if (!engaged_ && record.state != PAL_STATE_ENABLED) return std::nullopt;
    const Eigen::Vector3d tool_m =
        world_->on_object(Eigen::Map<const Eigen::Vector3f>(record.position_m).cast<double>());
    if (engaged_) contact_ = proxy_.follow(tool_m);
    const cloud::Index seed = contact_ ? contact_->nearest : world_->tree->nearest(tool_m);
    const auto foot = world_->surface->foot(tool_m, seed);
    engaged_ = engaged_ || (foot && foot->distance_m > options_.tool_radius_m);
    if (!engaged_ || !foot) return std::nullopt;
    return Place{tool_m, *foot};
}

std::unique_ptr<pal_table> Server::update(const pal_tick& record) {
    const auto place = track(record);
    if (!place || !moved_on(place->tool_m, place->foot)) return nullptr;
    auto table = build(*world_->surface, *field_, options_, place->tool_m, place->foot, record.tick);
    if (!table) {
        ++n_refused_;
        return nullptr;
    }
    ++n_built_;
    given_ = true;
    last_tool_m_ = place->tool_m;
    const double valid_m = options_.position_scale * static_cast<double>(table->valid_radius_m);
    last_serves_m_ = std::min(MOVED * world_->spacing_m, MOVED_IN_TABLE * valid_m);
    last_depth_m_ = options_.tool_radius_m - place->foot.distance_m;
    return table;
}

}  // namespace palpate::table
