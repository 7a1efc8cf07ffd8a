// Captures of the simulated bus: byte for byte, of whole runs, and read with the driver's decoder.
#include "sim/usb/pcap.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>

#include "firmware/falcon/ftdi.h"
#include "firmware/falcon/packet.h"
#include "tests/sim/usb/capture.hpp"
#include "tests/sim/usb/process.hpp"

using Catch::Contains;
using namespace usbtest;

namespace {

/// A file of this process, gone at the end.
struct File {
    std::string name = bus_folder() + ".pcap";
    File() = default;
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    ~File() { std::filesystem::remove(name); }
    [[nodiscard]] std::string text() const {
        std::ifstream in(name, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
};

std::string hex(const std::string& digits) {
    std::string bytes;
    for (size_t i = 0; i < digits.size(); ++i) {
        if (digits[i] == ' ') continue;
        bytes.push_back(static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16)));
        ++i;
    }
    return bytes;
}

/// A boot image of one word: the client's.
std::string image() {
    return hex("AA08") + std::string(16, '\0') + hex("3F000280 01003F000280 0000 0000");
}

/// Requests of the client plain, of its boot: bRequest, wValue.
const std::vector<std::pair<unsigned, unsigned>> kRequests = {
    {0, 1},      {0, 2},      {9, 16},     {3, 0x4138}, {4, 8}, {2, 0}, {1, 0x0200}, {1, 0x0100},
    {1, 0x0101}, {1, 0x0100}, {3, 0x0015}, {9, 1},      {3, 2}, {0, 1}, {0, 2}};

std::vector<std::pair<unsigned, unsigned>> vendor_requests(const Capture& capture) {
    std::vector<std::pair<unsigned, unsigned>> all;
    for (const Record& r : capture.records()) {
        if (r.setup.empty() || r.setup[0] != 0x40) continue;
        const auto byte = [&r](size_t i) { return static_cast<unsigned char>(r.setup[i]); };
        CHECK(r.setup.substr(4) == std::string(4, '\0'));
        all.emplace_back(byte(1), byte(2) + 256U * byte(3));
    }
    return all;
}

std::string written(const Capture& capture) {
    std::string all;
    for (const Record& r : capture.records()) {
        if (r.event == 'S' && r.endpoint == 0x02) all += r.data;
    }
    return all;
}

/// What the driver's decoder takes the IN transfers for.
std::string payload(const Capture& capture) {
    std::string all;
    for (const Record& r : capture.records()) {
        if (r.event != 'C' || r.endpoint != 0x81) continue;
        size_t n_taken = 0;
        pal_ftdi_payload packet{};
        const auto* bytes = reinterpret_cast<const uint8_t*>(r.data.data());
        while (pal_ftdi_next_packet(bytes, r.data.size(), &n_taken, &packet)) {
            CHECK(packet.line_errors == 0);
            all.append(reinterpret_cast<const char*>(packet.bytes), packet.n_bytes);
        }
    }
    return all;
}

std::string repeated(const std::string& text, unsigned n) {
    std::string all;
    while (n-- > 0) all += text;
    return all;
}

TEST_CASE("a capture is a usbmon pcap, byte for byte") {
    File file;
    pal_usbmon mon{};
    REQUIRE(pal_usbmon_open(&mon, file.name.c_str(), 1700000000000000U));
    std::array<uint8_t, 5> data{0x01, 0x60, 'x', 'y', 'z'};
    pal_urb in{};
    in.endpoint = 0x81;
    in.data = data.data();
    in.n_bytes = 64;
    in.short_is_error = true;
    in.status = PAL_HOST_PENDING;
    pal_usbmon_see(&mon, 5, &in, 1);
    pal_urb request{};
    request.endpoint = 0;
    const std::array<uint8_t, 8> setup{0x40, 3, 0x38, 0x41, 0, 0, 0, 0};
    std::copy(setup.begin(), setup.end(), request.setup);
    request.status = PAL_HOST_PENDING;
    pal_usbmon_see(&mon, 5, &request, 1000001);
    request.status = PAL_HOST_STALLED;
    pal_usbmon_see(&mon, 5, &request, 1000002);
    in.status = PAL_HOST_OK;
    in.n_done = 5;
    pal_usbmon_see(&mon, 5, &in, 1000003);
    REQUIRE(pal_usbmon_close(&mon));
    // 1700000000 s are 0x6553F100.
    const auto time = [](unsigned char more_s, char us, size_t n) {
        std::string bytes = hex("00F15365 00000000").substr(0, n);
        bytes[0] = static_cast<char>(more_s);
        return bytes + std::string{us, 0, 0, 0};
    };
    const std::string expected =
        hex("D4C3B2A1 0200 0400 00000000 00000000 00000100 DC000000") +  //
        time(0, 1, 4) + hex("40000000 40000000") +                       //
        hex("0100000000000000 53 03 81 05 0100 2D 3C") + time(0, 1, 8) +
        hex("8DFFFFFF 40000000 00000000 0000000000000000 0000000000000000 01020000 00000000") +
        time(1, 1, 4) + hex("40000000 40000000") +  //
        hex("0200000000000000 53 02 00 05 0100 00 00") + time(1, 1, 8) +
        hex("8DFFFFFF 00000000 00000000 4003384100000000 0000000000000000 00000000 00000000") +
        time(1, 2, 4) + hex("40000000 40000000") +  //
        hex("0200000000000000 43 02 00 05 0100 2D 3E") + time(1, 2, 8) +
        hex("E0FFFFFF 00000000 00000000 0000000000000000 0000000000000000 00000000 00000000") +
        time(1, 3, 4) + hex("45000000 45000000") +  //
        hex("0100000000000000 43 03 81 05 0100 2D 00") + time(1, 3, 8) +
        hex("00000000 05000000 05000000 0000000000000000 0000000000000000 01020000 00000000 016078797A");
    CHECK(file.text() == expected);
}

TEST_CASE("data longer than a record may be are cut, and the record says so") {
    File file;
    pal_usbmon mon{};
    REQUIRE(pal_usbmon_open(&mon, file.name.c_str(), 0));
    std::vector<uint8_t> data(PAL_USBMON_SNAP_BYTES, 'x');
    pal_urb out{};
    out.endpoint = 0x02;
    out.data = data.data();
    out.n_bytes = PAL_USBMON_SNAP_BYTES;
    for (int i = 0; i < 5; ++i) {  // more than there is room for at once
        out.status = PAL_HOST_PENDING;
        pal_usbmon_see(&mon, 5, &out, 1);
    }
    REQUIRE(pal_usbmon_close(&mon));
    const std::string text = file.text();
    REQUIRE(text.size() == 24 + 5 * (16 + 65536));
    CHECK(text.substr(24 + 8, 8) == hex("00000100 40000100"));
    CHECK(text.substr(24 + 16 + 32, 8) == hex("00000100 C0FF0000"));
}

TEST_CASE("a capture into a pipe that nobody reads ends, and holds up nothing") {
    const File file;
    REQUIRE(mkfifo(file.name.c_str(), 0600) == 0);
    const int reader = open(file.name.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    REQUIRE(reader >= 0);
    static pal_usbmon mon;
    REQUIRE(pal_usbmon_open(&mon, file.name.c_str(), 0));
    std::array<uint8_t, 60000> data{};
    pal_urb urb{};
    urb.endpoint = 0x02;
    urb.data = data.data();
    urb.n_bytes = data.size();
    for (int i = 0; i < 6; ++i) {
        urb.status = PAL_HOST_PENDING;
        pal_usbmon_see(&mon, 2, &urb, 0);
    }
    CHECK(mon.failed);
    CHECK_FALSE(pal_usbmon_close(&mon));
    CHECK(mon.reason == EAGAIN);
    close(reader);
}

TEST_CASE("a capture of a run has every transfer, and the driver reads every reply in it", "[process]") {
    const std::string how = GENERATE(as<std::string>{}, "immediate", "frames");
    CAPTURE(how);
    File file;
    const Outcome plain = run({"--timing", how, "--pcap", file.name}, {client("sim_usb_plain"), "60"});
    REQUIRE(plain.words == "plain: 60 exchanges\n");
    const Capture capture(file.name);
    CHECK(capture.pair() == 0);
    CHECK(vendor_requests(capture) == kRequests);
    CHECK(written(capture) == "\nC\rA" + image() + repeated("<AAAAAAAAAAAAAA>", 60));
    const std::string boot = "\nD,\rA" + image();
    const std::string read = payload(capture);
    REQUIRE(read.size() == boot.size() + 60 * 16);
    CHECK(read.substr(0, boot.size()) == boot);
    pal_wire_reader reader{};
    unsigned n_replies = 0;
    for (const char byte : read.substr(boot.size())) {
        if (!pal_wire_feed(&reader, static_cast<uint8_t>(byte))) continue;
        pal_wire_reply reply{};
        CHECK(pal_packet_decode(reader.bytes, &reply));
        ++n_replies;
    }
    CHECK(n_replies == 60);
    CHECK(reader.n_skipped_bytes == 0);
}

TEST_CASE("a capture begins with what a kernel asks a new device", "[process]") {
    File file;
    REQUIRE(run({"--pcap", file.name}, {"true"}).code == 0);
    const Capture capture(file.name);
    REQUIRE(capture.records().size() == 12);
    CHECK(capture.records()[0].setup == hex("80 06 0001 0000 1200"));
    CHECK(capture.records()[1].data.substr(8, 4) == hex("0304 48CB"));
    CHECK(capture.records()[2].setup == hex("80 06 0002 0000 0002"));
    CHECK(capture.records()[10].setup == hex("00 09 0100 0000 0000"));
    for (const Record& r : capture.records()) CHECK(r.address == 2);
}

TEST_CASE("a capture is whole after SIGTERM, with every transfer ended, and can be read after SIGKILL",
          "[process]") {
    const int number = GENERATE(as<int>{}, SIGTERM, SIGKILL);
    CAPTURE(number);
    File file;
    {
        Bus bus({"--timing", "frames", "--pcap", file.name});
        Process program({client("sim_usb_probe"), "endless-async"}, Bus::environment());
        const auto size = [&file] { return std::filesystem::file_size(file.name); };
        for (int ms = 0; size() < 4096 && ms < kLimitMs; ++ms) poll(nullptr, 0, 1);
        bus.process().send(number);
        CHECK(bus.process().wait() == (number == SIGTERM ? 0 : 128 + SIGKILL));
        program.send(SIGKILL);
    }
    const Capture capture(file.name);
    CHECK(capture.records().size() > 30);
    const size_t n_open = capture.pair();
    if (number == SIGTERM) CHECK(n_open == 0);
}

TEST_CASE("a capture that cannot be written is refused with a sentence", "[process]") {
    const Outcome folder = run({"--pcap", "/no/such/folder/a.pcap"}, {"true"});
    CHECK(folder.code == 2);
    CHECK_THAT(folder.words, Contains("--pcap /no/such/folder/a.pcap: ") && Contains("can be written"));
    const Outcome full = run({"--pcap", "/dev/full"}, {"true"});
    CHECK(full.code == 2);
    CHECK_THAT(full.words, Contains("--pcap /dev/full: No space left"));
    const Outcome where = simulator({"status", "--pcap", "/tmp/x"});
    CHECK(where.code == 2);
    CHECK_THAT(where.words, Contains("does not belong here"));
}

}  // namespace
