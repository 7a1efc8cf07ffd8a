/// Flat sheets whose stiffness has a closed form, as scenes.
#pragma once
#include <cmath>

#include "host/scene/world.hpp"
#include "host/table/server.hpp"
#include "sim/stand/stand.h"

namespace palpate::sheets {

/// A square grid of points in z = 0, 1 mm apart, facing the user.
inline cloud::Cloud flat(double side_m, double spacing_m = 1e-3) {
    cloud::Cloud cloud;
    const auto n = static_cast<int>(std::lround(side_m / spacing_m)) / 2;
    for (int i = -n; i <= n; ++i) {
        for (int j = -n; j <= n; ++j) cloud.points_m.emplace_back(i * spacing_m, j * spacing_m, 0.0);
    }
    return cloud;
}

inline scene::Scene skin(double young_pa) {
    scene::Scene scene;
    scene.file = "sheet";
    scene.object.length_unit = "m";
    scene.skin.young_pa = young_pa;
    scene.skin.thickness_m = 0.0015;
    return scene;
}

inline double rigidity_n_m(const scene::Scene& scene, double young_pa) {
    const double h = scene.skin.thickness_m, nu = scene.skin.poisson;
    return young_pa * h * h * h / (12.0 * (1.0 - nu * nu));
}

/// A table for a tool whose lowest point is `depth_m` below the skin next to `at_m`.
inline std::unique_ptr<pal_table> table_at(const scene::World& world, const table::StiffnessField& field,
                                           const table::BuildOptions& options, const Eigen::Vector3d& at_m,
                                           double depth_m) {
    const auto foot = world.surface->foot(at_m, world.tree->nearest(at_m));
    if (!foot) return nullptr;
    const Eigen::Vector3d tool = foot->point_m + (options.tool_radius_m - depth_m) * foot->normal;
    const auto there = world.surface->foot(tool, foot->nearest);
    auto table = there ? table::build(*world.surface, field, options, tool, *there, 1) : nullptr;
    if (table) {
        table->id = 1;
        pal_table_seal(table.get());
    }
    return table;
}

/// The static path of a loop and a device with nobody holding it.
inline pal_stand_config stand() {
    pal_stand_config config{};
    config.falcon = pal_falcon_sim_config_default();
    config.force_max_n = 8.0F;
    config.ramp_ticks = 10;
    return config;
}

}  // namespace palpate::sheets
