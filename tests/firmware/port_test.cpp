#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <string>

#include "firmware/port/linux/clock_loop.h"
#include "firmware/port/linux/device_socket.h"
#include "firmware/port/linux/segment.h"

namespace {

struct Segment {
    std::string name = "/palpate-test-" + std::to_string(getpid());
    int file = shm_open(name.c_str(), O_CREAT | O_EXCL | O_RDWR, 0600);
    ~Segment() {
        close(file);
        shm_unlink(name.c_str());
    }
    void fill(std::size_t n_bytes, bool valid) const {
        REQUIRE(ftruncate(file, static_cast<off_t>(sizeof(pal_link))) == 0);
        void* at = mmap(nullptr, sizeof(pal_link), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
        REQUIRE(at != MAP_FAILED);
        pal_link_init(static_cast<pal_link*>(at), 99);
        if (!valid) static_cast<pal_link*>(at)->header.abi = 77;
        munmap(at, sizeof(pal_link));
        REQUIRE(ftruncate(file, static_cast<off_t>(n_bytes)) == 0);
    }
};

}  // namespace

TEST_CASE("a segment is attached by name, a short, foreign or missing one is refused") {
    const Segment segment;
    pal_link* link = nullptr;
    CHECK(pal_segment_attach("/palpate-test-nobody", &link) == PAL_ERR_IO);
    CHECK(pal_segment_attach(segment.name.c_str(), &link) == PAL_ERR_SIZE);
    segment.fill(sizeof(pal_link) - 1, true);
    CHECK(pal_segment_attach(segment.name.c_str(), &link) == PAL_ERR_SIZE);
    segment.fill(sizeof(pal_link), false);
    CHECK(pal_segment_attach(segment.name.c_str(), &link) == PAL_ERR_ABI);
    CHECK(link == nullptr);
    segment.fill(sizeof(pal_link), true);
    REQUIRE(pal_segment_attach(segment.name.c_str(), &link) == PAL_OK);
    CHECK(link->header.nonce == 99);
    pal_segment_detach(link);
}

TEST_CASE("the device socket sends, gives the newest whole reply and notices the end") {
    const std::string path = "/tmp/palpate-test-" + std::to_string(getpid()) + ".sock";
    unlink(path.c_str());
    pal_device_socket socket_state;
    pal_device device;
    CHECK(pal_device_socket_open(&socket_state, path.c_str(), &device) == PAL_ERR_IO);
    CHECK(pal_device_socket_open(&socket_state, std::string(200, 'x').c_str(), &device) == PAL_ERR_RANGE);
    const int listener = socket(AF_UNIX, SOCK_SEQPACKET, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, path.c_str());
    REQUIRE(bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(listen(listener, 1) == 0);
    REQUIRE(pal_device_socket_open(&socket_state, path.c_str(), &device) == PAL_OK);
    const int peer = accept(listener, nullptr, nullptr);

    std::uint8_t bytes[32] = {};
    CHECK(device.collect(device.context, bytes) == PAL_DEVICE_NONE);
    CHECK(device.send(device.context, reinterpret_cast<const std::uint8_t*>("<AAAAAAAAAAAAAA>")) ==
          PAL_DEVICE_FRESH);
    CHECK(recv(peer, bytes, sizeof bytes, 0) == 16);
    CHECK(std::memcmp(bytes, "<AAAAAAAAAAAAAA>", 16) == 0);
    send(peer, "<BAAAAAAAAAAAAA>", 16, 0);
    send(peer, "<CAAAAAAAAAAAAA>", 16, 0);
    send(peer, "<short>", 7, 0);
    send(peer, "<much too long for a packet>", 28, 0);
    CHECK(device.collect(device.context, bytes) == PAL_DEVICE_FRESH);
    CHECK(std::memcmp(bytes, "<CAAAAAAAAAAAAA>", 16) == 0);
    CHECK(device.collect(device.context, bytes) == PAL_DEVICE_NONE);
    close(peer);
    CHECK(device.collect(device.context, bytes) == PAL_DEVICE_GONE);
    CHECK(device.send(device.context, bytes) == PAL_DEVICE_GONE);
    pal_device_socket_close(&socket_state);
    close(listener);
    unlink(path.c_str());
}

TEST_CASE("the clock keeps its phase, and skips and counts the periods that it missed") {
    pal_clock_loop clock{1000, 10000, 0};
    pal_clock_loop_advance(&clock, 10100);
    CHECK(clock.next_ns == 11000);
    CHECK(clock.n_missed == 0);
    pal_clock_loop_advance(&clock, 11999);
    CHECK(clock.next_ns == 12000);
    CHECK(clock.n_missed == 0);
    pal_clock_loop_advance(&clock, 13000);
    CHECK(clock.next_ns == 14000);
    CHECK(clock.n_missed == 1);
    pal_clock_loop_advance(&clock, 44321);
    CHECK(clock.next_ns == 45000);
    CHECK(clock.n_missed == 31);
}
