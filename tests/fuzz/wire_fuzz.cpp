// Any bytes on the wire, to both ends: the driver's reader and the simulated device. What each makes of them
// stays in range, after any rubbish the next good packet is understood, and each reads what the other wrote.
#include "firmware/falcon/wire.h"
#include "sim/falcon/codec.h"
#include "sim/falcon/falcon_sim.h"
#include "tests/fuzz/input.hpp"

namespace {

using fuzz::require;

fuzz::Reached replies("reply decoded by the driver"), requests("request taken by the device");

void check_driver(fuzz::Bytes bytes) {
    pal_wire_reader reader{};
    std::uint32_t n_packets = 0;
    for (const std::uint8_t byte : bytes) {
        if (!pal_wire_feed(&reader, byte)) continue;
        ++n_packets;
        pal_sense sense{};
        if (!pal_wire_decode(reader.bytes, &sense)) continue;
        require(sense.fresh == 1 && sense.homed <= 7 && sense.buttons <= 15);
        // The device's own encoder must write these bytes again, but for the one that means nothing.
        std::uint8_t again[PAL_WIRE_BYTES];
        const auto flags = static_cast<std::uint8_t>(sense.buttons | sense.homed << 4U);
        pal_falcon_reply_encode(sense.encoder_counts, flags, again);
        again[14] = reader.bytes[14];
        require(std::memcmp(again, reader.bytes, sizeof again) == 0);
        replies.note();
    }
    // Rubbish is counted; a packet that was cut off by the end is neither.
    const std::size_t n_left = reader.n_bytes < PAL_WIRE_BYTES ? reader.n_bytes : 0U;
    require(n_packets * std::size_t{PAL_WIRE_BYTES} + reader.n_skipped_bytes + n_left == bytes.size());
}

void check_device(fuzz::Bytes bytes) {
    static const pal_falcon_sim_config CONFIG = [] {
        pal_falcon_sim_config config = pal_falcon_sim_config_default();
        config.n_substeps = 1;  // the bytes are what is tested here
        return config;
    }();
    pal_falcon_sim sim;
    require(pal_falcon_sim_init(&sim, &CONFIG));
    pal_falcon_sim_receive(&sim, bytes.data(), bytes.size());
    if (sim.has_reply) requests.note();
    for (const std::int16_t word : sim.queued_counts[0]) {
        require(word >= -PAL_FALCON_MOTOR_MAX && word <= PAL_FALCON_MOTOR_MAX);
    }
    pal_drive drive{};
    for (std::int16_t& word : drive.motor_counts) {
        word = static_cast<std::int16_t>(fuzz::take<std::int16_t>(bytes) % (PAL_FALCON_MOTOR_MAX + 1));
    }
    std::uint8_t packet[PAL_WIRE_BYTES];
    pal_wire_encode(&drive, packet);
    pal_falcon_sim_receive(&sim, packet, sizeof packet);
    for (int i = 0; i < 3; ++i) require(sim.queued_counts[0][i] == drive.motor_counts[i]);
    std::uint8_t reply[PAL_FALCON_PACKET_BYTES];
    pal_sense sense{};
    require(pal_falcon_sim_reply(&sim, reply) && pal_wire_decode(reply, &sense));
    pal_falcon_sim_advance(&sim, nullptr, nullptr, 0.0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    check_driver({data, size});
    check_device({data, size});
    return 0;
}
