// No tick touches the heap. This program's malloc and its kin are counted; glibc's own do the work.
#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <memory>

#include "firmware/app/session.h"
#include "firmware/falcon/wire.h"
#include "firmware/port/linux/clock_loop.h"
#include "firmware/port/linux/device_socket.h"
#include "tests/common/tables.hpp"

namespace {
bool counting = false;
long n_calls = 0;
void note() {
    if (counting) ++n_calls;
}
}  // namespace

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void __libc_free(void*);
void* malloc(std::size_t n) {
    note();
    return __libc_malloc(n);
}
void* calloc(std::size_t n, std::size_t size) {
    note();
    return __libc_calloc(n, size);
}
void* realloc(void* at, std::size_t n) {
    note();
    return __libc_realloc(at, n);
}
void free(void* at) {
    note();
    __libc_free(at);
}
}

namespace {

constexpr std::uint32_t N_TICKS = 10000;

/// The other end of the device's socket: a Falcon's replies from 2 mm inside the skin.
class Peer {
public:
    Peer() {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path_.copy(address.sun_path, sizeof address.sun_path - 1);
        REQUIRE(bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
        REQUIRE(listen(listener_, 1) == 0);
        REQUIRE(pal_device_socket_open(&socket_, path_.c_str(), &device_) == PAL_OK);
        peer_ = accept(listener_, nullptr, nullptr);
        pal_drive counts{};
        const float at_m[3] = {0.0F, 0.0F, 0.118F};
        float theta_rad[3];
        REQUIRE(pal_delta_inverse(&PAL_DELTA_NF1, at_m, theta_rad));
        for (int i = 0; i < 3; ++i) {
            REQUIRE(pal_delta_counts(&PAL_DELTA_NF1, theta_rad[i], &counts.motor_counts[i]));
        }
        pal_wire_encode(&counts, reply_.data());
        reply_[13] = 0x41 + 0x70;
    }
    ~Peer() {
        pal_device_socket_close(&socket_);
        close(peer_);
        close(listener_);
        unlink(path_.c_str());
    }
    Peer(const Peer&) = delete;
    Peer& operator=(const Peer&) = delete;
    [[nodiscard]] const pal_device& device() const { return device_; }
    /// Takes what came; answers when asked to. True: it got a force.
    bool answer(bool reply) {
        std::array<std::uint8_t, 16> request{};
        bool pushes = false;
        while (recv(peer_, request.data(), request.size(), MSG_DONTWAIT) == 16) {
            for (std::size_t i = 1; i <= 12; ++i) pushes = pushes || request[i] != 0x41;
        }
        if (reply) (void)::send(peer_, reply_.data(), reply_.size(), MSG_DONTWAIT);
        return pushes;
    }

private:
    std::string path_ = "/tmp/pal-heap-test-" + std::to_string(getpid());
    int listener_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0), peer_ = -1;
    pal_device_socket socket_{};
    pal_device device_{};
    std::array<std::uint8_t, 16> reply_{};
};

/// N_TICKS ticks with all that happens to a loop; calls of the heap in them.
long calls_in_ticks(const pal_device& device, Peer& peer, bool* pushed) {
    const auto link = std::make_unique<pal_link>();
    const auto session = std::make_unique<pal_session>();
    pal_loop_config config = pal_loop_config_default();
    config.ramp_ticks = 10;
    pal_link_init(link.get(), 1);
    link->host.enable = 1;
    pal_session_begin(session.get(), link.get(), &device, &config, pal_clock_now_ns);
    std::uint64_t n_tables = 0;
    n_calls = 0;
    pal_session_time now{0, 0, 0};
    for (std::uint32_t n = 0; n < N_TICKS; ++n) {
        ++link->host.heartbeat;
        if (n % 40 == 0) {
            const auto table = tables::make({}, 9, 0.0, ++n_tables);
            if (n % 400 == 0) table->magic = 0;  // one that is refused
            std::memcpy(pal_table_ring_back(&link->tables), table.get(), table->n_bytes);
            pal_table_ring_publish(&link->tables);
        }
        (void)pal_intake_check(&session->intake);
        link->host.enable = n % 3000 < 2900 ? 1 : 0;
        if (n % 700 == 699) now.n_missed += 7;
        now.t_ns = pal_clock_now_ns();
        counting = true;
        const pal_session_end end = pal_session_tick(session.get(), &now);
        counting = false;
        REQUIRE(end == PAL_SESSION_RUNS);
        if (peer.answer(n % 500 < 490)) *pushed = true;
    }
    return n_calls;
}

Peer* mutant_peer = nullptr;

}  // namespace

TEST_CASE("ten thousand ticks do not touch the heap") {
    Peer peer;
    bool pushed = false;
    CHECK(calls_in_ticks(peer.device(), peer, &pushed) == 0);
    CHECK(pushed);
}

TEST_CASE("one allocation in each tick would be seen") {
    Peer peer;
    mutant_peer = &peer;
    pal_device mutant = peer.device();
    mutant.collect = [](void* context, std::uint8_t reply[16]) {
        void* volatile leak = std::malloc(16);
        std::free(leak);
        return mutant_peer->device().collect(context, reply);
    };
    bool pushed = false;
    CHECK(calls_in_ticks(mutant, peer, &pushed) == 2 * static_cast<long>(N_TICKS));
    CHECK(pushed);
}
