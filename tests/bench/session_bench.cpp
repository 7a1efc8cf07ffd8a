// A whole tick as palpate-loop runs it, around a device that answers at once: with its five time stamps and
// without, in one run. The difference is what measuring costs.
#include <array>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "firmware/app/session.h"
#include "firmware/falcon/wire.h"
#include "tests/bench/measure.hpp"
#include "tests/common/tables.hpp"

namespace palpate::bench {
namespace {

constexpr int N_TICKS = 50000;

std::uint64_t clock_ns() {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<std::uint64_t>(now.tv_sec) * 1000000000U + static_cast<std::uint64_t>(now.tv_nsec);
}

std::uint64_t no_clock() {
    return 0;
}

/// Answers every tick from 3 mm inside the skin.
struct Mirror {
    std::array<std::uint8_t, PAL_WIRE_BYTES> reply{};

    Mirror() {
        pal_drive counts{};
        const float at_m[3] = {0.0F, 0.0F, 0.117F};
        float theta[3];
        bool ok = pal_delta_inverse(&PAL_DELTA_NF1, at_m, theta);
        for (int i = 0; i < 3; ++i)
            ok = ok && pal_delta_counts(&PAL_DELTA_NF1, theta[i], &counts.motor_counts[i]);
        if (!ok) throw std::logic_error("session: the place is out of reach");
        pal_wire_encode(&counts, reply.data());
        reply[13] = 'A' + 0x70;  // all homed
    }
    static pal_device_news collect(void* context, std::uint8_t reply[PAL_WIRE_BYTES]) {
        std::memcpy(reply, static_cast<Mirror*>(context)->reply.data(), PAL_WIRE_BYTES);
        return PAL_DEVICE_FRESH;
    }
    static pal_device_news send(void* context, const std::uint8_t request[PAL_WIRE_BYTES]) {
        benchmark::DoNotOptimize(request[1] + static_cast<Mirror*>(context)->reply[0]);
        return PAL_DEVICE_FRESH;
    }
};

void tick(benchmark::State& state, std::uint64_t (*now_ns)()) {
    const auto link = std::make_unique<pal_link>();
    const auto session = std::make_unique<pal_session>();
    Mirror mirror;
    pal_link_init(link.get(), 1);
    link->host.enable = 1;
    const pal_device device = {&mirror, Mirror::collect, Mirror::send, nullptr};
    pal_loop_config config = pal_loop_config_default();
    config.ramp_ticks = 0;
    pal_session_begin(session.get(), link.get(), &device, &config, now_ns);
    const auto table = tables::make({}, 17);
    std::uint32_t n = 0;
    const auto publish = [&] {  // a sign of life: the same table with a new number
        table->id += 1;
        pal_table_seal(table.get());
        std::memcpy(pal_table_ring_back(&link->tables), table.get(), table->n_bytes);
        pal_table_ring_publish(&link->tables);
    };
    measure(
        state, Clock::wall, 1,
        [&](std::size_t) {
            link->host.heartbeat += 1;
            if (n % 40 == 0) publish();
            (void)pal_intake_check(&session->intake);
        },
        [&](std::size_t) {
            const pal_session_time when{clock_ns(), 0, 0};
            (void)pal_session_tick(session.get(), &when);
            ++n;
        });
    if (session->loop.state != PAL_STATE_ENABLED || session->loop.touch.force_n[2] < 1.0F)
        throw std::runtime_error("session: not the tick that was meant");
}

}  // namespace

void register_session() {
    add("session/tick with stamps", N_TICKS, [](benchmark::State& state) { tick(state, clock_ns); });
    add("session/tick, stamps off", N_TICKS, [](benchmark::State& state) { tick(state, no_clock); });
}

}  // namespace palpate::bench
