// What ends faults, and faults that meet.
#include <catch2/catch.hpp>

#include "tests/sim/faulty_host.hpp"

using namespace palpate::test;

TEST_CASE("healing lets go at once what a fault held back") {
    const bool instant = GENERATE(as<bool>{}, false, true);
    pal_usb_device_config config = running_device();
    config.instant = instant;
    PlainHost host(config);
    host.begin_run();
    host.vendor(0x06, 0x013E);
    SECTION("the rest of a split packet") {
        inject(host, "split byte=5 gap_s=1000");
        host.out(ZERO_REQUEST);
        REQUIRE(host.payload(5).size() == 5);
        REQUIRE(host.payload(11, 50000).empty());
        pal_usb_device_heal(host.device());
        CHECK(host.payload(11, 2000).size() == 11);
    }
    SECTION("a delayed packet") {
        inject(host, "delay by_s=1000");
        host.out(ZERO_REQUEST);
        REQUIRE(host.payload(16, 50000).empty());
        pal_usb_device_heal(host.device());
        CHECK(host.payload(16, 2000).size() == 16);
    }
    SECTION("a delayed request") {
        inject(host, "delay by_s=1000 dir=out");
        host.out(ZERO_REQUEST);
        REQUIRE(host.payload(16, 50000).empty());
        pal_usb_device_heal(host.device());
        CHECK(host.payload(16, 2000).size() == 16);
    }
    CHECK(exchange(host).size() == 16);
}

TEST_CASE("healing during a delay keeps a byte that is on the line already as long there as it takes") {
    PlainHost host(still_device());
    host.out({1, 2});  // 1041.7 us each at 9600 baud
    inject(host, "delay by_s=1000 dir=out");
    host.out({3});
    host.wait(500);
    pal_usb_device_heal(host.device());
    host.wait(3 * 1042 - 500 - 3);
    CHECK(host.ask(0xC0, 0x05, 0, 0, 2) == Bytes{0x01, 0x20});  // the last one is on its way
    host.wait(6);
    CHECK(host.ask(0xC0, 0x05, 0, 0, 2) == Bytes{0x01, 0x60});
}

TEST_CASE("of two boot failures each comes at its own stage, in whatever order they are written") {
    const bool turned = GENERATE(as<bool>{}, false, true);
    const std::string early = GENERATE(as<std::string>{}, "boot-fail stage=1", "boot-fail stage=3");
    const std::string late = GENERATE(as<std::string>{}, "boot-fail stage=5 byte=40", "boot-fail stage=7");
    CAPTURE(early, late, turned);
    PlainHost host(still_device());
    inject(host, turned ? late : early);
    inject(host, turned ? early : late);
    const Bytes image = boot_image(10);
    CHECK_FALSE(host.boot(image));
    CHECK(host.truth().n_strikes == 1);  // the early one: the boot did not come as far as the late one
    CHECK(host.boot(image) == (late == "boot-fail stage=7"));
    CHECK(host.truth().n_strikes == 2);
    // Who echoes a byte wrong starts what it took all the same.
    CHECK(host.truth().dsp == (late == "boot-fail stage=7" ? PAL_DSP_MUTE : PAL_DSP_RUN));
    CHECK(host.boot(image));
    host.wait(1000);
    CHECK(host.truth().running);
}

TEST_CASE("a boot failure of one byte comes before that of the container's end") {
    PlainHost host(still_device());
    inject(host, "boot-fail stage=7");
    inject(host, "boot-fail stage=6 byte=49");  // the last one
    const Bytes image = boot_image(10);
    REQUIRE(image.size() == 52 - 2);
    CHECK_FALSE(host.boot(image));  // the last echo is missing
    CHECK(host.boot(image));
    CHECK(host.truth().dsp == PAL_DSP_MUTE);
    CHECK(host.truth().n_strikes == 2);
}

TEST_CASE("a fault may begin a million seconds from now, whenever now is") {
    PlainHost host(running_device());
    host.advance_to(5000000);
    const pal_usb_fault late = fault_of("drop at_s=1000000");
    CHECK(pal_usb_device_inject_now(host.device(), &late));
    const pal_usb_fault soon = fault_of("drop at_s=0.001");
    CHECK(pal_usb_device_inject_now(host.device(), &soon));
    host.begin_run();
    host.vendor(0x06, 0x013E);
    CHECK(exchange(host, 900).size() == 16);
    host.advance_to(5001000);
    CHECK(exchange(host).size() == 15);
    CHECK(exchange(host).size() == 16);
}

TEST_CASE("a purge that is refused purges nothing") {
    PlainHost host = running();
    inject(host, "duplicate");
    host.out(ZERO_REQUEST);
    REQUIRE(host.payload(16).size() == 16);
    CHECK(host.control(0x40, 0x00, 3, 0) == PAL_USB_STALL);
    CHECK(host.control(0xC0, 0x00, 0, 0) == PAL_USB_STALL);
    CHECK(host.payload(16, 3000).size() == 16);  // the same once more
}
