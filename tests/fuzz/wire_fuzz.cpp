// Any bytes on the wire, to both ends: the driver's reader and the simulated device. What each makes of them
// stays in range, and after any rubbish the next good packet is understood.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "firmware/falcon/wire.h"
#include "sim/falcon/falcon_sim.h"

namespace {

void require(bool holds) {
    if (!holds) std::abort();
}

void check_driver(const std::uint8_t* data, std::size_t size) {
    pal_wire_reader reader{};
    std::uint32_t n_packets = 0;
    for (std::size_t i = 0; i < size; ++i) {
        if (!pal_wire_feed(&reader, data[i])) continue;
        ++n_packets;
        pal_sense sense{};
        if (pal_wire_decode(reader.bytes, &sense)) require(sense.fresh == 1 && sense.homed <= 7);
    }
    require(n_packets * std::size_t{PAL_WIRE_BYTES} + reader.n_skipped_bytes <= size);
    require(reader.n_bytes < PAL_WIRE_BYTES || size >= PAL_WIRE_BYTES);
}

void check_device(const std::uint8_t* data, std::size_t size) {
    static const pal_falcon_sim_config CONFIG = pal_falcon_sim_config_default();
    pal_falcon_sim sim;
    require(pal_falcon_sim_init(&sim, &CONFIG));
    pal_falcon_sim_receive(&sim, data, size);
    for (const std::int16_t word : sim.queued_counts[0]) {
        require(word >= -PAL_FALCON_MOTOR_MAX && word <= PAL_FALCON_MOTOR_MAX);
    }
    pal_drive drive{};
    if (size >= sizeof drive.motor_counts) std::memcpy(drive.motor_counts, data, sizeof drive.motor_counts);
    for (std::int16_t& word : drive.motor_counts) word = static_cast<std::int16_t>(word % 4096);
    std::uint8_t packet[PAL_WIRE_BYTES];
    pal_wire_encode(&drive, packet);
    pal_falcon_sim_receive(&sim, packet, sizeof packet);
    for (int i = 0; i < 3; ++i) require(sim.queued_counts[0][i] == drive.motor_counts[i]);
    std::uint8_t reply[16];
    pal_sense sense{};
    require(pal_falcon_sim_reply(&sim, reply) && pal_wire_decode(reply, &sense));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    check_driver(data, size);
    check_device(data, size);
    return 0;
}
