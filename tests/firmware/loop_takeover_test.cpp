// The loop dies at any tick of a press; what palpate-loop --zero then sends takes the force away. In virtual
// time, against the simulated device, whose watchdog is as good as off.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "firmware/app/session.h"
#include "firmware/app/takeover.h"
#include "sim/falcon/falcon_sim.h"
#include "sim/hand/hand.h"
#include "tests/common/tables.hpp"

namespace {

using Packet = std::array<std::uint8_t, 16>;

constexpr std::uint32_t WATCHDOG_OFF_TICKS = 1000000;

/// A Falcon in a hand at the other end of a wire. Copied, it goes on from where it was.
struct Falcon {
    pal_falcon_sim sim{};
    pal_hand hand{};
    std::vector<pal_hand_point> path{{0.0, {0, 0, 0.13}}, {0.4, {0, 0, 0.108}}, {9.0, {0, 0, 0.108}}};
    bool answers = true;
    std::uint32_t n_busy = 0;  ///< requests that it does not take yet
    bool open = true;
    std::vector<Packet> requests;  ///< that it took

    void start() {
        auto config = pal_falcon_sim_config_default();
        config.watchdog_ticks = WATCHDOG_OFF_TICKS;
        REQUIRE(pal_falcon_sim_init(&sim, &config));
        pal_hand_config held{};
        held.mass_kg = 0.15;
        held.stiffness_n_per_m = 500;
        held.damping_n_s_per_m = 8;
        held.weight_n = config.mass_kg * config.gravity_m_per_s2;
        held.home_in_m[2] = PAL_HAND_HOME_IN_Z_M;
        held.wait_ticks = 100;
        held.path = path.data();
        held.n_points = static_cast<std::uint32_t>(path.size());
        pal_hand_init(&hand, &held);
    }
    /// 1 ms of its life.
    void live() {
        hand.config.path = path.data();  // its own after a copy
        pal_hand_advance(&hand, sim.homed == 7, sim.position_m);
        pal_falcon_sim_advance(&sim, pal_hand_push, &hand, hand.config.mass_kg);
        REQUIRE_FALSE(pal_falcon_sim_watchdog(&sim));
    }
    static pal_device_news collect(void* context, std::uint8_t reply[16]) {
        auto* falcon = static_cast<Falcon*>(context);
        if (!falcon->open) return PAL_DEVICE_GONE;
        if (!falcon->answers || !pal_falcon_sim_reply(&falcon->sim, reply)) return PAL_DEVICE_NONE;
        return PAL_DEVICE_FRESH;
    }
    static pal_device_news send(void* context, const std::uint8_t request[16]) {
        auto* falcon = static_cast<Falcon*>(context);
        if (!falcon->open) return PAL_DEVICE_GONE;
        if (falcon->n_busy > 0) {
            --falcon->n_busy;
            return PAL_DEVICE_NONE;
        }
        pal_falcon_sim_receive(&falcon->sim, request, 16);
        Packet& packet = falcon->requests.emplace_back();
        std::memcpy(packet.data(), request, 16);
        return PAL_DEVICE_FRESH;
    }
    pal_device device() { return {this, collect, send, nullptr}; }
    /// What the last request asks the motors for.
    [[nodiscard]] bool asked_for_force() const {
        const auto& newest = sim.queued_counts[0];
        return newest[0] != 0 || newest[1] != 0 || newest[2] != 0;
    }
    [[nodiscard]] bool motors_act() const {
        return sim.motor_counts[0] != 0 || sim.motor_counts[1] != 0 || sim.motor_counts[2] != 0;
    }
};

std::uint64_t no_time() {
    return 1;
}

/// What the loop was doing in its last tick.
std::string phase_of(const pal_tick& record, bool force) {
    if (record.state == PAL_STATE_HOMING) return "homing";
    if (!force) return "free";
    if (record.state == PAL_STATE_RAMP) return "ramp";
    return record.before_id != 0 && record.fade_weight < 1.0F ? "fade" : "contact";
}

/// A loop that presses, with a new table every 40 ticks.
class Press {
public:
    Falcon falcon;

    Press() {
        falcon.start();
        pal_link_init(link_.get(), 1);
        link_->host.enable = 1;
        pal_loop_config config = pal_loop_config_default();
        config.ramp_ticks = 300;
        const pal_device device = falcon.device();
        pal_session_begin(session_.get(), link_.get(), &device, &config, no_time);
    }
    /// One tick of the loop and of the device; what the loop was doing.
    std::string tick() {
        link_->host.heartbeat += 1;
        if (n_ticks_ % 40 == 0) publish();
        (void)pal_intake_check(&session_->intake);
        const pal_session_time now{1000000ULL * ++n_ticks_, 0, 0};
        REQUIRE(pal_session_tick(session_.get(), &now) == PAL_SESSION_RUNS);
        pal_tick record;
        REQUIRE(pal_state_ring_read(&link_->ticks, &reader_, &record));
        return phase_of(record, falcon.asked_for_force());
    }

private:
    void publish() {
        auto table = tables::make({}, 17, 0.0, ++id_);
        table->spacing_m = 0.006F;
        table->valid_radius_m = 0.047F;
        pal_table_seal(table.get());
        std::memcpy(pal_table_ring_back(&link_->tables), table.get(), table->n_bytes);
        pal_table_ring_publish(&link_->tables);
    }

    std::unique_ptr<pal_link> link_ = std::make_unique<pal_link>();
    std::unique_ptr<pal_session> session_ = std::make_unique<pal_session>();
    pal_state_reader reader_{};
    std::uint32_t n_ticks_ = 0;
    std::uint64_t id_ = 0;
};

/// Takes `falcon` over as palpate-loop --zero does, and looks at every tick of it.
void take_over(Falcon falcon, std::uint32_t gap_ticks) {
    for (std::uint32_t i = 0; i < gap_ticks; ++i) falcon.live();
    falcon.sim.has_reply = false;  // on the dead loop's connection
    falcon.requests.clear();
    const pal_device device = falcon.device();
    pal_takeover takeover{};
    std::uint32_t n = 0;
    for (; pal_takeover_tick(&takeover, &device) == PAL_TAKEOVER_RUNS; ++n) {
        REQUIRE_FALSE(falcon.asked_for_force());
        falcon.live();
        if (n >= falcon.sim.config.delay_ticks) REQUIRE_FALSE(falcon.motors_act());
    }
    REQUIRE(n == 20);
    REQUIRE(takeover.answered);
    REQUIRE(falcon.requests.size() == 20);
    for (const Packet& packet : falcon.requests) {
        for (std::size_t i = 1; i <= 12; ++i) REQUIRE(packet[i] == 0x41);
    }
    for (int i = 0; i < 60; ++i) {  // nobody sends any more
        falcon.live();
        REQUIRE_FALSE(falcon.asked_for_force());
        REQUIRE_FALSE(falcon.motors_act());
    }
}

}  // namespace

TEST_CASE("killed at any tick of a press, the loop's force is gone with the first packet of the take-over") {
    const std::size_t every = std::getenv("PALPATE_SOAK") != nullptr ? 1 : 5;
    Press press;
    std::map<std::string, int> n_kills;
    for (std::size_t tick = 0; tick < 1600; ++tick) {
        const std::string phase = press.tick();
        if (tick % every == 0 || phase == "fade") {
            INFO("killed in tick " << tick << ", " << phase);
            n_kills[phase] += 1;
            for (const std::uint32_t gap_ticks : {0U, 1U, 12U}) take_over(press.falcon, gap_ticks);
            Falcon far = press.falcon;  // the slowest wire: the dead loop's words are still on their way
            far.sim.config.delay_ticks = PAL_FALCON_DELAY_MAX;
            take_over(far, 0);
        }
        press.falcon.live();
    }
    for (const auto* phase : {"homing", "free", "ramp", "contact", "fade"}) {
        INFO(phase << ": " << n_kills[phase] << " kills");
        CHECK(n_kills[phase] >= 10);
    }
}

TEST_CASE("without the take-over the dead loop's force stays: nothing else in that test takes it away") {
    Press press;
    std::string phase;
    for (int tick = 0; tick < 1500; ++tick) {
        phase = press.tick();
        press.falcon.live();
    }
    REQUIRE(phase == "contact");
    for (int i = 0; i < 1000; ++i) press.falcon.live();
    CHECK(press.falcon.asked_for_force());
    CHECK(press.falcon.motors_act());
}

TEST_CASE("a packet that the loop died in the middle of does not spoil the first of the take-over") {
    Press press;
    for (int tick = 0; tick < 1500; ++tick) {
        press.tick();
        press.falcon.live();
    }
    REQUIRE(press.falcon.asked_for_force());
    for (std::size_t n_bytes = 1; n_bytes < 16; ++n_bytes) {
        INFO(n_bytes << " bytes");
        Falcon falcon = press.falcon;
        pal_falcon_sim_receive(&falcon.sim, press.falcon.requests.back().data(), n_bytes);
        take_over(falcon, 0);
    }
}

TEST_CASE("a device that answers late gets zeros until it does, one that never does is given up") {
    const auto silent_ticks = GENERATE(as<std::uint32_t>{}, 0, 1, 19, 20, 21, 150, 199, 200, 1000);
    Falcon falcon;
    falcon.start();
    falcon.answers = false;
    const pal_device device = falcon.device();
    pal_takeover takeover{};
    pal_takeover_end end = PAL_TAKEOVER_RUNS;
    std::uint32_t n = 0;
    for (; n < 1000; ++n) {
        falcon.answers = n >= silent_ticks;
        if (end = pal_takeover_tick(&takeover, &device); end != PAL_TAKEOVER_RUNS) break;
        falcon.live();
    }
    // The answer to a packet is there a tick after it.
    const std::uint32_t expected = std::min<std::uint32_t>(std::max<std::uint32_t>(20, silent_ticks), 200);
    CHECK(end == (silent_ticks > 200 ? PAL_TAKEOVER_SILENT : PAL_TAKEOVER_DONE));
    CHECK(n == expected);
    CHECK(falcon.requests.size() == expected);
}

TEST_CASE("one answer is enough, at whatever tick it comes") {
    const auto answers_at = GENERATE(as<std::uint32_t>{}, 1, 10, 20, 40);
    Falcon falcon;
    falcon.start();
    const pal_device device = falcon.device();
    pal_takeover takeover{};
    pal_takeover_end end = PAL_TAKEOVER_RUNS;
    for (std::uint32_t n = 0; end == PAL_TAKEOVER_RUNS; ++n) {
        falcon.answers = n == answers_at;
        end = pal_takeover_tick(&takeover, &device);
        falcon.live();
    }
    CHECK(end == PAL_TAKEOVER_DONE);
    CHECK(falcon.requests.size() == std::max<std::size_t>(20, answers_at));
}

TEST_CASE("packets that the device does not take do not count as sent") {
    const auto n_busy = GENERATE(as<std::uint32_t>{}, 1, 20, 180, 181, 1000);
    Falcon falcon;
    falcon.start();
    falcon.n_busy = n_busy;
    const pal_device device = falcon.device();
    pal_takeover takeover{};
    pal_takeover_end end = PAL_TAKEOVER_RUNS;
    while ((end = pal_takeover_tick(&takeover, &device)) == PAL_TAKEOVER_RUNS) falcon.live();
    CHECK(end == (n_busy <= 180 ? PAL_TAKEOVER_DONE : PAL_TAKEOVER_SILENT));
    CHECK(falcon.requests.size() == (n_busy <= 180 ? 20 : n_busy < 200 ? 200 - n_busy : 0));
    CHECK(takeover.n_ticks <= PAL_TAKEOVER_TICKS_MAX);
}

TEST_CASE("a device whose other end closes ends the take-over at once") {
    const auto closes_at = GENERATE(as<std::uint32_t>{}, 0, 1, 10, 19);
    Falcon falcon;
    falcon.start();
    const pal_device device = falcon.device();
    pal_takeover takeover{};
    for (std::uint32_t n = 0; n < closes_at; ++n) {
        REQUIRE(pal_takeover_tick(&takeover, &device) == PAL_TAKEOVER_RUNS);
        falcon.live();
    }
    falcon.open = false;
    CHECK(pal_takeover_tick(&takeover, &device) == PAL_TAKEOVER_HUNG_UP);
}
