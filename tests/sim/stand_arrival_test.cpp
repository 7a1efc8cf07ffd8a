// From a table's publication to its first use, to the tick.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <vector>

#include "common/table_ring.h"
#include "firmware/core/step.h"
#include "sim/stand/stand.h"

namespace {

constexpr std::uint32_t FADE_TICKS = 16;  // pal_loop_config_default

/// A level sheet of 800 N/m over the whole workspace.
void fill_flat(pal_table& table, std::uint64_t id, std::uint32_t n_nodes) {
    std::memset(&table, 0, sizeof table);
    table.id = id;
    table.n_nodes = n_nodes;
    table.spacing_m = 0.096F / static_cast<float>(n_nodes - 1);
    table.valid_radius_m = 0.047F;
    table.depth_scale_m = 0.001F;
    for (std::size_t i = 0; i < 3; ++i) table.axes[4 * i] = 1.0F;
    const std::size_t plane = std::size_t{n_nodes + 2} * (n_nodes + 2);
    std::fill(table.coef + plane, table.coef + 2 * plane, 800.0F);
    pal_table_seal(&table);
}

/// Ticks that the check of a table takes: three passes over its coefficients, 35 words of its header, 8192
/// words a tick (docs/PROTOCOL.md 2).
std::uint32_t check_ticks(std::uint32_t n_nodes) {
    return (9 * (n_nodes + 2) * (n_nodes + 2) + 35 + 8191) / 8192;
}

/// A hand that presses into the sheet, with a table in use and no fade.
class Press {
public:
    Press() {
        pal_link_init(link_.get(), 1);
        link_->host.enable = 1;
        pal_stand_config config{};
        config.falcon = pal_falcon_sim_config_default();
        config.force_max_n = 8;
        config.ramp_ticks = 100;
        config.hand.mass_kg = 0.15;
        config.hand.stiffness_n_per_m = 500;
        config.hand.damping_n_s_per_m = 8;
        config.hand.weight_n = config.falcon.mass_kg * config.falcon.gravity_m_per_s2;
        config.hand.home_in_m[2] = PAL_HAND_HOME_IN_Z_M;
        config.hand.wait_ticks = 200;
        config.hand.path = path_.data();
        config.hand.n_points = static_cast<std::uint32_t>(path_.size());
        stand_.reset(pal_stand_new(&config, link_.get()));
        REQUIRE(stand_ != nullptr);
        for (int i = 0; i < 1600; ++i) {
            if (i % 50 == 0) publish(17);
            tick();
        }
        REQUIRE(record_.state == PAL_STATE_ENABLED);
        REQUIRE(record_.depth_m > 0.003F);
    }

    std::uint64_t publish(std::uint32_t n_nodes) {
        fill_flat(*pal_table_ring_back(&link_->tables), ++id_, n_nodes);
        REQUIRE(pal_table_ring_publish(&link_->tables));
        return id_;
    }
    const pal_tick& tick() {
        pal_stand_tick(stand_.get(), &record_);
        return record_;
    }
    /// Until no table is being checked and no fade runs.
    void settle() {
        for (std::uint32_t i = 0; i < 2 * FADE_TICKS; ++i) tick();
        REQUIRE(record_.before_id == 0);
    }
    /// Ticks without `id` before the first that uses it; each of them is a good one with the table before.
    std::uint32_t ticks_until_used(std::uint64_t id) {
        for (std::uint32_t n = 0; n < 100; ++n) {
            if (tick().table_id == id) return n;
            if (record_.faults != 0 || !(record_.force_n[2] > 0.5F)) FAIL("tick " << record_.tick);
        }
        FAIL("table " << id << " is not used");
        return 0;
    }

private:
    struct Free {
        void operator()(pal_stand* stand) const { pal_stand_free(stand); }
    };
    std::unique_ptr<pal_link> link_ = std::make_unique<pal_link>();
    std::vector<pal_hand_point> path_{{0.0, {0, 0, 0.13}}, {0.5, {0, 0, 0.105}}, {900, {0, 0, 0.105}}};
    std::unique_ptr<pal_stand, Free> stand_;
    pal_tick record_{};
    std::uint64_t id_ = 0;
};

}  // namespace

TEST_CASE("a table is used first in the tick of its check's last slice, whatever its size") {
    CHECK(check_ticks(17) == 1);
    CHECK(check_ticks(27) == 1);
    CHECK(check_ticks(29) == 2);
    CHECK(check_ticks(65) == 5);
    Press press;
    for (std::uint32_t n_nodes = 5; n_nodes <= 65; n_nodes += 2) {
        INFO(n_nodes << " nodes");
        press.settle();
        const std::uint64_t id = press.publish(n_nodes);
        CHECK(press.ticks_until_used(id) == check_ticks(n_nodes) - 1);
    }
}

TEST_CASE("a table that comes in a fade waits for its end, whenever in it and of whatever size") {
    Press press;
    std::uint32_t longest_17 = 0;
    for (std::uint32_t n_nodes = 5; n_nodes <= 65; n_nodes += 2) {
        for (std::uint32_t into = 0; into <= FADE_TICKS + 2; ++into) {
            INFO(n_nodes << " nodes, published when " << into << " ticks of the fade are over");
            press.settle();
            const std::uint64_t before = press.publish(17);
            for (std::uint32_t i = 0; i < into; ++i) REQUIRE(press.tick().table_id == before);
            const std::uint64_t id = press.publish(n_nodes);
            if (into == 0) {  // the table before was not taken yet: the newest is
                CHECK(press.ticks_until_used(id) == check_ticks(n_nodes) - 1);
                continue;
            }
            const std::uint32_t left = into < FADE_TICKS ? FADE_TICKS - into : 0;
            const std::uint32_t n = press.ticks_until_used(id);
            CHECK(n == left + check_ticks(n_nodes) - 1);
            if (n_nodes == 17) longest_17 = std::max(longest_17, n);
        }
    }
    CHECK(longest_17 == 15);
}

TEST_CASE("a table that comes while a larger one is checked waits for that check and its fade") {
    Press press;
    std::uint32_t longest = 0;
    for (std::uint32_t larger = 29; larger <= 65; larger += 4) {
        for (std::uint32_t into = 1; into < check_ticks(larger); ++into) {
            for (const std::uint32_t n_nodes : {5U, 17U, 29U, 65U}) {
                INFO(n_nodes << " nodes, published after slice " << into << " of " << larger << " nodes");
                press.settle();
                const std::uint64_t before = press.publish(larger);
                for (std::uint32_t i = 0; i < into; ++i) REQUIRE(press.tick().table_id != before);
                const std::uint64_t id = press.publish(n_nodes);
                const std::uint32_t rest = press.ticks_until_used(before);
                CHECK(rest == check_ticks(larger) - into - 1);
                // The tick of its first use is the first of its fade.
                const std::uint32_t n = press.ticks_until_used(id);
                CHECK(n == FADE_TICKS - 1 + check_ticks(n_nodes) - 1);
                longest = std::max(longest, rest + 1 + n);
            }
        }
    }
    CHECK(longest == 23);
}

TEST_CASE("of several tables that come in one fade the newest is used, and none in between") {
    Press press;
    press.settle();
    press.publish(17);
    press.tick();
    std::uint64_t newest = 0;
    for (std::uint32_t i = 1; i < FADE_TICKS; ++i) {
        newest = press.publish(i % 2 == 0 ? 17 : 65);
        CHECK(press.tick().table_id == newest - i);
    }
    CHECK(press.ticks_until_used(newest) == check_ticks(65) - 1);
}
