/// A Falcon that follows a script, in virtual time: what it answers to each write is decided here, byte by
/// byte, from docs/PROTOCOL.md. It shares nothing with sim/. Every step of the driver is logged as text.
#pragma once
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "firmware/falcon/falcon.h"

namespace script {

using Bytes = std::vector<std::uint8_t>;

/// A boot container of `n_words` words in one block at 3F8002.
inline Bytes container(std::size_t n_words = 1) {
    Bytes bytes{0xAA, 0x08};
    bytes.resize(18, 0);
    for (const int b : {0x3F, 0x00, 0x02, 0x80}) bytes.push_back(static_cast<std::uint8_t>(b));
    bytes.push_back(static_cast<std::uint8_t>(n_words));
    bytes.push_back(static_cast<std::uint8_t>(n_words >> 8U));
    for (const int b : {0x3F, 0x00, 0x02, 0x80}) bytes.push_back(static_cast<std::uint8_t>(b));
    for (std::size_t i = 0; i < 2 * n_words; ++i) {
        bytes.push_back(n_words == 1 ? std::uint8_t{0} : static_cast<std::uint8_t>(i * 37 + 11));
    }
    bytes.push_back(0);
    bytes.push_back(0);
    return bytes;
}

inline std::string hex(const std::uint8_t* bytes, std::size_t n_bytes) {
    std::string text;
    char two[3];
    for (std::size_t i = 0; i < n_bytes; ++i) {
        std::snprintf(two, sizeof two, "%02X", bytes[i]);
        text += two;
    }
    return text;
}

/// Where the device is, as its lines and bytes say.
enum class Dsp { off, autobaud, load, run, mute };

class Device {
public:
    Bytes image = container();
    Bytes before_answer, before_a;  ///< noise, put in front
    std::vector<std::size_t> cuts;  ///< replies are cut into packets of these sizes, the last one repeated
    bool status_between = false;    ///< a status-only packet before each
    bool powered = true;
    Dsp dsp = Dsp::autobaud;
    std::uint64_t answer_us = 500;  ///< from write to reply
    Bytes reply = Bytes{'<', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', 'A', '>'};
    /// May change what the device is about to say to write k (from 0) of the session.
    std::function<void(std::size_t, const Bytes&, Bytes&)> tamper;

    std::vector<std::string> log;
    std::size_t n_writes = 0;
    std::uint32_t divisor = 0;  ///< wIndex << 16 | wValue
    bool dtr = false;

    void control(const pal_usb_step& s, std::uint64_t now_us) {
        char line[32];
        std::snprintf(line, sizeof line, "C %02X %04X %04X", s.request, s.value, s.index);
        log.emplace_back(line);
        if (s.request == 0x03) divisor = static_cast<std::uint32_t>(s.index) << 16U | s.value;
        if (s.request == 0x01 && (s.value & 0x0100U) != 0) dtr = (s.value & 1U) != 0;
        if (s.request == 0x00 && s.value == 2) purge(now_us);
        if (s.request == 0x00 && s.value == 0) {
            purge(now_us);
            dtr = false;
        }
    }

    void write(const pal_usb_step& s, std::uint64_t now_us) {
        log.push_back("W " + hex(s.bytes, s.n_bytes));
        const Bytes sent(s.bytes, s.bytes + s.n_bytes);
        Bytes said = powered ? answer(sent) : Bytes{};
        if (tamper) tamper(n_writes, sent, said);
        n_writes += 1;
        say(said, now_us + answer_us);
    }

    /// Queues payload as packets.
    void say(const Bytes& payload, std::uint64_t at_us) {
        std::size_t done = 0;
        std::size_t k = 0;
        while (done < payload.size()) {
            std::size_t n = cuts.empty() ? 62 : cuts[std::min(k, cuts.size() - 1)];
            n = std::min(n, payload.size() - done);
            if (status_between) waiting_.push_back({at_us, {0x01, 0x60}});
            Packet packet{at_us, {0x01, 0x60}};
            packet.bytes.insert(packet.bytes.end(), payload.begin() + static_cast<std::ptrdiff_t>(done),
                                payload.begin() + static_cast<std::ptrdiff_t>(done + n));
            waiting_.push_back(packet);
            done += n;
            k += 1;
            at_us += 100;
        }
    }

    struct Packet {
        std::uint64_t at_us;
        Bytes bytes;
    };
    std::deque<Packet>& waiting() { return waiting_; }

private:
    std::deque<Packet> waiting_;
    std::size_t n_loaded_ = 0;

    // What is still on its way to the bridge is not lost.
    void purge(std::uint64_t now_us) {
        while (!waiting_.empty() && waiting_.front().at_us <= now_us) waiting_.pop_front();
    }

    Bytes answer(const Bytes& sent) {
        if (dtr) {
            if (divisor != 0x4138 || sent != Bytes{0x0A, 0x43, 0x0D}) return {};
            dsp = Dsp::autobaud;
            n_loaded_ = 0;
            Bytes said = before_answer;
            said.insert(said.end(), {0x0A, 0x44, 0x2C, 0x0D});
            return said;
        }
        if (dsp == Dsp::autobaud && sent == Bytes{0x41}) {
            dsp = Dsp::load;
            Bytes said = before_a;
            said.push_back(0x41);
            return said;
        }
        if (dsp == Dsp::load) {
            n_loaded_ += sent.size();
            if (n_loaded_ >= image.size()) dsp = Dsp::run;
            return sent;
        }
        if (dsp == Dsp::run && divisor == 0x0002 && sent.size() == 16) return reply;
        return {};
    }
};

/// Driver and device with one clock.
class Session {
public:
    Device device;
    pal_falcon falcon{};
    std::uint64_t now_us = 1000000;
    std::uint64_t transfer_us = 125;  ///< that each control request or write takes

    static pal_falcon_config config_for(const Bytes& image) {
        pal_falcon_config config = pal_falcon_config_default();
        config.boot.image = image.data();
        config.boot.n_image_bytes = image.size();
        return config;
    }

    pal_falcon_refusal start(const pal_falcon_config& config) { return pal_falcon_init(&falcon, &config); }

    /// One step of the driver and what follows from it. False when the driver had nothing to send.
    bool step() {
        const pal_usb_step s = pal_falcon_next(&falcon, now_us);
        if (s.kind == PAL_USB_CONTROL) device.control(s, now_us);
        if (s.kind == PAL_USB_WRITE) {
            REQUIRE((s.n_bytes >= 1 && s.n_bytes <= 62));
            device.write(s, now_us);
        }
        if (s.kind != PAL_USB_IDLE) {
            now_us += transfer_us;
            return true;
        }
        REQUIRE(s.wake_us > 0);
        if (pal_falcon_done(&falcon)) {
            now_us += 1;
            return false;
        }
        auto& waiting = device.waiting();
        if (waiting.empty() || waiting.front().at_us > now_us + s.wake_us) {
            now_us += s.wake_us;
            return false;
        }
        now_us = std::max(now_us, waiting.front().at_us);
        const Bytes packet = waiting.front().bytes;
        waiting.pop_front();
        pal_falcon_feed(&falcon, packet.data(), packet.size(), now_us);
        return false;
    }

    /// Until `done` says so or `limit_us` have passed. True when it said so.
    bool run(const std::function<bool()>& done, std::uint64_t limit_us = 60000000) {
        const std::uint64_t end_us = now_us + limit_us;
        while (!done()) {
            if (now_us >= end_us) return false;
            step();
        }
        return true;
    }

    bool run_to(pal_falcon_state state, std::uint64_t limit_us = 60000000) {
        return run([&] { return falcon.state == state; }, limit_us);
    }

    /// To the end of the boot, well or not.
    bool boot() {
        return run([&] { return falcon.state != PAL_FALCON_BOOTING; });
    }

    pal_falcon_status status() const {
        pal_falcon_status now;
        pal_falcon_status_read(&falcon, &now);
        return now;
    }

    pal_falcon_sense sense() const {
        pal_falcon_sense now;
        (void)pal_falcon_read(&falcon, &now);
        return now;
    }
};

/// Lines of the log that start with `head`.
inline std::vector<std::string> lines(const std::vector<std::string>& log, const std::string& head) {
    std::vector<std::string> found;
    for (const std::string& line : log) {
        if (line.compare(0, head.size(), head) == 0) found.push_back(line);
    }
    return found;
}

inline const std::string ZERO_FORCE = "W 3C41414141414141414141414141413E";

}  // namespace script
