/// A plain host whose device has faults, in the text form of them.
#pragma once
#include <catch2/catch.hpp>
#include <string>

#include "tests/sim/plain_host.hpp"

namespace palpate::test {

inline pal_usb_fault fault_of(const std::string& line) {
    pal_usb_fault fault{};
    pal_usb_fault_error error{};
    const int n = pal_usb_faults_parse(line.data(), line.size(), &fault, 1, &error);
    INFO(error.message);
    REQUIRE(n == 1);
    return fault;
}

inline void inject(PlainHost& host, const std::string& line) {
    const pal_usb_fault fault = fault_of(line);
    REQUIRE(pal_usb_device_inject(host.device(), &fault));
}

/// A running device, read with '>' as event character; nothing moves.
inline PlainHost running() {
    PlainHost host(running_device());
    REQUIRE(host.ok());
    host.begin_run();
    host.vendor(0x06, 0x013E);
    return host;
}

inline Bytes exchange(PlainHost& host, uint64_t limit_us = 3000) {
    host.out(ZERO_REQUEST);
    return host.payload(16, limit_us);
}

}  // namespace palpate::test
