/// A plain host in virtual time for the tests of the device model: transfers take no time, waiting takes
/// exactly as long as the device says. And the facts that the tests hold the device to, written down here by
/// hand.
#pragma once
#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/falcon/usb_device.h"

namespace palpate::test {

using Bytes = std::vector<std::uint8_t>;

/// A TI boot stream of one block: 30 + 2 * n_words bytes.
inline Bytes boot_image(std::size_t n_words) {
    Bytes image{0xAA, 0x08};
    image.insert(image.end(), 16, 0x00);
    for (const int byte : {0x3F, 0x00, 0x02, 0x80}) image.push_back(static_cast<std::uint8_t>(byte));
    image.push_back(static_cast<std::uint8_t>(n_words & 0xFFU));
    image.push_back(static_cast<std::uint8_t>(n_words >> 8U));
    for (const int byte : {0x3F, 0x00, 0x02, 0x80}) image.push_back(static_cast<std::uint8_t>(byte));
    for (std::size_t i = 0; i < 2 * n_words; ++i) image.push_back(static_cast<std::uint8_t>(i * 37 + 11));
    image.insert(image.end(), 2, 0x00);
    return image;
}

struct Packet {
    std::uint64_t at_us;
    Bytes bytes;
    bool operator==(const Packet&) const = default;
};

class PlainHost {
public:
    explicit PlainHost(const pal_usb_device_config& config) : device_(std::make_unique<pal_usb_device>()) {
        ok_ = pal_usb_device_init(device_.get(), &config);
        now_us_ = config.start_us;
    }

    [[nodiscard]] bool ok() const { return ok_; }
    [[nodiscard]] std::uint64_t now_us() const { return now_us_; }
    [[nodiscard]] pal_usb_device* device() { return device_.get(); }
    [[nodiscard]] pal_usb_device_truth truth() const { return pal_usb_device_read(device_.get()); }

    void advance_to(std::uint64_t us) {
        now_us_ = us;
        pal_usb_device_advance(device_.get(), us);
    }
    void wait(std::uint64_t us) { advance_to(now_us_ + us); }

    int control(std::uint8_t type, std::uint8_t request, unsigned value, unsigned index,
                Bytes* data = nullptr, std::uint16_t length = 0) {
        const std::uint8_t setup[8] = {type,
                                       request,
                                       static_cast<std::uint8_t>(value & 0xFFU),
                                       static_cast<std::uint8_t>(value >> 8U),
                                       static_cast<std::uint8_t>(index & 0xFFU),
                                       static_cast<std::uint8_t>(index >> 8U),
                                       static_cast<std::uint8_t>(length & 0xFFU),
                                       static_cast<std::uint8_t>(length >> 8U)};
        Bytes room(length);
        const int n = pal_usb_device_control(device_.get(), setup, room.data(), room.size());
        if (data != nullptr) data->assign(room.begin(), room.begin() + (n > 0 ? n : 0));
        return n;
    }
    int vendor(std::uint8_t request, unsigned value, unsigned index = 0) {
        return control(0x40, request, value, index);
    }
    [[nodiscard]] Bytes ask(std::uint8_t type, std::uint8_t request, unsigned value, unsigned index,
                            std::uint16_t length) {
        Bytes data;
        control(type, request, value, index, &data, length);
        return data;
    }

    int out(const Bytes& bytes) { return pal_usb_device_out(device_.get(), bytes.data(), bytes.size()); }
    int in(Bytes& packet) {
        std::uint8_t room[PAL_USB_PACKET_BYTES];
        const int n = pal_usb_device_in(device_.get(), room);
        packet.assign(room, room + (n > 0 ? n : 0));
        return n;
    }
    /// An IN transfer that waits: the packet and when it came. Nothing by `limit_us`, or an error: nullopt.
    std::optional<Packet> read(std::uint64_t limit_us = 1000000) {
        const std::uint64_t end_us = now_us_ + limit_us;
        for (;;) {
            Bytes packet;
            const int n = in(packet);
            if (n < 0) return std::nullopt;
            if (n > 0) return Packet{now_us_, packet};
            const std::uint64_t next_us = pal_usb_device_next_us(device_.get());
            if (next_us <= now_us_ || next_us > end_us) return std::nullopt;
            advance_to(next_us);
        }
    }
    /// Payload of packets until `n` bytes came or limit_us passed.
    Bytes payload(std::size_t n, std::uint64_t limit_us = 100000) {
        const std::uint64_t end_us = now_us_ + limit_us;
        Bytes all;
        while (all.size() < n && now_us_ < end_us) {
            const auto packet = read(end_us - now_us_);
            if (!packet) break;
            all.insert(all.end(), packet->bytes.begin() + 2, packet->bytes.end());
        }
        return all;
    }

    void set_baud(unsigned value, unsigned index = 0) { vendor(0x03, value, index); }
    void set_latency(unsigned ms) { vendor(0x09, ms); }
    void set_dtr(bool high) { vendor(0x01, high ? 0x0101 : 0x0100); }
    void purge() {
        vendor(0x00, 1);
        vendor(0x00, 2);
    }

    /// Up to DTR high, as libnifalcon does it.
    void begin_boot(unsigned latency_ms = 16) {
        purge();
        set_latency(latency_ms);
        set_baud(0x4138);
        vendor(0x04, 0x0008);
        vendor(0x02, 0);
        vendor(0x01, 0x0200);
        set_dtr(false);
        set_dtr(true);
    }
    void begin_run() {
        set_latency(1);
        set_baud(0x0002);
        purge();
    }
    /// The whole boot, forgiving as a good driver: true when each step was answered.
    bool boot(const Bytes& image, unsigned baud = 0x0015) {
        begin_boot();
        out({0x0A, 0x43, 0x0D});
        Bytes got = payload(5, 60000);
        if (!got.empty() && got.front() == 0) got.erase(got.begin());
        if (got != Bytes{0x0A, 0x44, 0x2C, 0x0D}) return false;
        set_dtr(false);
        set_baud(baud);
        out({0x41});
        got = payload(2, 60000);
        if (got.empty() || got.back() != 0x41) return false;
        for (std::size_t at = 0; at < image.size(); at += 62) {
            const std::size_t n = std::min<std::size_t>(62, image.size() - at);
            const Bytes chunk(image.begin() + static_cast<std::ptrdiff_t>(at),
                              image.begin() + static_cast<std::ptrdiff_t>(at + n));
            out(chunk);
            if (payload(n, 300000) != chunk) return false;
        }
        begin_run();
        return true;
    }

private:
    std::unique_ptr<pal_usb_device> device_;
    std::uint64_t now_us_ = 0;
    bool ok_ = false;
};

/// The vectors of docs/PROTOCOL.md 4 and their like, as text.
inline Bytes bytes_of(const std::string& text) {
    return {text.begin(), text.end()};
}
inline const Bytes ZERO_REQUEST = bytes_of("<AAAAAAAAAAAAAA>");

inline const Bytes IDLE{0x01, 0x60}, PIC_REQUEST{0x0A, 0x43, 0x0D};

/// A packet of this payload with nothing else to tell.
inline Bytes with_status(const Bytes& payload) {
    Bytes packet = IDLE;
    packet.insert(packet.end(), payload.begin(), payload.end());
    return packet;
}

inline Bytes part(const Bytes& bytes, std::size_t from, std::size_t n) {
    const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(from);
    return {begin, begin + static_cast<std::ptrdiff_t>(n)};
}

/// The next packet with payload.
inline std::optional<Packet> read_data(PlainHost& host) {
    auto packet = host.read();
    while (packet && packet->bytes.size() == 2) packet = host.read();
    return packet;
}

/// The reply to a request, without the status bytes.
inline Bytes answer_to(PlainHost& host, const Bytes& request, std::uint64_t limit_us = 100000) {
    host.out(request);
    return host.payload(16, limit_us);
}

inline pal_usb_device_config still_device() {  // nothing moves: no weight
    pal_usb_device_config config = pal_usb_device_config_default();
    config.falcon.gravity_m_per_s2 = 0;
    config.falcon.n_substeps = 1;
    return config;
}

inline pal_usb_device_config running_device() {
    pal_usb_device_config config = still_device();
    config.running = true;
    return config;
}

}  // namespace palpate::test
