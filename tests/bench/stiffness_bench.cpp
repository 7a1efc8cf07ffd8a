// The bunny scene: from the scan to the stiffness of a point, and to a table.
#include <iostream>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "host/scene/world.hpp"
#include "host/table/server.hpp"
#include "tests/bench/measure.hpp"

namespace palpate::bench {
namespace {

constexpr const char* SCENE = "sim/scenes/bunny.toml";  // from the project's root, where run.sh starts us
constexpr double DEPTH_M = 3e-3;
constexpr std::size_t N_PLACES = 12;
constexpr Eigen::Index FINE_NODES = 33;

/// The scene, places along its path, and a stiffness field that knows all that they need.
struct Bunny {
    struct Place {
        contact::Foot skin;      ///< of a place on the skin
        Eigen::Vector3d tool_m;  ///< tool centre that presses there
        contact::Foot foot;      ///< of the tool centre
    };
    std::unique_ptr<scene::World> world = scene::build(scene::load(SCENE));
    table::BuildOptions options = table::build_options(*world);
    table::StiffnessField field{*world->surface, world->material};
    std::vector<Place> places;

    Bunny() {
        const std::size_t n_path = world->path.size();
        for (std::size_t k = 0; k < N_PLACES; ++k) {
            const contact::Foot& skin = world->path[(n_path - 1) / 8 + k * (n_path / 2) / N_PLACES].foot;
            const Eigen::Vector3d tool_m = skin.point_m + (options.tool_radius_m - DEPTH_M) * skin.normal;
            const auto foot = world->surface->foot(tool_m, skin.nearest);
            if (!foot) throw std::runtime_error("bunny: no skin under a place of the path");
            places.push_back({skin, tool_m, *foot});
            require_table(*world->surface, field, places.back());
        }
    }
    void require_table(const contact::Surface& surface, const table::StiffnessField& from,
                       const Place& place) const {
        if (!table::build(surface, from, options, place.tool_m, place.foot, 1))
            throw std::runtime_error("bunny: no table at a place of the path");
    }
    [[nodiscard]] const Place& place(std::size_t k) const { return places[k % places.size()]; }
};

const Bunny& bunny() {
    static const Bunny scene;
    return scene;
}

void cut(benchmark::State& state) {
    const scene::World& world = *bunny().world;
    measure(
        state, Clock::cpu, 1, [](std::size_t) {},
        [&](std::size_t k) {
            const chart::Patch patch =
                chart::cut_patch(*world.surface, bunny().place(k).skin, world.material, FINE_NODES);
            benchmark::DoNotOptimize(patch.covered);
        });
}

void solve(benchmark::State& state) {
    const scene::World& world = *bunny().world;
    std::vector<plate::Problem> problems;
    for (const Bunny::Place& place : bunny().places) {
        problems.push_back(chart::cut_patch(*world.surface, place.skin, world.material, FINE_NODES).problem);
    }
    measure(
        state, Clock::cpu, 1, [](std::size_t) {},
        [&](std::size_t k) {
            benchmark::DoNotOptimize(plate::extrapolated_centre_compliance(problems[k % problems.size()]));
        });
}

/// The mean too: where the scan is uneven or the lump begins, finer grids are needed.
void point(benchmark::State& state, bool to_tolerance) {
    const scene::World& world = *bunny().world;
    const std::vector<double> times_s = measure(
        state, Clock::cpu, 1, [](std::size_t) {},
        [&](std::size_t k) {
            const contact::Foot& skin = bunny().place(k).skin;
            benchmark::DoNotOptimize(
                to_tolerance ? chart::point_stiffness(*world.surface, skin, world.material)
                             : chart::point_stiffness(*world.surface, skin, world.material, FINE_NODES));
        });
    const double sum_s = std::accumulate(times_s.begin(), times_s.end(), 0.0);
    state.counters["mean_s"] = sum_s / static_cast<double>(times_s.size());
}

void warm_table(benchmark::State& state) {
    const Bunny& b = bunny();
    measure(
        state, Clock::cpu, 1, [](std::size_t) {},
        [&](std::size_t k) { b.require_table(*b.world->surface, b.field, b.place(k)); });
    state.counters["points_solved"] = 0.0;
}

/// Nothing is known of the object but the scan: neighbourhoods and stiffnesses are all made anew.
void cold_table(benchmark::State& state) {
    const Bunny& b = bunny();
    std::unique_ptr<contact::Surface> surface;
    std::unique_ptr<table::StiffnessField> field;
    std::vector<double> n_solved;
    const auto count = [&] {
        if (field) n_solved.push_back(static_cast<double>(field->n_solved()));
    };
    measure(
        state, Clock::cpu, 1,
        [&](std::size_t) {
            count();
            field.reset();
            surface = std::make_unique<contact::Surface>(b.world->another_surface());
            field = std::make_unique<table::StiffnessField>(*surface, b.world->material);
        },
        [&](std::size_t k) { b.require_table(*surface, *field, b.place(k)); });
    count();
    state.counters["points_solved"] = quantile(n_solved, 0.5);
}

}  // namespace

void register_stiffness() {
    try {
        static_cast<void>(scene::points_file(scene::load(SCENE)));
    } catch (const scene::Error& error) {
        std::cerr << "not measured, the bunny is not here: " << error.what() << '\n';
        return;
    }
    const int rounds = 10 * static_cast<int>(N_PLACES);
    add("stiffness/cut the patch, 33 nodes", rounds, cut);
    add("stiffness/solve the plate, 17 + 33 nodes", rounds, solve);
    add("stiffness/one point, 17 + 33 nodes", rounds, [](benchmark::State& state) { point(state, false); });
    add("stiffness/one point, to the scene's tolerance", rounds,
        [](benchmark::State& state) { point(state, true); });
    add("table/warm: all stiffnesses known", 5 * static_cast<int>(N_PLACES), warm_table);
    add("table/cold: none known", 3, cold_table);
}

}  // namespace palpate::bench
