#include "sim/usb/bus.h"

#include <array>
#include <catch2/catch.hpp>
#include <memory>

TEST_CASE("a device that is plugged in again gets an address that no other has, however often") {
    const std::array<pal_usb_device_config, 2> configs = {pal_usb_device_config_default(),
                                                          pal_usb_device_config_default()};
    const auto bus = std::make_unique<pal_bus>();
    uint32_t bad = 0;
    REQUIRE(pal_bus_init(bus.get(), configs.data(), 2, PAL_HOST_FRAMES, 1, &bad));
    REQUIRE(pal_bus_look(bus.get(), 0) == 1);
    REQUIRE(pal_bus_look(bus.get(), 1) == 1);
    const uint32_t stays = bus->ports[0].number;
    pal_usb_fault unplug = pal_usb_fault_of(PAL_USB_FAULT_UNPLUG);
    unplug.for_us = 1000000;
    for (int i = 0; i < 300; ++i) {
        const uint32_t before = bus->ports[1].number;
        REQUIRE(pal_usb_device_inject(&bus->ports[1].device, &unplug));
        REQUIRE(pal_bus_look(bus.get(), 1) == -1);
        pal_usb_device_heal(&bus->ports[1].device);
        REQUIRE(pal_bus_look(bus.get(), 1) == 1);
        const uint32_t now = bus->ports[1].number;
        REQUIRE(now != stays);
        REQUIRE(now != before);
        REQUIRE(now >= 2);  // 1 is the root hub
        REQUIRE(now <= 127);
    }
}
