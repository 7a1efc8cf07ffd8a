#include "host/table/server.hpp"

#include <catch2/catch.hpp>

#include "tests/host/sheets.hpp"

using namespace palpate;

namespace {

struct Served {
    std::unique_ptr<scene::World> world;
    std::unique_ptr<table::StiffnessField> field;
    std::unique_ptr<table::Server> server;
};

Served serve(const cloud::Cloud& cloud, std::uint32_t table_nodes = 0) {
    scene::Scene scene = sheets::skin(0.4e6);
    scene.skin.foundation_n_per_m3 = 2e7;
    scene.solver.table_nodes = table_nodes;
    Served s{scene::build(scene, cloud), nullptr, nullptr};
    s.field = std::make_unique<table::StiffnessField>(*s.world->surface, s.world->material);
    s.server = std::make_unique<table::Server>(*s.world, *s.field, table::build_options(*s.world));
    return s;
}

Served serve_sheet(std::uint32_t table_nodes = 0) {
    return serve(sheets::flat(0.05), table_nodes);
}

pal_tick tool(float x, float z, pal_state state = PAL_STATE_ENABLED) {
    pal_tick tick{};
    tick.state = static_cast<std::uint32_t>(state);
    tick.position_m[0] = x;
    tick.position_m[2] = z;
    return tick;
}

}  // namespace

TEST_CASE("no table before the loop is enabled, nor while the tool has not been clear of the object") {
    const Served s = serve_sheet();
    CHECK_FALSE(s.server->update(tool(0, 0.01F, PAL_STATE_HOMING)));
    CHECK_FALSE(s.server->update(tool(0, 0.01F, PAL_STATE_RAMP)));
    CHECK_FALSE(s.server->update(tool(0, 0.001F)));  // inside the tool's radius: it has never been clear
    CHECK_FALSE(s.server->update(tool(0, -0.02F)));  // behind the skin
    CHECK(s.server->update(tool(0, 0.01F)));
    CHECK(s.server->update(tool(0, 0.001F)));  // pressed in 2 mm
}

TEST_CASE("after a stop tables go on coming while the loop is held and while its ramp runs") {
    const Served s = serve_sheet();
    REQUIRE(s.server->update(tool(0, 0.004F)));
    CHECK(s.server->update(tool(0.002F, 0.002F, PAL_STATE_FAULT)));
    CHECK(s.server->update(tool(0.004F, 0.002F, PAL_STATE_RAMP)));
    CHECK(s.server->update(tool(0.006F, 0.002F, PAL_STATE_PAUSED)));
}

TEST_CASE("a new table comes when the tool has moved on, and only then") {
    const Served s = serve_sheet();
    CHECK(s.server->update(tool(0, 0.004F)));
    CHECK_FALSE(s.server->update(tool(0.0005F, 0.004F)));
    CHECK(s.server->update(tool(0.0015F, 0.0038F)));
    CHECK_FALSE(s.server->update(tool(0.0015F, 0.0029F)));  // 0.1 mm in
    CHECK(s.server->update(tool(0.0015F, 0.0024F)));        // 0.6 mm in
    CHECK(s.server->n_built() == 3);
}

TEST_CASE("the contact is known while the tool touches") {
    const Served s = serve_sheet();
    static_cast<void>(s.server->update(tool(0, 0.004F)));
    static_cast<void>(s.server->update(tool(0, 0.002F)));
    static_cast<void>(s.server->update(tool(0, 0.001F)));
    REQUIRE(s.server->contact());
    CHECK(s.server->contact()->normal.z() > 0.95);
}

TEST_CASE("a table is 9.6 spacings of the scan wide, whatever its node count") {
    for (const std::uint32_t n : {0U, 5U, 7U, 17U, 33U, 65U}) {
        const Served s = serve_sheet(n);
        const table::BuildOptions options = table::build_options(*s.world);
        CHECK(options.spacing_m * (options.n_nodes - 1) == Approx(9.6e-3));
        CHECK((n == 0 || options.n_nodes == n));
    }
}

TEST_CASE("with few nodes too a new table is due long before the tool leaves the last one") {
    const std::uint32_t n = GENERATE(as<std::uint32_t>{}, 5, 7, 17, 65);
    const Served s = serve_sheet(n);
    const auto first = s.server->update(tool(0, 0.004F));
    REQUIRE(first);
    const float due = std::min(1.2e-3F, first->valid_radius_m / 4.0F);
    CAPTURE(n, due);
    CHECK_FALSE(s.server->update(tool(0.98F * due, 0.004F)));
    CHECK(s.server->update(tool(1.02F * due, 0.004F)));
}

TEST_CASE("pressed through a thin double wall the table stays the front wall's") {
    cloud::Cloud walls = sheets::flat(0.05);
    const std::size_t n = walls.points_m.size();
    for (std::size_t i = 0; i < n; ++i)
        walls.points_m.push_back(walls.points_m[i] - Eigen::Vector3d(0, 0, 3e-3));
    for (std::size_t i = 0; i < 2 * n; ++i) walls.normals.emplace_back(0, 0, i < n ? 1.0 : -1.0);
    const Served s = serve(walls);
    REQUIRE(s.server->update(tool(0, 0.004F)));  // 1 mm clear of the skin
    for (int i = 1; i <= 48; ++i)
        static_cast<void>(s.server->update(tool(0, 0.003F - 1e-4F * static_cast<float>(i))));
    const auto last = s.server->update(tool(0.002F, -0.0018F));  // 4.8 mm deep: the back wall is nearer
    REQUIRE(last);
    CHECK(last->axes[8] > 0.99F);
    CHECK(last->p0_m[2] == Approx(0.003).margin(1e-4));
}
