// What each kind of fault does to the device.
#include <catch2/catch.hpp>
#include <string>

#include "tests/sim/faulty_host.hpp"

namespace {

using namespace palpate::test;

int encoder(const Bytes& reply, std::size_t axis) {
    REQUIRE(reply.size() == 16);
    unsigned word = 0;
    for (std::size_t n = 0; n < 4; ++n) word |= (reply[1 + 4 * axis + n] - 0x41U) << (4 * n);
    return word >= 0x8000U ? static_cast<int>(word) - 0x10000 : static_cast<int>(word);
}

}  // namespace

TEST_CASE("a dropped byte is one, n are n, and then all is well") {
    PlainHost host = running();
    REQUIRE(exchange(host).size() == 16);
    inject(host, "drop dir=in");
    CHECK(exchange(host).size() == 15);
    CHECK(exchange(host).size() == 16);
    inject(host, "drop dir=in n=16");
    CHECK(exchange(host).empty());
    CHECK(exchange(host).size() == 16);
    inject(host, "drop dir=out");
    CHECK(exchange(host).empty());
    CHECK(host.truth().n_requests == 5);
    CHECK(exchange(host).size() == 16);
    CHECK(host.truth().n_strikes == 18);
}

TEST_CASE("a fault has its time: nothing before, nothing after") {
    PlainHost host = running();
    inject(host, "drop dir=out at_s=0.01 for_s=0.01");
    host.advance_to(9000);
    CHECK(exchange(host, 900).size() == 16);
    host.advance_to(10000);
    CHECK(exchange(host).empty());
    host.advance_to(19700);
    CHECK(exchange(host, 200).empty());
    host.advance_to(20000);
    CHECK(exchange(host).size() == 16);
}

TEST_CASE("a delayed packet comes so much later and is whole") {
    PlainHost host = running();
    inject(host, "delay by_s=0.0123");
    host.out(ZERO_REQUEST);
    const auto late = host.read();
    REQUIRE(late);
    CHECK(late->at_us == 214 + 12300);
    CHECK(late->bytes.size() == 18);
    inject(host, "delay by_s=0.003 n=2");
    for (int i = 0; i < 2; ++i) {
        const uint64_t sent_us = host.now_us();
        REQUIRE(exchange(host, 9000).size() == 16);
        CHECK(host.now_us() >= sent_us + 3000);
    }
    inject(host, "delay by_s=0.005 dir=out");
    const uint64_t begin_us = host.now_us();
    host.out(ZERO_REQUEST);
    auto packet = host.read();
    while (packet && packet->bytes.size() == 2) packet = host.read();
    REQUIRE(packet);
    CHECK(packet->at_us == begin_us + 5214);
}

TEST_CASE("a reply is split after any byte, the rest at once or after a gap") {
    const unsigned byte = GENERATE(as<unsigned>{}, 1, 2, 8, 14, 15);
    const unsigned gap_us = GENERATE(as<unsigned>{}, 0, 700, 2500);
    PlainHost host = running();
    Bytes whole = exchange(host);
    const uint64_t begin_us = host.now_us();
    inject(host,
           "split byte=" + std::to_string(byte) + " gap_s=0." + std::to_string(1000000 + gap_us).substr(1));
    host.out(ZERO_REQUEST);
    const auto first = host.read();
    const auto second = host.read();
    REQUIRE((first && second));
    CHECK(first->at_us == begin_us + 214);
    CHECK(second->at_us == begin_us + 214 + gap_us);
    CHECK(first->bytes.size() == 2 + byte);
    Bytes joined(first->bytes.begin() + 2, first->bytes.end());
    joined.insert(joined.end(), second->bytes.begin() + 2, second->bytes.end());
    CHECK(joined == whole);
}

TEST_CASE("a doubled packet comes twice: a reply to the host, a request to the device") {
    PlainHost host = running();
    inject(host, "duplicate");
    host.out(ZERO_REQUEST);
    const auto first = host.read();
    const auto second = host.read();
    REQUIRE((first && second));
    CHECK(first->bytes == second->bytes);
    CHECK(first->bytes.size() == 18);
    CHECK(host.truth().n_requests == 1);
    inject(host, "duplicate dir=out");
    host.out(ZERO_REQUEST);
    CHECK(host.payload(48, 3000).size() == 32);
    CHECK(host.truth().n_requests == 3);
    inject(host, "duplicate");
    host.out(ZERO_REQUEST);
    REQUIRE(host.payload(16).size() == 16);
    host.purge();  // the second one is still in the chip
    CHECK(host.payload(16, 3000).empty());
}

TEST_CASE("a corrupted byte is another byte, in either direction, the same for the same seed") {
    const auto damaged = [](uint64_t seed) {
        pal_usb_device_config config = running_device();
        config.seed = seed;
        PlainHost host(config);
        host.begin_run();
        host.vendor(0x06, 0x013E);
        const Bytes good = exchange(host);
        inject(host, "corrupt n=3 p=0.5");
        Bytes bad = exchange(host);
        REQUIRE(bad.size() == 16);
        int n_wrong = 0;
        for (std::size_t i = 0; i < 16; ++i) n_wrong += good[i] != bad[i] ? 1 : 0;
        CHECK(n_wrong == 3);
        return bad;
    };
    CHECK(damaged(1) == damaged(1));
    CHECK(damaged(1) != damaged(2));
    PlainHost host = running();
    inject(host, "corrupt dir=out");
    CHECK(exchange(host).empty());  // '<' came as something else
    CHECK(host.truth().n_requests == 0);
}

TEST_CASE("a stalled endpoint stays so until the halt is cleared, and longer when the fault lasts") {
    PlainHost host = running();
    Bytes packet;
    inject(host, "stall ep=in");
    CHECK(host.in(packet) == PAL_USB_STALL);
    CHECK(host.ask(0x82, 0, 0, 0x81, 2) == Bytes{1, 0});
    CHECK(host.control(0x02, 1, 0, 0x81) == 0);
    CHECK(exchange(host).size() == 16);
    inject(host, "stall ep=out for_s=0.01");
    CHECK(host.out({1}) == PAL_USB_STALL);
    CHECK(host.control(0x02, 1, 0, 0x02) == 0);
    CHECK(host.out({1}) == PAL_USB_STALL);
    host.wait(10000);
    CHECK(host.control(0x02, 1, 0, 0x02) == 0);
    CHECK(exchange(host).size() == 16);
    inject(host, "stall ep=control");
    CHECK(host.vendor(0x09, 1) == PAL_USB_STALL);
    CHECK(host.vendor(0x09, 1) == 0);
}

TEST_CASE("an unplugged device is gone, and comes back with nothing but its EEPROM") {
    const bool keeps = GENERATE(as<bool>{}, false, true);
    pal_usb_device_config config = running_device();
    config.unplug_keeps_firmware = keeps;
    PlainHost host(config);
    host.begin_run();
    host.set_dtr(true);
    host.vendor(0x91, 0xBEEF, 62);
    host.set_dtr(false);
    host.out(bytes_of("<AAABAAABAAABAA>"));
    host.wait(3000);
    CHECK(host.truth().motor_counts[0] == 4096 - 1);
    inject(host, "unplug at_s=0.01 for_s=0.2");
    host.advance_to(9999);
    CHECK(pal_usb_device_present(host.device()));
    host.out(ZERO_REQUEST);
    host.advance_to(10000);
    Bytes packet;
    CHECK_FALSE(pal_usb_device_present(host.device()));
    CHECK(host.in(packet) == PAL_USB_GONE);
    CHECK(host.out(ZERO_REQUEST) == PAL_USB_GONE);
    CHECK(host.vendor(0x09, 1) == PAL_USB_GONE);
    CHECK(pal_usb_device_next_us(host.device()) == 210000);
    host.advance_to(209999);
    CHECK_FALSE(pal_usb_device_present(host.device()));
    for (const int16_t word : host.truth().motor_counts) CHECK(word == 0);
    host.advance_to(210000);
    CHECK(pal_usb_device_present(host.device()));
    CHECK(host.truth().baud == 9600);
    CHECK(host.truth().latency_ms == 16);
    CHECK(host.ask(0xC0, 0x90, 0, 62, 2) == Bytes{0xEF, 0xBE});
    CHECK(host.truth().running == keeps);
    CHECK(host.read() == Packet{226000, {0x01, 0x60}});
    host.begin_run();
    CHECK(exchange(host).size() == (keeps ? 16U : 0U));
    CHECK(host.boot(boot_image(3)));
    CHECK(exchange(host).size() == 16);
}

TEST_CASE("without supply the bridge lives, motors and firmware do not, and the next boot begins anew") {
    PlainHost host = running();
    host.out(bytes_of("<AAABAAABAAABAA>"));
    host.wait(3000);
    CHECK(host.truth().motor_counts[0] == 4095);
    inject(host, "power-out at_s=0.005 for_s=0.1");
    host.advance_to(5000);
    CHECK(pal_usb_device_present(host.device()));
    CHECK_FALSE(host.truth().powered);
    for (const int16_t word : host.truth().motor_counts) CHECK(word == 0);
    static_cast<void>(host.payload(16, 1500));
    CHECK(exchange(host).empty());
    host.begin_boot();
    host.out({0x0A, 0x43, 0x0D});
    CHECK(host.payload(4, 30000).empty());
    host.advance_to(105000);
    CHECK(host.truth().powered);
    host.set_dtr(false);
    host.begin_run();
    CHECK(exchange(host).empty());
    CHECK(host.boot(boot_image(3)));
    CHECK(exchange(host).size() == 16);
    CHECK(host.truth().n_boots == 2);
}

TEST_CASE("a boot fails at each stage as often as the fault says, and then succeeds") {
    const int stage = GENERATE(as<int>{}, 1, 2, 3, 4, 5, 6, 7);
    const int n = GENERATE(as<int>{}, 1, 2);
    const int byte = stage == 5 || stage == 6 ? GENERATE(as<int>{}, 0, 1, 17, 99, 129) : 0;
    PlainHost host(still_device());
    inject(host, "boot-fail stage=" + std::to_string(stage) + " n=" + std::to_string(n) +
                     " byte=" + std::to_string(byte));
    for (int i = 0; i < n; ++i) {
        const bool echoed = host.boot(boot_image(50));
        CHECK(echoed == (stage == 7));
        CHECK_FALSE(host.truth().running);
    }
    CHECK(host.boot(boot_image(50)));
    CHECK(host.truth().running);
    CHECK(host.truth().n_strikes == static_cast<unsigned>(n));
}

TEST_CASE("a frozen encoder tells the old place while the fault lasts, the others tell the true one") {
    pal_usb_device_config config = running_device();
    config.hand.push = [](const void*, const double*, const double*, double force_n[3]) {
        force_n[0] = 1;
        force_n[1] = 2;
        force_n[2] = 4;
    };
    PlainHost host(config);
    host.begin_run();
    const Bytes before = exchange(host);
    inject(host, "freeze axis=2 for_s=0.05");
    host.wait(40000);
    const Bytes during = exchange(host);
    host.wait(10000);
    const Bytes after = exchange(host);
    CHECK(encoder(during, 1) == encoder(before, 1));
    CHECK(encoder(during, 0) != encoder(before, 0));
    CHECK(encoder(during, 2) != encoder(before, 2));
    CHECK(encoder(after, 1) != encoder(before, 1));
}

TEST_CASE("a counter jumps by so many counts and stays there") {
    PlainHost host = running();
    const Bytes before = exchange(host);
    inject(host, "jump axis=3 counts=-77");
    for (int i = 0; i < 2; ++i) {
        const Bytes after = exchange(host);
        CHECK(encoder(after, 0) == encoder(before, 0));
        CHECK(encoder(after, 1) == encoder(before, 1));
        CHECK(encoder(after, 2) == encoder(before, 2) - 77);
    }
    inject(host, "jump counts=5");
    CHECK(encoder(exchange(host), 0) == encoder(before, 0) + 5);
}

TEST_CASE("a babbling device says bytes that nobody asked for, at its pace and for its time") {
    PlainHost host = running();
    inject(host, "babble length=10 every_s=0.002 for_s=0.01");
    Bytes all;
    while (host.now_us() < 20000) {
        const auto packet = host.read();
        REQUIRE(packet);
        all.insert(all.end(), packet->bytes.begin() + 2, packet->bytes.end());
    }
    CHECK(all.size() == 50);
    CHECK(exchange(host).size() == 16);
    inject(host, "power-out for_s=1");
    inject(host, "babble");
    CHECK(host.payload(1, 5000).empty());
}

TEST_CASE("whatever goes wrong at whatever time of a boot, the boot after it succeeds") {
    const std::string fault = GENERATE(
        as<std::string>{}, "drop dir=in", "drop dir=out", "drop dir=both n=40", "delay by_s=0.04",
        "delay by_s=0.04 dir=out", "split byte=1", "split byte=1 gap_s=0.02", "duplicate",
        "duplicate dir=out", "corrupt", "corrupt dir=out n=5", "stall", "stall ep=out", "stall ep=control",
        "unplug for_s=0.02", "power-out for_s=0.02", "babble length=30", "slow-host for_s=0.02",
        "freeze for_s=0.1", "jump", "boot-fail stage=5 byte=70", "boot-fail stage=7");
    int n_failed = 0;
    for (uint64_t at_us = 0; at_us < 100000; at_us += 1237) {
        PlainHost host(still_device());
        pal_usb_fault one = fault_of(fault);
        one.at_us = at_us;
        REQUIRE(pal_usb_device_inject(host.device(), &one));
        n_failed += host.boot(boot_image(200)) && host.truth().running ? 0 : 1;
        host.wait(200000);  // what still comes late has come
        host.control(0x02, 1, 0, 0x81);
        host.control(0x02, 1, 0, 0x02);
        pal_usb_device_heal(host.device());
        REQUIRE(host.boot(boot_image(200)));
        REQUIRE(exchange(host).size() == 16);
    }
    CAPTURE(fault, n_failed);
    const bool harmless = fault.find("freeze") == 0 || fault.find("jump") == 0 || fault.find("split") == 0 ||
                          fault.find("delay") == 0;  // this host is patient
    CHECK((n_failed > 0) == !harmless);
}

TEST_CASE("healing ends all faults, and the plug and the supply are in again") {
    PlainHost host = running();
    inject(host, "unplug for_s=1000");
    inject(host, "power-out for_s=1000");
    inject(host, "slow-host for_s=1000");
    inject(host, "stall at_s=0.001");
    inject(host, "corrupt for_s=1000 dir=both");
    host.wait(5000);
    CHECK_FALSE(pal_usb_device_present(host.device()));
    pal_usb_device_heal(host.device());
    CHECK(pal_usb_device_present(host.device()));
    CHECK(host.truth().powered);
    CHECK(host.boot(boot_image(3)));
    CHECK(exchange(host).size() == 16);
}

TEST_CASE("faults come with the configuration, and places of ended ones are used again") {
    const pal_usb_fault first = fault_of("drop dir=in n=16");
    pal_usb_device_config config = running_device();
    config.faults = &first;
    config.n_faults = 1;
    PlainHost host(config);
    REQUIRE(host.ok());
    host.begin_run();
    CHECK(exchange(host).empty());
    CHECK(exchange(host).size() == 16);
    for (int i = 0; i < 3 * PAL_USB_FAULTS_MAX; ++i) inject(host, "jump");
    pal_usb_fault bad = first;
    bad.per_million = 1000001;
    CHECK_FALSE(pal_usb_device_inject(host.device(), &bad));
    for (int i = 0; i < PAL_USB_FAULTS_MAX; ++i) inject(host, "drop at_s=9");
    CHECK_FALSE(pal_usb_device_inject(host.device(), &first));
}

TEST_CASE("autobaud that fails now and then makes the boot flaky, as often as the seeds say") {
    int n_booted = 0;
    for (uint64_t seed = 1; seed <= 40; ++seed) {
        pal_usb_device_config config = still_device();
        config.seed = seed;
        config.loader.autobaud_fail_per_million = 500000;
        PlainHost fast(config);
        n_booted += fast.boot(boot_image(3)) ? 1 : 0;
        PlainHost slow(config);
        CHECK(slow.boot(boot_image(3), 0xC034));
    }
    CHECK(n_booted > 5);
    CHECK(n_booted < 35);
}
