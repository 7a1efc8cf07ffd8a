/// Reads a capture as any reader of pcap and usbmon would, byte by byte, and refuses what is not well formed.
#pragma once
#include <catch2/catch.hpp>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

namespace usbtest {

/// Layout: struct mon_bin_hdr of Linux' Documentation/usb/usbmon.rst, at the offsets written here.
struct Record {
    std::uint64_t id = 0;
    char event = 0;
    unsigned kind = 0, endpoint = 0, address = 0, bus = 0;
    char setup_flag = 0, data_flag = 0;
    std::uint64_t time_us = 0;
    std::int32_t status = 0;
    std::uint32_t n_bytes = 0;
    std::string setup, data;
};

class Capture {
public:
    explicit Capture(const std::string& file) {
        std::ifstream in(file, std::ios::binary);
        bytes_.assign(std::istreambuf_iterator<char>(in), {});
        REQUIRE(bytes_.size() >= 24);
        CHECK(number(0, 4) == 0xA1B2C3D4U);
        CHECK(number(4, 2) == 2);
        CHECK(number(6, 2) == 4);
        CHECK(number(8, 8) == 0);
        snap_ = number(16, 4);
        CHECK(number(20, 4) == 220);
        for (std::size_t at = 24; at < bytes_.size();) at = read(at);
    }
    [[nodiscard]] const std::vector<Record>& records() const { return records_; }
    [[nodiscard]] std::size_t size() const { return bytes_.size(); }

    /// 'S' and 'C' of each transfer, in this order and alike. Returns how many have no 'C'.
    [[nodiscard]] std::size_t pair() const {
        std::map<std::uint64_t, const Record*> open;
        std::uint64_t last_us = 0;
        for (const Record& r : records_) {
            CHECK(r.time_us >= last_us);
            last_us = r.time_us;
            if (r.event == 'S') {
                REQUIRE(open.emplace(r.id, &r).second);
                continue;
            }
            REQUIRE(open.count(r.id) == 1);
            const Record& begin = *open[r.id];
            CHECK(r.kind == begin.kind);
            CHECK(r.endpoint == begin.endpoint);
            CHECK(r.address == begin.address);
            CHECK(r.n_bytes <= begin.n_bytes);
            open.erase(r.id);
        }
        return open.size();
    }

private:
    [[nodiscard]] std::uint64_t number(std::size_t at, std::size_t n) const {
        std::uint64_t value = 0;
        for (std::size_t i = n; i-- > 0;) value = value << 8U | static_cast<unsigned char>(bytes_[at + i]);
        return value;
    }

    /// One record; the place of the next.
    std::size_t read(std::size_t at) {
        REQUIRE(bytes_.size() - at >= 16 + 64);
        const std::uint64_t n_kept = number(at + 8, 4);
        const std::uint64_t n_whole = number(at + 12, 4);
        const std::uint64_t time_us = number(at, 4) * 1000000 + number(at + 4, 4);
        REQUIRE(n_kept >= 64);
        REQUIRE(n_kept <= snap_);
        REQUIRE(n_kept <= n_whole);
        REQUIRE(bytes_.size() - at >= 16 + n_kept);
        const std::size_t h = at + 16;
        Record r;
        r.id = number(h, 8);
        r.event = bytes_[h + 8];
        r.kind = static_cast<unsigned>(number(h + 9, 1));
        r.endpoint = static_cast<unsigned>(number(h + 10, 1));
        r.address = static_cast<unsigned>(number(h + 11, 1));
        r.bus = static_cast<unsigned>(number(h + 12, 2));
        r.setup_flag = bytes_[h + 14];
        r.data_flag = bytes_[h + 15];
        r.time_us = number(h + 16, 8) * 1000000 + number(h + 24, 4);
        r.status = static_cast<std::int32_t>(number(h + 28, 4));
        r.n_bytes = static_cast<std::uint32_t>(number(h + 32, 4));
        CHECK(number(h + 36, 4) == n_kept - 64);
        if (r.setup_flag == 0) r.setup = bytes_.substr(h + 40, 8);
        r.data = bytes_.substr(h + 64, n_kept - 64);
        CHECK(r.time_us == time_us);
        check(r);
        records_.push_back(r);
        return h + n_kept;
    }

    static void check(const Record& r) {
        const bool in = (r.endpoint & 0x80U) != 0;
        const bool begins = r.event == 'S';
        const bool control = (r.endpoint & 0x7FU) == 0;
        REQUIRE((begins || r.event == 'C'));
        CHECK(r.bus == 1);
        CHECK(r.kind == (control ? 2U : 3U));
        CHECK((r.setup_flag == 0) == (control && begins));
        CHECK((r.status == -115) == begins);
        if (in != begins) {
            CHECK(r.data_flag == 0);
            CHECK(r.data.size() == r.n_bytes);
        } else {
            CHECK(r.data_flag == (in ? '<' : '>'));
            CHECK(r.data.empty());
        }
    }

    std::string bytes_;
    std::uint64_t snap_ = 0;
    std::vector<Record> records_;
};

}  // namespace usbtest
