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

Served serve_sheet() {
    scene::Scene scene = sheets::skin(0.4e6);
    scene.skin.foundation_n_per_m3 = 2e7;
    Served s{scene::build(scene, sheets::flat(0.05)), nullptr, nullptr};
    s.field = std::make_unique<table::StiffnessField>(*s.world->surface, s.world->material);
    s.server = std::make_unique<table::Server>(*s.world, *s.field, table::build_options(*s.world));
    return s;
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
