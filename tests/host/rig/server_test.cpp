#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "common/tick.h"
#include "tests/host/rig/client.hpp"

using namespace palpate::rig;
using namespace palpate::rig::test;
using Catch::Matchers::Contains;

namespace {

const Bytes READ_STATE = hex("00 01 00 00 00 06 01 04 00 00 00 01");
const Bytes ESTOP_ON = hex("00 02 00 00 00 06 01 05 00 00 FF 00");
const Bytes ESTOP_OFF = hex("00 03 00 00 00 06 01 05 00 00 00 00");
const Bytes READ_COILS = hex("00 04 00 00 00 06 01 01 00 00 00 02");

Bytes state_answer(std::uint8_t state) {
    return hex("00 01 00 00 00 05 01 04 02 00") + Bytes{state};
}

std::string refusal(const std::string& address) {
    Shown shown;
    Asked asked;
    try {
        const Server server(address, shown, asked);
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

}  // namespace

TEST_CASE("every unit id is answered and comes back") {
    Rig rig;
    rig.shown.state = 5;
    Client client(rig.server);
    for (int unit = 0; unit < 256; ++unit) {
        Bytes request = READ_STATE;
        Bytes answer = state_answer(5);
        request[6] = answer[6] = static_cast<std::uint8_t>(unit);
        CHECK(client.ask(request) == answer);
    }
}

TEST_CASE("the emergency stop is asked for before the answer is sent, and stays") {
    Rig rig;
    Client client(rig.server);
    CHECK(client.ask(ESTOP_OFF) == ESTOP_OFF);  // nothing to release yet
    CHECK_FALSE(rig.asked.estop);
    CHECK(client.ask(ESTOP_ON) == ESTOP_ON);
    CHECK(rig.asked.estop);
    CHECK(client.ask(ESTOP_OFF) == hex("00 03 00 00 00 03 01 85 03"));
    CHECK(client.ask(hex("00 05 00 00 00 08 01 0F 00 00 00 02 01 00")) == hex("00 05 00 00 00 03 01 8F 03"));
    CHECK(rig.asked.estop);
    CHECK(rig.asked.enable);  // the refused request changed nothing at all
    CHECK(client.ask(READ_COILS) == hex("00 04 00 00 00 04 01 01 01 03"));
    CHECK(Client(rig.server).ask(READ_COILS) == hex("00 04 00 00 00 04 01 01 01 03"));
}

TEST_CASE("an emergency stop that another operator asked for is shown and cannot be released") {
    Rig rig;
    rig.shown.stop = PAL_FAULT_ESTOP;
    Client client(rig.server);
    CHECK(client.ask(READ_COILS) == hex("00 04 00 00 00 04 01 01 01 03"));
    CHECK(client.ask(ESTOP_OFF) == hex("00 03 00 00 00 03 01 85 03"));
}

TEST_CASE("forces can be switched off and on again") {
    Rig rig;
    Client client(rig.server);
    const Bytes off = hex("00 01 00 00 00 06 01 05 00 01 00 00");
    CHECK(client.ask(off) == off);
    CHECK_FALSE(rig.asked.enable);
    CHECK(client.ask(hex("00 01 00 00 00 08 01 0F 00 01 00 01 01 01")) ==
          hex("00 01 00 00 00 06 01 0F 00 01 00 01"));
    CHECK(rig.asked.enable);
    CHECK_FALSE(rig.asked.estop);
}

TEST_CASE("what is out of range gets exception 03, an unknown function 01, and neither changes a thing") {
    struct Case {
        const char* request;
        const char* answer;
    };
    const Case c = GENERATE(values<Case>({
        {"00 01 00 00 00 06 01 04 00 1A 00 01", "00 01 00 00 00 03 01 84 03"},  // first word behind the map
        {"00 01 00 00 00 06 01 04 00 00 00 1B", "00 01 00 00 00 03 01 84 03"},  // one word too many
        {"00 01 00 00 00 06 01 04 FF FF 00 01", "00 01 00 00 00 03 01 84 03"},
        {"00 01 00 00 00 06 01 04 FF FF FF FF", "00 01 00 00 00 03 01 84 03"},
        {"00 01 00 00 00 06 01 04 00 00 00 00", "00 01 00 00 00 03 01 84 03"},  // no words
        {"00 01 00 00 00 04 01 04 00 00", "00 01 00 00 00 03 01 84 03"},        // too short a frame
        {"00 01 00 00 00 06 01 01 00 02 00 01", "00 01 00 00 00 03 01 81 03"},  // no such coil
        {"00 01 00 00 00 06 01 05 00 02 FF 00", "00 01 00 00 00 03 01 85 03"},
        {"00 01 00 00 00 06 01 05 00 00 00 01", "00 01 00 00 00 03 01 85 03"},  // neither on nor off
        {"00 01 00 00 00 06 01 05 00 00 FF FF", "00 01 00 00 00 03 01 85 03"},
        {"00 01 00 00 00 08 01 0F 00 00 00 03 01 07", "00 01 00 00 00 03 01 8F 03"},  // one coil too many
        {"00 01 00 00 00 08 01 0F 00 00 00 02 02 03", "00 01 00 00 00 03 01 8F 03"},  // byte count is wrong
        {"00 01 00 00 00 09 01 0F 00 00 00 02 02 03 03", "00 01 00 00 00 03 01 8F 03"},
        {"00 01 00 00 00 02 01 0F", "00 01 00 00 00 03 01 8F 03"},
        {"00 01 00 00 00 06 01 03 00 00 00 01", "00 01 00 00 00 03 01 83 01"},  // holding registers
        {"00 01 00 00 00 06 01 06 00 00 00 01", "00 01 00 00 00 03 01 86 01"},
        {"00 01 00 00 00 02 01 7F", "00 01 00 00 00 03 01 FF 01"},
    }));
    Rig rig;
    Client client(rig.server);
    INFO(c.request);
    CHECK(client.ask(hex(c.request)) == hex(c.answer));
    CHECK_FALSE(rig.asked.estop);
    CHECK(rig.asked.enable);
    CHECK(client.ask(READ_STATE) == state_answer(0));  // the stream is still in step
}

TEST_CASE("requests may come in single bytes or many at once") {
    Rig rig(PATIENT);
    rig.shown.state = 2;
    Client client(rig.server);
    for (const std::uint8_t byte : READ_STATE) CHECK(client.send({byte}));
    CHECK(client.receive() == state_answer(2));
    Bytes many;
    for (int i = 0; i < 50; ++i) many = many + READ_STATE;
    CHECK(client.send(many + Bytes(READ_STATE.begin(), READ_STATE.begin() + 5)));
    for (int i = 0; i < 50; ++i) CHECK(client.receive() == state_answer(2));
    CHECK(client.send(Bytes(READ_STATE.begin() + 5, READ_STATE.end())));
    CHECK(client.receive() == state_answer(2));
}

// A server that waits for the half frame answers the polls only after it has given that client up: then the
// half frame could not be completed. The order of events decides, not a clock.
TEST_CASE("a client that stops in mid-frame keeps no other client waiting") {
    Rig rig(PATIENT);
    const std::size_t n_sent = GENERATE(as<std::size_t>{}, 1, 5, 7, 8, 11);
    Client silent(rig.server);
    Client half(rig.server);
    Client polling(rig.server);
    CHECK(half.send(Bytes(READ_STATE.begin(), READ_STATE.begin() + static_cast<std::ptrdiff_t>(n_sent))));
    for (std::uint32_t i = 0; i < 1000; ++i) {
        rig.shown.state = i % 6;
        REQUIRE(polling.ask(READ_STATE) == state_answer(static_cast<std::uint8_t>(i % 6)));
    }
    CHECK(polling.ask(ESTOP_ON) == ESTOP_ON);
    CHECK(rig.asked.estop);
    CHECK(half.send(Bytes(READ_STATE.begin() + static_cast<std::ptrdiff_t>(n_sent), READ_STATE.end())));
    CHECK(half.receive() == state_answer(999 % 6));
    CHECK(silent.ask(READ_STATE) == state_answer(999 % 6));
}

TEST_CASE("a frame that is not completed in time costs its client the connection, silence does not") {
    Rig rig({.n_clients = 16, .frame_timeout_ms = 20});
    Client silent(rig.server);
    Client half(rig.server);
    CHECK(half.send(hex("00 01 00 00 00 06 01")));
    CHECK(half.receive().empty());
    CHECK(silent.ask(READ_STATE) == state_answer(0));
}

TEST_CASE("a client that never reads its answers is dropped, and the others are served") {
    Rig rig;
    Client deaf(rig.server);
    Client polling(rig.server);
    const Bytes read_all = hex("00 01 00 00 00 06 01 04 00 00 00 1A");
    Bytes many;
    for (int i = 0; i < 1000; ++i) many = many + read_all;
    while (deaf.send(many)) CHECK(polling.ask(READ_STATE) == state_answer(0));
    CHECK(polling.ask(READ_STATE) == state_answer(0));
}

TEST_CASE("bytes that are not Modbus cost only their sender the connection") {
    Rig rig(PATIENT);
    Client polling(rig.server);
    for (std::uint32_t seed = 1; seed <= 200; ++seed) {
        Client noisy(rig.server);
        std::uint32_t x = seed;  // xorshift32
        Bytes noise(300);
        for (auto& byte : noise) {
            x ^= x << 13;
            x ^= x >> 17;
            x ^= x << 5;
            byte = static_cast<std::uint8_t>(x >> 24);
        }
        noise[2] = 1;  // never protocol 0
        noisy.send(noise);
        INFO("seed " << seed);
        CHECK(noisy.receive().empty());
        CHECK(polling.ask(READ_STATE) == state_answer(0));
    }
    CHECK_FALSE(rig.asked.estop);
}

TEST_CASE("one client too many takes the place of the one silent longest") {
    Rig rig({.n_clients = 3, .frame_timeout_ms = PATIENT.frame_timeout_ms});
    Client first(rig.server);
    CHECK(first.ask(READ_STATE) == state_answer(0));
    Client second(rig.server);
    CHECK(second.ask(READ_STATE) == state_answer(0));
    Client third(rig.server);
    CHECK(third.ask(READ_STATE) == state_answer(0));
    CHECK(first.ask(READ_STATE) == state_answer(0));
    Client fourth(rig.server);
    CHECK(fourth.ask(ESTOP_ON) == ESTOP_ON);
    CHECK(second.ask(READ_STATE).empty());
    CHECK(first.ask(READ_STATE) == state_answer(0));
    CHECK(third.ask(READ_STATE) == state_answer(0));
}

TEST_CASE("the server ends while clients are connected, and its port can be served again") {
    Rig first(PATIENT);
    auto server = std::make_unique<Server>("localhost:0", first.shown, first.asked, PATIENT);
    const std::string address = "127.0.0.1:" + std::to_string(server->port());
    Client silent(*server);
    Client half(*server);
    CHECK(half.ask(READ_STATE) == state_answer(0));
    CHECK(half.send(hex("00 01 00")));
    server.reset();
    CHECK(half.receive().empty());
    CHECK(silent.receive().empty());
    const Server again(address, first.shown, first.asked);
    CHECK(Client(again).ask(READ_STATE) == state_answer(0));
}

TEST_CASE("only loopback addresses are served") {
    const std::string address = GENERATE(as<std::string>{}, "0.0.0.0:0", "192.168.1.1:1502", "128.0.0.1:1502",
                                         "example.org:1502", "127.0.0:1502", ":1502", "[::1]:1502");
    CHECK_THAT(refusal(address), Contains("'" + address + "' is not a loopback address"));
}

TEST_CASE("an address that cannot be read is refused with what would be right") {
    CHECK_THAT(refusal("127.0.0.1"), Contains("is not ADDR:PORT; 127.0.0.1:1502 would be right"));
    const std::string port = GENERATE(as<std::string>{}, "", "65536", "-1", "x", "1502x", " 1502");
    CHECK_THAT(refusal("127.0.0.1:" + port), Contains("has no port from 0 to 65535"));
}

TEST_CASE("a port that is taken is refused in words") {
    const Rig rig;
    const std::string address = "127.0.0.1:" + std::to_string(rig.server.port());
    CHECK_THAT(refusal(address),
               Contains("cannot listen on " + address) && Contains("another program has this port"));
}
