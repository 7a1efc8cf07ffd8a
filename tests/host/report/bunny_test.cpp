// The main job's figure, and that each thing that could be wrong in the table path alone would be seen in it.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>

#include "host/app/run.hpp"
#include "host/report/figures.hpp"

using namespace palpate;

namespace {

scene::Scene bunny(const std::vector<std::string>& set = {}) {
    return scene::load(std::filesystem::path(PALPATE_SOURCE) / "sim/scenes/bunny.toml", set);
}

struct Felt {
    app::RunResult run;
    std::vector<report::Touch> touches;
    report::ForceError error;
};

/// In the soak every tick of contact is checked; otherwise about 400 of them, and fewer where only a bound is
/// asked.
constexpr std::size_t FOR_A_BOUND = 100;
const bool soak = std::getenv("PALPATE_SOAK") != nullptr;

Felt feel(const app::Prepared& prepared, const std::function<void(pal_table&)>& change,
          std::size_t n_wanted = report::SAMPLE) {
    app::Progress quiet(true);
    Felt felt{app::run_virtual(prepared, {}, quiet, change), {}, {}};
    felt.touches = report::touches(*prepared.world, felt.run.ticks);
    const auto error =
        report::force_error(*prepared.world, felt.run.ticks, felt.touches, felt.run.tables,
                            app::loop_model(prepared), soak ? report::EVERY_TICK : n_wanted, [](double) {});
    REQUIRE(error);
    REQUIRE(error->n_without_reference == 0);
    felt.error = *error;
    return felt;
}

app::Prepared prepared_bunny() {
    app::Progress quiet(true);
    return app::prepare(scene::build(bunny()), quiet);
}

void move_along(pal_table& table, int axis, float by_m) {
    for (int i = 0; i < 3; ++i) table.p0_m[i] += by_m * table.axes[3 * axis + i];
}

}  // namespace

TEST_CASE("the bunny's ear is felt within 3 % of the plate, with the lump standing out") {
    const app::Prepared prepared = prepared_bunny();
    const Felt felt = feel(prepared, [](pal_table&) {});
    CHECK(felt.error.total.rms_relative <= 0.03);
    CHECK(felt.error.n_checked >= 400);
    CHECK((!soak || felt.error.n_checked == felt.error.n_contact));
    const report::StiffnessRatio ratio =
        report::stiffness_ratio(*prepared.world, felt.run.ticks, felt.touches);
    REQUIRE(ratio.value);
    CHECK(*ratio.value >= 1.5);
    for (std::size_t i = 0; i < felt.run.ticks.size(); ++i) {
        const pal_tick& tick = felt.run.ticks[i];
        // The scan says contact; the loop, which knows a table, may differ by its error of height.
        const bool deep = felt.touches[i].contact() && felt.touches[i].depth_m > 1e-4;
        if (deep || tick.depth_m > 0.0F) CHECK((tick.k_n_per_m >= 150.0F && tick.k_n_per_m <= 2000.0F));
        if (tick.path_tick < 1200 || tick.path_tick > 8800) continue;
        const Eigen::Vector3f force(tick.truth_force_n[0], tick.truth_force_n[1], tick.truth_force_n[2]);
        CHECK((force.norm() >= 1.0F && force.norm() <= 5.0F));
    }
}

TEST_CASE("an error in the table path alone pushes the figure over 3 %") {
    const app::Prepared prepared = prepared_bunny();
    const auto over = [&](const std::function<void(pal_table&)>& change) {
        return feel(prepared, change, FOR_A_BOUND).error.total.rms_relative;
    };
    SECTION("k five percent high") {
        CHECK(over([](pal_table& t) {
                  const std::size_t plane = (t.n_nodes + 2U) * (t.n_nodes + 2U);
                  for (std::size_t i = plane; i < 2 * plane; ++i) t.coef[i] *= 1.05F;
              }) > 0.03);
    }
    SECTION("the surface raised by 0.15 mm") {
        CHECK(over([](pal_table& t) { move_along(t, 2, 0.15e-3F); }) > 0.03);
    }
    SECTION("the normal tilted by 3 degrees") {
        CHECK(over([](pal_table& t) {
                  const float c = 0.99862953F, s = 0.05233596F;  // cos and sin of 3 degrees
                  for (int i = 0; i < 3; ++i) {
                      const float e1 = t.axes[i], e3 = t.axes[6 + i];
                      t.axes[i] = c * e1 - s * e3;
                      t.axes[6 + i] = s * e1 + c * e3;
                  }
              }) > 0.03);
    }
    SECTION("the table shifted by 1 mm") {
        CHECK(over([](pal_table& t) { move_along(t, 0, 1e-3F); }) > 0.03);
    }
}

TEST_CASE("a lump that is 2 mm off in the table path alone pushes the figure over 3 %") {
    app::Prepared prepared = prepared_bunny();
    scene::Scene moved = bunny();
    moved.changes.back().at_m[2] += 2e-3;  // along the stroke
    const auto world = scene::build(moved);
    prepared.field = std::make_unique<table::StiffnessField>(*world->surface, world->material);
    const report::ForceError error = feel(
                                         prepared, [](pal_table&) {}, FOR_A_BOUND)
                                         .error;
    CHECK(error.total.rms_relative > 0.03);
    CHECK(error.table.rms_relative > 0.03);  // and in the part that it belongs to
}
