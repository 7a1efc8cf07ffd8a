/// The small sheet as scenes for keys: built, or felt in a short virtual run.
#pragma once
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "host/app/run.hpp"
#include "host/report/figures.hpp"
#include "tests/host/app/sheet.hpp"

namespace palpate::test {

using Eigen::Vector3d;
using Set = std::vector<std::string>;

/// Pressed at (0, 0) in 0.2 s, held, left: few points to bake.
inline const std::string QUICK =
    "hand.path=[{ t_s = 0.0, at_m = [0.0, 0.0, 0.0], depth_m = -0.002 }, "
    "{ t_s = 0.2, at_m = [0.0, 0.0, 0.0], depth_m = 0.003 }, "
    "{ t_s = 0.4, at_m = [0.0, 0.0, 0.0], depth_m = 0.003 }, "
    "{ t_s = 0.6, at_m = [0.0, 0.0, 0.0], depth_m = -0.002 }]";
inline const std::string SPRINGS = "skin.foundation_n_per_m3=2e7", BARE = "skin.foundation_n_per_m3=0";

inline std::unique_ptr<scene::World> world_of(const Set& set) {
    return scene::build(sheet_scene(PAL_TEST_FOLDER, set));
}

/// The flat sheet bent to the top of a ball of 30 mm.
inline std::unique_ptr<scene::World> cap_of(const Set& set) {
    scene::Scene scene = sheet_scene(PAL_TEST_FOLDER, set);
    cloud::Cloud cloud = cloud::read(scene::points_file(scene));
    for (Vector3d& p : cloud.points_m) p.z() = std::sqrt(0.03 * 0.03 - p.squaredNorm()) - 0.03;
    return scene::build(scene, std::move(cloud));
}

inline double k_n_per_m(const scene::World& world) {
    const Vector3d middle = world.pose(Vector3d::Zero());
    const auto foot = world.surface->foot(middle, world.tree->nearest(middle));
    REQUIRE(foot);
    return chart::point_stiffness(*world.surface, *foot, world.material).n_per_m;
}

struct Felt {
    app::Prepared prepared;
    app::RunResult run;

    [[nodiscard]] double force_max_n() const {
        double most = 0.0;
        for (const pal_tick& tick : run.ticks)
            most = std::max(most, Eigen::Map<const Eigen::Vector3f>(tick.force_n).cast<double>().norm());
        return most;
    }
    [[nodiscard]] std::size_t n_in(pal_state state) const {
        std::size_t n = 0;
        for (const pal_tick& tick : run.ticks) n += tick.state == state ? 1U : 0U;
        return n;
    }
    /// The first tick that used a table.
    [[nodiscard]] std::uint32_t first_use() const {
        for (const pal_tick& tick : run.ticks) {
            if (tick.table_id != 0) return tick.tick;
        }
        FAIL("no table was used");
        return 0;
    }
    /// The tool's lowest place, hand metres.
    [[nodiscard]] double lowest_m() const {
        float lowest = 1.0F;
        for (const pal_tick& tick : run.ticks) {
            if (tick.path_tick > 0) lowest = std::min(lowest, tick.truth_position_m[2]);
        }
        return static_cast<double>(lowest);
    }
    /// Median over contact ticks with a table.
    [[nodiscard]] double median(const std::function<double(const pal_tick&)>& of) const {
        std::vector<double> values;
        for (const pal_tick& tick : run.ticks) {
            if (tick.k_n_per_m > 0.0F && tick.depth_m > 5e-4F) values.push_back(of(tick));
        }
        REQUIRE(values.size() > 50);
        std::sort(values.begin(), values.end());
        return values[values.size() / 2];
    }
};

inline Felt feel(const Set& set, const app::Operator& rig = {}) {
    app::Progress quiet(true);
    Felt felt{app::prepare(world_of(set), quiet), {}};
    felt.run = app::run_virtual(felt.prepared, rig, quiet);
    CHECK(felt.run.failure.empty());
    return felt;
}

/// The quick scene as it is, felt once for all comparisons.
inline const Felt& plain() {
    static const Felt felt = feel({QUICK});
    return felt;
}

inline void same(const Vector3d& a, const Vector3d& b) {
    CAPTURE(a.transpose(), b.transpose());
    CHECK((a - b).norm() < 1e-7);  // the file is in single precision
}

// One row for each key: what changes when it does.

/// The sheet's point at (7, -3, 0) mm, where the scene's axes and unit put it.
Vector3d landmark(const Set& set) {
    const auto world = world_of(set);
    return world->cloud.points_m[41 * 17 + 27];
}

}  // namespace palpate::test
