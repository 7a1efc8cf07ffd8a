/// A session with firmware that runs, and the run-time packets as docs/PROTOCOL.md 4 writes them.
#pragma once
#include <array>

#include "tests/firmware/falcon_script.hpp"

namespace script {

using Lines = std::vector<std::string>;

// A reply as docs/PROTOCOL.md 4 writes it.
inline Bytes reply(std::array<int, 3> counts, unsigned flags) {
    Bytes bytes{'<'};
    for (const int count : counts) {
        const auto bits = static_cast<std::uint16_t>(count);
        for (unsigned d = 0; d < 4; ++d)
            bytes.push_back(static_cast<std::uint8_t>(0x41 + (bits >> 4U * d & 15U)));
    }
    bytes.push_back(static_cast<std::uint8_t>(0x41 + flags));
    bytes.push_back(0x41);
    bytes.push_back('>');
    return bytes;
}

inline constexpr unsigned HOMED = 0x70;
// (0, 0, 0.11) m.
inline const std::array<int, 3> MIDDLE{-516, -516, -516};

struct Words {
    std::array<int, 3> motor;
    int flags;
};

// The motor words and flags of a request, from its hex line.
inline Words words_of(const std::string& line) {
    REQUIRE(line.size() == 2 + 32);
    const auto byte = [&](std::size_t i) { return std::stoi(line.substr(2 + 2 * i, 2), nullptr, 16); };
    REQUIRE(byte(0) == 0x3C);
    REQUIRE(byte(15) == 0x3E);
    Words words{};
    for (std::size_t m = 0; m < 3; ++m) {
        unsigned bits = 0;
        for (unsigned d = 0; d < 4; ++d) bits |= static_cast<unsigned>(byte(1 + 4 * m + d) - 0x41) << 4U * d;
        words.motor[m] = static_cast<std::int16_t>(bits);
    }
    words.flags = byte(13) - 0x41;
    return words;
}

inline bool is_zero(const Words& words) {
    return words.motor == std::array<int, 3>{0, 0, 0};
}

// A session with firmware that runs, driven by a force at each reply.
class Running : public Session {
public:
    std::array<float, 3> force_n{0.0F, 0.0F, -2.0F};
    float limit_n = 8.0F;
    std::uint8_t leds = 0;
    bool drives = true;

    explicit Running(pal_falcon_config config = pal_falcon_config_default()) {
        device.dsp = Dsp::run;
        device.reply = reply(MIDDLE, HOMED);
        config.boot.reload = PAL_RELOAD_NEVER;
        REQUIRE(start(config) == PAL_FALCON_OK);
    }

    static pal_falcon_config no_ramp() {
        pal_falcon_config config = pal_falcon_config_default();
        config.force.ramp_us = 0;
        return config;
    }

    /// Until n more replies have come (or the time is over); drives after each.
    bool exchange(std::uint32_t n = 1, std::uint64_t limit_us = 2000000) {
        const std::uint32_t until = falcon.exchange.n_replies + n;
        const std::uint64_t end_us = now_us + limit_us;
        std::uint32_t seen = falcon.exchange.n_replies;
        while (falcon.exchange.n_replies < until && now_us < end_us) {
            step();
            if (falcon.exchange.n_replies != seen && drives) drive();
            seen = falcon.exchange.n_replies;
        }
        return falcon.exchange.n_replies >= until;
    }

    void drive() { pal_falcon_drive(&falcon, force_n.data(), limit_n, leds); }

    Words last() const { return words_of(lines(device.log, "W").back()); }
};

}  // namespace script
