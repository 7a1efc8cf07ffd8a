// The preload library in programs with habits of their own, and the simulator before programs that are not of
// the preload library.
#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <cstring>

#include "sim/usb/preload_wire.h"
#include "tests/sim/usb/process.hpp"

using Catch::Contains;
using namespace usbtest;

namespace {

/// The device's node, spoken to without the library: what `n_handed` descriptors of its own make of it.
class Stranger {
public:
    explicit Stranger(std::size_t n_handed) : node_(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)) {
        sockaddr_un where{};
        where.sun_family = AF_UNIX;
        (bus_folder() + "/dev/bus/usb/001/002").copy(where.sun_path, sizeof where.sun_path - 1);
        const timeval patience{10, 0};
        setsockopt(node_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
        REQUIRE(connect(node_, reinterpret_cast<const sockaddr*>(&where), sizeof where) == 0);
        REQUIRE(pipe(pipe_.data()) == 0);  // would block: not as the library makes it
        REQUIRE(socketpair(AF_UNIX, SOCK_SEQPACKET, 0, calls_.data()) == 0);
        greet(n_handed);
    }
    Stranger(const Stranger&) = delete;
    Stranger& operator=(const Stranger&) = delete;
    ~Stranger() {
        for (const int fd : {node_, pipe_[0], pipe_[1], calls_[0], calls_[1]}) {
            if (fd >= 0) close(fd);
        }
    }
    void submit(std::uint64_t tag, std::uint8_t endpoint) const {
        pal_wire_urb urb{};
        urb.kind = PAL_WIRE_SUBMIT;
        urb.endpoint = endpoint;
        if (endpoint == 0) urb.setup[0] = 0x40;  // purge
        if (endpoint != 0) urb.n_bytes = 64;
        urb.tag = tag;
        (void)send(node_, &urb, sizeof urb, MSG_NOSIGNAL);
    }
    void close_calls() {
        for (int& fd : calls_) {
            close(fd);
            fd = -1;
        }
    }
    /// Reads until the simulator hangs up; false when it does not within 10 s.
    [[nodiscard]] bool is_hung_up_on() const {
        std::array<char, 256> bytes{};
        ssize_t n = 1;
        while (n > 0) n = recv(node_, bytes.data(), bytes.size(), 0);
        return n == 0 || errno == ECONNRESET;
    }

private:
    void greet(std::size_t n_handed) const {
        pal_wire_hello hello{PAL_WIRE_VERSION};
        iovec bytes{&hello, sizeof hello};
        alignas(cmsghdr) std::array<char, CMSG_SPACE(2 * sizeof(int))> control{};
        msghdr message{};
        message.msg_iov = &bytes;
        message.msg_iovlen = 1;
        message.msg_control = control.data();
        message.msg_controllen = CMSG_SPACE(n_handed * sizeof(int));
        cmsghdr* rights = CMSG_FIRSTHDR(&message);
        rights->cmsg_level = SOL_SOCKET;
        rights->cmsg_type = SCM_RIGHTS;
        rights->cmsg_len = CMSG_LEN(n_handed * sizeof(int));
        const std::array<int, 2> handed = {pipe_[0], calls_[1]};
        std::memcpy(CMSG_DATA(rights), handed.data(), n_handed * sizeof(int));
        REQUIRE(sendmsg(node_, &message, MSG_NOSIGNAL) == static_cast<ssize_t>(sizeof hello));
    }
    int node_;
    std::array<int, 2> pipe_ = {-1, -1}, calls_ = {-1, -1};
};

std::string status() {
    return simulator({"status", "--bus", bus_folder()}).words;
}

long n_descriptors(const Process& process) {
    const std::filesystem::directory_iterator all("/proc/" + std::to_string(process.pid()) + "/fd");
    return std::distance(all, {});
}

TEST_CASE("a program that hands over a pipe that would block does not stop the simulator", "[process]") {
    const Bus bus({"--timing", "immediate"});
    const Stranger stranger(2);
    stranger.submit(1, 0);
    CHECK_THAT(status(), Contains("\"open\":1,"));
}

TEST_CASE("programs that hand over too little are hung up on and leave nothing open", "[process]") {
    Bus bus({"--timing", "immediate"});
    const long before = n_descriptors(bus.process());
    for (int i = 0; i < 20; ++i) CHECK(Stranger(1).is_hung_up_on());
    for (int ms = 0; ms < kLimitMs && n_descriptors(bus.process()) != before; ++ms) poll(nullptr, 0, 1);
    CHECK(n_descriptors(bus.process()) == before);
}

TEST_CASE("a program without its calls, or with more transfers than there may be, is hung up on",
          "[process]") {
    const Bus bus;
    Stranger stranger(2);
    CHECK_THAT(status(), Contains("\"open\":1,"));
    SECTION("calls") {
        stranger.close_calls();
    }
    SECTION("transfers") {
        for (std::uint64_t tag = 1; tag <= 2000; ++tag) stranger.submit(tag, 0x81);
    }
    CHECK(stranger.is_hung_up_on());
    CHECK_THAT(status(), Contains("\"open\":0,"));
}

TEST_CASE(
    "signals, other files over the device's descriptor, vfork and a cleared environment disturb nothing",
    "[process]") {
    const std::string what = GENERATE(as<std::string>{}, "signals", "replaced", "vforks", "forgets");
    CAPTURE(what);
    const Outcome habits = run({"--timing", "immediate"}, {client("sim_usb_habits"), what});
    CHECK(habits.words.empty());
    CHECK(habits.code == 0);
}

TEST_CASE("without a simulator nothing is seen, not a real device either, and nothing is left open",
          "[process]") {
    const std::string what = GENERATE(as<std::string>{}, "hidden", "inits");
    const std::string bus = GENERATE(as<std::string>{}, "", "/no/such/folder", std::string(600, 'x'));
    CAPTURE(what, bus);
    Process habits({client("sim_usb_habits"), what}, {"LD_PRELOAD=" + kPreload, "PALPATE_FALCON_BUS=" + bus,
                                                      "ASAN_OPTIONS=verify_asan_link_order=0"});
    const std::string words = habits.words();
    CHECK_THAT(words, !Contains("habits:"));
    CHECK((words.find("palpate-falcon-sim run --") != std::string::npos) == (bus != "/no/such/folder"));
    CHECK(habits.wait() == 0);
}

}  // namespace
