// mbpoll, a Modbus client by others, as a process of its own.
#include <array>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "tests/host/rig/client.hpp"
#include "tests/lacking.hpp"

using namespace palpate::rig;
using namespace palpate::rig::test;
using Catch::Matchers::Contains;
using palpate::test::mbpoll_is_missing;

namespace {

/// mbpoll while it runs; its output once it has ended.
class Mbpoll {
public:
    Mbpoll(const Server& server, const std::string& options, const std::string& values = "") {
        const std::string line = "mbpoll -m tcp -0 -1 -o 10 " + options + " -p " +
                                 std::to_string(server.port()) + " 127.0.0.1 " + values + " 2>&1";
        pipe_.reset(::popen(line.c_str(), "r"));
    }
    [[nodiscard]] std::string output() {
        std::string text;
        std::array<char, 4096> part{};
        std::size_t n = 0;
        while ((n = std::fread(part.data(), 1, part.size(), pipe_.get())) > 0) text.append(part.data(), n);
        return text;
    }

private:
    struct Close {
        void operator()(std::FILE* pipe) const { ::pclose(pipe); }
    };
    std::unique_ptr<std::FILE, Close> pipe_;
};

/// The value that mbpoll printed for reference `address`: "[6]: \t3.25".
double value_at(const std::string& output, int address) {
    std::string key = "[";
    key.append(std::to_string(address)).append("]:");
    INFO(output);
    const std::size_t at = output.find(key);
    REQUIRE(at != std::string::npos);
    return std::stod(output.substr(at + key.size()));
}

std::string poll(const Server& server, const std::string& options, const std::string& values = "") {
    return Mbpoll(server, options, values).output();
}

}  // namespace

TEST_CASE("mbpoll reads sixteen words from address 0") {
    if (mbpoll_is_missing()) return;
    Rig rig;
    rig.shown.state = 3;
    rig.shown.tick = 65536 + 7;
    const std::string out = poll(rig.server, "-a 1 -t 3 -r 0 -c 16");
    CHECK(value_at(out, 0) == 3);
    CHECK(value_at(out, 2) == 1);
    CHECK(value_at(out, 3) == 7);
    CHECK(value_at(out, 15) == 0);
}

TEST_CASE("mbpoll decodes the floats and counts that were set") {
    if (mbpoll_is_missing()) return;
    Rig rig;
    rig.shown.rate_hz = 999.75F;
    rig.shown.force_n = 3.25F;
    rig.shown.faults = 0x12345;
    rig.shown.stop = 2048;
    rig.shown.n_missed = 70000;
    rig.shown.table_age_ticks = 33;
    rig.shown.depth_m = 0.00390625F;
    rig.shown.k_n_per_m = 812.5F;
    rig.shown.x_m = -0.03125F;
    rig.shown.y_m = 0.0625F;
    rig.shown.z_m = 0.125F;
    const std::string floats = poll(rig.server, "-a 1 -t 3:float -B -r 4 -c 2");
    CHECK(value_at(floats, 4) == 999.75);
    CHECK(value_at(floats, 6) == 3.25);
    const std::string counts = poll(rig.server, "-a 1 -t 3:int -B -r 8 -c 4");
    CHECK(value_at(counts, 8) == 0x12345);
    CHECK(value_at(counts, 10) == 2048);
    CHECK(value_at(counts, 12) == 70000);
    CHECK(value_at(counts, 14) == 33);
    const std::string rest = poll(rig.server, "-a 1 -t 3:float -B -r 16 -c 5");
    CHECK(value_at(rest, 16) == 0.00390625);
    CHECK(value_at(rest, 18) == 812.5);
    CHECK(value_at(rest, 20) == -0.03125);
    CHECK(value_at(rest, 22) == 0.0625);
    CHECK(value_at(rest, 24) == 0.125);
}

TEST_CASE("mbpoll latches the emergency stop and cannot release it") {
    if (mbpoll_is_missing()) return;
    Rig rig;
    CHECK(value_at(poll(rig.server, "-a 1 -t 0 -r 0 -c 1"), 0) == 0);
    CHECK_THAT(poll(rig.server, "-a 1 -t 0 -r 0", "1"), Contains("Written 1 references"));
    CHECK(rig.asked.estop);
    CHECK_THAT(poll(rig.server, "-a 1 -t 0 -r 0", "0"), Contains("Illegal data value"));
    CHECK(rig.asked.estop);
    CHECK(value_at(poll(rig.server, "-a 1 -t 0 -r 0 -c 1"), 0) == 1);
}

TEST_CASE("mbpoll is answered whatever unit id it asks for") {
    if (mbpoll_is_missing()) return;
    Rig rig;
    rig.shown.state = 4;
    const std::string unit = GENERATE(as<std::string>{}, "0", "1", "17", "247", "255");
    CHECK(value_at(poll(rig.server, "-t 3 -r 0 -c 1 -a " + unit), 0) == 4);
}

TEST_CASE("mbpoll is told what is out of range") {
    if (mbpoll_is_missing()) return;
    Rig rig;
    const std::string options =
        GENERATE(as<std::string>{}, "-t 3 -r 26 -c 1", "-t 3 -r 20 -c 7", "-t 0 -r 2 -c 1");
    CHECK_THAT(poll(rig.server, "-a 1 " + options), Contains("Illegal data value"));
}

TEST_CASE("two mbpolls are served at once, beside a silent and a half-open client") {
    if (mbpoll_is_missing()) return;
    Rig rig(PATIENT);
    rig.shown.state = 1;
    const Client silent(rig.server);
    Client half(rig.server);
    CHECK(half.send(hex("00 01 00 00 00 06 01")));
    Mbpoll one(rig.server, "-a 1 -t 3 -r 0 -c 16");
    Mbpoll two(rig.server, "-a 2 -t 3 -r 0 -c 16");
    CHECK(value_at(two.output(), 0) == 1);
    CHECK(value_at(one.output(), 0) == 1);
    CHECK(half.send(hex("04 00 00 00 01")));
    CHECK(half.receive() == hex("00 01 00 00 00 05 01 04 02 00 01"));
}
