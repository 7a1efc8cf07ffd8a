// palpate-loop on a Falcon on the USB, with this test as its host.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "common/link.h"
#include "common/state_ring.h"
#include "tests/firmware/usb_bench.hpp"

using namespace usbbench;
using usbtest::Bus;
using usbtest::Process;

namespace {

/// The host's side of a link: beats while it looks, reads all records.
class Host {
public:
    Host() {
        const int file = shm_open(name_.c_str(), O_CREAT | O_EXCL | O_RDWR, 0600);
        REQUIRE(file >= 0);
        REQUIRE(ftruncate(file, sizeof(pal_link)) == 0);
        void* at = mmap(nullptr, sizeof(pal_link), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
        close(file);
        REQUIRE(at != MAP_FAILED);
        link_ = static_cast<pal_link*>(at);
        pal_link_init(link_, 7);
        pal_link_store(&link_->host.enable, 1);
    }
    ~Host() {
        munmap(link_, sizeof(pal_link));
        shm_unlink(name_.c_str());
    }
    Host(const Host&) = delete;
    Host& operator=(const Host&) = delete;
    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] pal_link& link() { return *link_; }
    void enable(bool on) { pal_link_store(&link_->host.enable, on ? 1 : 0); }
    /// Until the loop's newest record is of this state; false after a limit that no healthy run reaches.
    bool comes_to(std::uint32_t state) {
        for (int look = 0; look < 8000; ++look) {
            pal_link_store(&link_->host.heartbeat, ++beat_);
            pal_tick record{};
            while (pal_state_ring_read(&link_->ticks, &reader_, &record)) {
                newest_ = record;
                faults_seen_ |= record.faults;
            }
            if (newest_.tick != 0 && newest_.state == state) return true;
            poll(nullptr, 0, 2);
        }
        return false;
    }
    [[nodiscard]] std::uint32_t tick() const { return newest_.tick; }
    [[nodiscard]] std::uint32_t faults_seen() const { return faults_seen_; }

private:
    std::string name_ = "/palpate-usb-" + std::to_string(getpid());
    pal_link* link_ = nullptr;
    pal_state_reader reader_{};
    pal_tick newest_{};
    std::uint32_t beat_ = 0, faults_seen_ = 0;
};

}  // namespace

TEST_CASE(
    "palpate-loop boots a Falcon, survives its unplugging, and pushes again only when the operator says so",
    "[process]") {
    const Folder folder;
    // Answers in every tick: a simulated device would be let back in after 200 of them.
    const Bus bus(
        {"--timing", "immediate", "--grip", "firm", "--path", folder.path(), "--ramp-ticks", "100"});
    Host host;
    Process loop({usbtest::client("palpate-loop"), "--link", host.name(), "--device", "usb:PALSIM01",
                  "--firmware", folder.firmware(), "--ramp-ticks", "20"},
                 Bus::environment());
    REQUIRE(host.comes_to(PAL_STATE_ENABLED));
    CHECK((host.faults_seen() & PAL_FAULT_DEVICE_LOST) == 0);
    CHECK(device_status()["boots"] == 1);
    fault("unplug at_s=0 for_s=0.2");
    REQUIRE(host.comes_to(PAL_STATE_FAULT));
    CHECK((host.faults_seen() & PAL_FAULT_DEVICE_LOST) != 0);
    // Back, booted and homed: the stop stays.
    for (bool homed = false; !homed;) {
        REQUIRE(host.comes_to(PAL_STATE_FAULT));
        const json device = device_status();
        homed = device["boots"] == 2 && device["homed"] == true;
    }
    for (const std::uint32_t then = host.tick(); host.tick() < then + 500;) {
        poll(nullptr, 0, 2);
        REQUIRE(host.comes_to(PAL_STATE_FAULT));
    }
    host.enable(false);
    REQUIRE(host.comes_to(PAL_STATE_PAUSED));
    host.enable(true);
    REQUIRE(host.comes_to(PAL_STATE_ENABLED));
    pal_link_store(&host.link().host.stop, 1);
    const std::string words = loop.words();
    INFO(words);
    CHECK(loop.wait() == 0);
    CHECK(times_in(words, "The Falcon was unplugged") == 1);
    CHECK(times_in(words, "Falcon PALSIM01 is back") == 1);
    CHECK(at_rest(device_status()));
    CHECK(device_status()["open"] == 0);
}

TEST_CASE("palpate-loop says why a Falcon cannot be had", "[process]") {
    const Folder folder;
    Host host;
    const auto loop = [&](const std::string& device, const std::string& firmware) {
        return usbtest::run({"--timing", "immediate"},
                            {usbtest::client("palpate-loop"), "--link", host.name(), "--device", device,
                             "--firmware", firmware});
    };
    const usbtest::Outcome other = loop("usb:FALCON9", folder.firmware());
    CHECK(other.code == 3);
    CHECK(times_in(other.words, "No Falcon with serial number FALCON9") == 1);
    const usbtest::Outcome none = loop("usb", folder / "none.bin");
    CHECK(none.code == 2);
    CHECK(times_in(none.words, "nvent_firmware.bin") >= 1);
}
