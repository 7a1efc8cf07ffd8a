// The device model before unmodified libusb, with umockdev between them. Nothing of sim/usb is on the path.
#include <catch2/catch.hpp>
#include <memory>
#include <string>

#include "tests/sim/process.hpp"
#include "tests/sim/umockdev/usbfs.hpp"

namespace {

using usbtest::Outcome;

/// Runs a program where umockdev's devices are the only ones.
Outcome under_umockdev(std::vector<std::string> program) {
    program.insert(program.begin(), PAL_UMOCKDEV_WRAPPER);
    return usbtest::call(std::move(program));
}

std::unique_ptr<pal_usb_device> device(const char* fault = "") {
    auto made = std::make_unique<pal_usb_device>();
    const pal_usb_device_config config = pal_usb_device_config_default();
    REQUIRE(pal_usb_device_init(made.get(), &config));
    pal_usb_fault parsed;
    pal_usb_fault_error error{};
    const std::string text = fault;
    const int n = pal_usb_faults_parse(text.data(), text.size(), &parsed, 1, &error);
    INFO(error.message);
    REQUIRE(n >= 0);
    if (n == 1) REQUIRE(pal_usb_device_inject(made.get(), &parsed));
    return made;
}

}  // namespace

TEST_CASE("libusb under umockdev reads the descriptors and strings of an FT232R in the Falcon's name") {
    const auto falcon = device();
    Usbfs usbfs(*falcon);
    const Outcome outcome = under_umockdev({PAL_CLIENT_LIST});
    CHECK(outcome.words ==
          "0403:cb48 release 0600 speed 2 product \"FALCON HAPTIC\" serial \"PALSIM01\""
          " endpoint 81 bulk 64 endpoint 02 bulk 64\n");
    CHECK(outcome.code == 0);
    CHECK(usbfs.refused() == "");
}

TEST_CASE("a plain libusb program under umockdev boots the device and has an answer to each packet") {
    const auto falcon = device();
    Usbfs usbfs(*falcon);
    for (uint32_t run = 1; run <= 2; ++run) {
        const Outcome outcome = under_umockdev({PAL_CLIENT_PLAIN, "60"});
        CHECK(outcome.words == "plain: 60 exchanges\n");
        CHECK(outcome.code == 0);
        const pal_usb_device_truth truth = usbfs.truth();
        CHECK(truth.running);
        CHECK(truth.n_boots == run);
        CHECK(truth.n_requests == 60 * run);
        CHECK(truth.n_replies == 60 * run);
        CHECK(truth.baud == 1500000);
        CHECK(truth.latency_ms == 1);
        CHECK_FALSE(truth.dtr);
    }
    CHECK(usbfs.refused() == "");
}

TEST_CASE("what fails in the device fails in the program under umockdev") {
    struct Case {
        const char* fault;
        const char* words;
        bool runs;  ///< in the end: a wrong echo does not keep the ROM from starting what it took
    };
    const auto [fault, words, runs] =
        GENERATE(Case{"boot-fail stage=2", "plain: the PIC's answer", false},
                 Case{"boot-fail stage=5 byte=7", "plain: the echo of the image", true},
                 Case{"stall ep=out at_s=0.005", "plain: write: LIBUSB_ERROR_PIPE", false});
    const auto falcon = device(fault);
    Usbfs usbfs(*falcon);
    const Outcome outcome = under_umockdev({PAL_CLIENT_PLAIN, "60"});
    INFO(fault);
    CHECK(outcome.words.rfind(words, 0) == 0);
    CHECK(outcome.code == 1);
    CHECK(usbfs.truth().running == runs);
}
