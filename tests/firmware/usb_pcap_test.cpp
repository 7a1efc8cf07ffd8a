// The record of the USB traffic, read back by what the format says, not by the code that wrote it.
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <vector>

#include "firmware/falcon/packet.h"
#include "firmware/port/linux/pcap.h"
#include "tests/firmware/usb_bench.hpp"

using namespace usbbench;

namespace {

struct Event {
    std::uint64_t id;
    char type;
    std::uint8_t transfer, endpoint, address, flag_setup, flag_data;
    std::uint16_t bus;
    std::int64_t seconds;
    std::int32_t microseconds, status;
    std::uint32_t length;
    script::Bytes setup, data;
};

template <typename T>
T number_at(const script::Bytes& bytes, std::size_t at) {
    T value;
    REQUIRE(at + sizeof value <= bytes.size());
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

std::vector<Event> events_of(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    const script::Bytes bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    REQUIRE(bytes.size() >= 24);
    CHECK(number_at<std::uint32_t>(bytes, 0) == 0xA1B2C3D4);
    CHECK(number_at<std::uint16_t>(bytes, 4) == 2);
    CHECK(number_at<std::uint16_t>(bytes, 6) == 4);
    CHECK(number_at<std::uint32_t>(bytes, 20) == 220);
    std::vector<Event> events;
    for (std::size_t at = 24; at < bytes.size();) {
        const auto n_kept = number_at<std::uint32_t>(bytes, at + 8);
        REQUIRE(n_kept >= 64);
        REQUIRE(number_at<std::uint32_t>(bytes, at + 12) == n_kept);
        const std::size_t h = at + 16;
        REQUIRE(h + n_kept <= bytes.size());
        Event e{number_at<std::uint64_t>(bytes, h),
                static_cast<char>(bytes[h + 8]),
                bytes[h + 9],
                bytes[h + 10],
                bytes[h + 11],
                bytes[h + 14],
                bytes[h + 15],
                number_at<std::uint16_t>(bytes, h + 12),
                number_at<std::int64_t>(bytes, h + 16),
                number_at<std::int32_t>(bytes, h + 24),
                number_at<std::int32_t>(bytes, h + 28),
                number_at<std::uint32_t>(bytes, h + 32),
                {},
                {}};
        REQUIRE(number_at<std::uint32_t>(bytes, h + 36) == n_kept - 64);
        using Step = script::Bytes::difference_type;
        const auto begin = bytes.begin() + static_cast<Step>(h);
        e.setup.assign(begin + 40, begin + 48);
        e.data.assign(begin + 64, begin + static_cast<Step>(n_kept));
        events.push_back(e);
        at = h + n_kept;
    }
    return events;
}

/// Submissions and completions belong together, one by one; times do not go back.
void check_order(const std::vector<Event>& events) {
    std::map<std::uint64_t, bool> under_way;
    std::int64_t last_us = 0;
    for (const Event& e : events) {
        REQUIRE((e.type == 'S' || e.type == 'C'));
        REQUIRE(under_way[e.id] == (e.type == 'C'));
        under_way[e.id] = e.type == 'S';
        const std::int64_t now_us = e.seconds * 1000000 + e.microseconds;
        CHECK(now_us >= last_us);
        last_us = now_us;
    }
    for (const auto& [id, is] : under_way) CHECK_FALSE(is);
}

}  // namespace

TEST_CASE("an event of the record has usbmon's 64 bytes in front of its data") {
    const Folder folder;
    pal_pcap pcap{};
    REQUIRE(pal_pcap_open(&pcap, (folder / "a.pcap").c_str()));
    const std::uint8_t setup[8] = {0x40, 0x03, 0x38, 0x41, 0, 0, 0, 0};
    const std::uint8_t reply[3] = {0x01, 0x60, 0x41};
    pal_pcap_record record{};
    record.id = 0x1122334455667788;
    record.time_us = 1700000000123456;
    record.event = PAL_PCAP_SUBMIT;
    record.bus = 3;
    record.address = 9;
    record.status = -115;
    record.setup = setup;
    pal_pcap_write(&pcap, &record);
    record.event = PAL_PCAP_COMPLETE;
    record.endpoint = 0x81;
    record.status = 0;
    record.setup = nullptr;
    record.n_bytes = 3;
    record.data = reply;
    pal_pcap_write(&pcap, &record);
    REQUIRE(pal_pcap_close(&pcap));
    const std::vector<Event> events = events_of(folder / "a.pcap");
    REQUIRE(events.size() == 2);
    CHECK(events[0].id == 0x1122334455667788);
    CHECK(events[0].type == 'S');
    CHECK(events[0].transfer == 2);
    CHECK(events[0].endpoint == 0);
    CHECK(events[0].address == 9);
    CHECK(events[0].bus == 3);
    CHECK(events[0].flag_setup == 0);
    CHECK(events[0].flag_data == '>');
    CHECK(events[0].seconds == 1700000000);
    CHECK(events[0].microseconds == 123456);
    CHECK(events[0].status == -115);
    CHECK(events[0].setup == script::Bytes{0x40, 0x03, 0x38, 0x41, 0, 0, 0, 0});
    CHECK(events[1].transfer == 3);
    CHECK(events[1].endpoint == 0x81);
    CHECK(events[1].flag_setup == '-');
    CHECK(events[1].flag_data == 0);
    CHECK(events[1].length == 3);
    CHECK(events[1].data == script::Bytes{0x01, 0x60, 0x41});
}

TEST_CASE("a record that cannot be written whole says so, and no writer is no error") {
    pal_pcap pcap{};
    CHECK_FALSE(pal_pcap_open(&pcap, "/nowhere/at/all.pcap"));
    CHECK(pal_pcap_close(&pcap));
    pal_pcap_write(nullptr, nullptr);
    REQUIRE(pal_pcap_open(&pcap, "/dev/full"));
    const std::uint8_t byte = 0;
    pal_pcap_record record{};
    record.event = PAL_PCAP_SUBMIT;
    record.endpoint = 0x02;
    record.n_bytes = 1;
    record.data = &byte;
    for (int i = 0; i < 1000; ++i) pal_pcap_write(&pcap, &record);
    CHECK_FALSE(pal_pcap_close(&pcap));
}

TEST_CASE("the record of a boot and 60 exchanges, read back, is the boot and 60 exchanges", "[process]") {
    const Folder folder;
    const std::string firmware = folder.firmware(400), pcap = folder / "run.pcap";
    const std::string timing = GENERATE(as<std::string>{}, "immediate", "frames");
    const usbtest::Outcome outcome = run_falcon(
        {"--timing", timing},
        {"rate", "--firmware", firmware, "--exchanges", "60", "--rate-min-hz", "0", "--pcap", pcap});
    INFO(outcome.words);
    REQUIRE(outcome.code == 0);
    const std::vector<Event> events = events_of(pcap);
    check_order(events);
    script::Bytes sent, came;
    int n_control = 0;
    for (const Event& e : events) {
        if (e.type == 'S' && e.endpoint == 0x02) sent.insert(sent.end(), e.data.begin(), e.data.end());
        if (e.type == 'C' && e.endpoint == 0x81 && e.data.size() > 2) {
            came.insert(came.end(), e.data.begin() + 2, e.data.end());
        }
        n_control += e.type == 'S' && e.transfer == 2 && e.setup[0] == 0x40 ? 1 : 0;
    }
    CHECK(n_control >= 15);
    // The question, 'A', the container; the answer, and the echo of 'A' and the container.
    script::Bytes up{0x0A, 0x43, 0x0D, 0x41}, down{0x0A, 0x44, 0x2C, 0x0D, 0x41};
    const script::Bytes image = script::container(400);
    up.insert(up.end(), image.begin(), image.end());
    down.insert(down.end(), image.begin(), image.end());
    REQUIRE(sent.size() > up.size());
    REQUIRE(came.size() > down.size());
    using Step = script::Bytes::difference_type;
    CHECK(std::equal(up.begin(), up.end(), sent.begin()));
    CHECK(std::equal(down.begin(), down.end(), came.begin()));
    sent.erase(sent.begin(), sent.begin() + static_cast<Step>(up.size()));
    came.erase(came.begin(), came.begin() + static_cast<Step>(down.size()));
    // One request after the upload, 60 measured ones, 5 at the end, all of zero force; a reply for each.
    CHECK(sent.size() == std::size_t{66} * 16);
    CHECK(came.size() == sent.size());
    for (std::size_t at = 0; at + 16 <= sent.size() && at + 16 <= came.size(); at += 16) {
        CHECK(std::string(sent.begin() + static_cast<Step>(at), sent.begin() + static_cast<Step>(at) + 13) ==
              "<AAAAAAAAAAAA");
        pal_wire_reply reply{};
        CHECK(pal_packet_decode(came.data() + at, &reply));
    }
}
