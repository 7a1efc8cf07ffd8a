#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>

#include "firmware/port/linux/clock_loop.h"
#include "firmware/port/linux/device_socket.h"
#include "firmware/port/linux/disturbance.h"
#include "firmware/port/linux/realtime.h"
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
    pal_clock_loop clock{1000, 10000, 0, 0};
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

TEST_CASE("the clock's count of missed periods wraps, and a stall of years is one step") {
    pal_clock_loop clock{1000, 10000, 0xFFFFFFFFU, 0};
    pal_clock_loop_advance(&clock, 12500);
    CHECK(clock.n_missed == 1);
    CHECK(clock.next_ns == 13000);
    constexpr std::uint64_t YEARS_NS = 1000ULL * (1ULL << 33U);
    pal_clock_loop_advance(&clock, 13000 + YEARS_NS + 1);
    CHECK(clock.next_ns == 14000 + YEARS_NS);
    CHECK(clock.n_missed == 0);  // 2^32 - 1 more, the most that the count can tell
}

TEST_CASE("the clock says how late it woke") {
    pal_clock_loop clock{1000000, pal_clock_now_ns() - 5000000, 0, 0};
    const std::uint64_t first_ns = clock.next_ns;
    const std::uint64_t t_ns = pal_clock_loop_wait(&clock);
    CHECK(clock.late_ns == t_ns - first_ns);
    CHECK(clock.late_ns >= 5000000);
    CHECK(clock.n_missed >= 4);
    CHECK((clock.next_ns - first_ns) % 1000000 == 0);
    CHECK(clock.next_ns > t_ns);
    clock.next_ns = 0;
    (void)pal_clock_loop_wait(&clock);
    CHECK(clock.late_ns > 0);
}

TEST_CASE("a segment that others may open, or that is another's, is refused") {
    const Segment segment;
    segment.fill(sizeof(pal_link), true);
    pal_link* link = nullptr;
    for (const mode_t mode : {0660U, 0604U, 0620U, 0700U}) {
        REQUIRE(fchmod(segment.file, mode) == 0);
        CHECK(pal_segment_attach(segment.name.c_str(), &link) == PAL_ERR_IO);
        CHECK(errno == EACCES);
        CHECK_THAT(pal_segment_words(PAL_ERR_IO, errno), Catch::Contains("must be 0600"));
    }
    REQUIRE(fchmod(segment.file, 0600) == 0);
    if (geteuid() == 0) {
        REQUIRE(fchown(segment.file, 1234, 1234) == 0);
        CHECK(pal_segment_attach(segment.name.c_str(), &link) == PAL_ERR_IO);
        CHECK(errno == EPERM);
        CHECK_THAT(pal_segment_words(PAL_ERR_IO, errno), Catch::Contains("another user"));
        REQUIRE(fchown(segment.file, 0, 0) == 0);
    }
    REQUIRE(pal_segment_attach(segment.name.c_str(), &link) == PAL_OK);
    pal_segment_detach(link);
}

TEST_CASE("a segment has one loop, whose words begin anew") {
    const Segment segment;
    segment.fill(sizeof(pal_link), true);
    pal_segment first, second;
    std::uint32_t holder = 77;
    REQUIRE(pal_segment_take(segment.name.c_str(), &first, &holder) == PAL_OK);
    CHECK(first.link->loop.pid == static_cast<std::uint32_t>(getpid()));
    first.link->loop.ended = 1;
    CHECK(pal_segment_take(segment.name.c_str(), &second, &holder) == PAL_ERR_IO);
    CHECK(errno == EBUSY);
    CHECK(holder == static_cast<std::uint32_t>(getpid()));
    CHECK(first.link->loop.ended == 1);
    pal_link* reader = nullptr;  // who only looks is no loop
    REQUIRE(pal_segment_attach(segment.name.c_str(), &reader) == PAL_OK);
    reader->loop.end_reason = 4;
    reader->loop.n_preempted = 5;
    pal_segment_give(&first);
    REQUIRE(pal_segment_take(segment.name.c_str(), &second, &holder) == PAL_OK);
    const pal_link_loop fresh{.pid = static_cast<std::uint32_t>(getpid()),
                              .heartbeat = 0,
                              .ended = 0,
                              .end_reason = 0,
                              .n_bad_tables = 0,
                              .realtime = 0,
                              .realtime_refused = 0,
                              .n_minor_faults = 0,
                              .n_major_faults = 0,
                              .n_preempted = 0,
                              .reserved = {}};
    CHECK(std::memcmp(&reader->loop, &fresh, sizeof fresh) == 0);
    pal_segment_give(&second);
    pal_segment_detach(reader);
}

TEST_CASE("each refusal of a segment has its sentence") {
    CHECK_THAT(pal_segment_words(PAL_ERR_IO, ENOENT), Catch::Contains("no such segment"));
    CHECK_THAT(pal_segment_words(PAL_ERR_IO, EBUSY), Catch::Contains("a loop already"));
    CHECK_THAT(pal_segment_words(PAL_ERR_IO, EMFILE), Catch::Contains("open files"));
    CHECK(std::string(pal_segment_words(PAL_ERR_ABI, 0)) == pal_err_words(PAL_ERR_ABI));
}

TEST_CASE("page faults and lost processors of a thread are counted as the kernel counts them") {
    pal_disturbance disturbance;
    pal_disturbance_counts counts{};
    CHECK_FALSE(pal_disturbance_open(&disturbance, 1 << 30));
    REQUIRE(pal_disturbance_open(&disturbance, gettid()));
    rusage before{}, after{};
    REQUIRE(getrusage(RUSAGE_THREAD, &before) == 0);
    constexpr std::size_t N_PAGES = 512;
    auto* pages = static_cast<char*>(
        mmap(nullptr, N_PAGES * 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    REQUIRE(pages != MAP_FAILED);
    madvise(pages, N_PAGES * 4096, MADV_NOHUGEPAGE);
    for (std::size_t i = 0; i < N_PAGES; ++i) pages[i * 4096] = 1;
    REQUIRE(getrusage(RUSAGE_THREAD, &after) == 0);
    REQUIRE(pal_disturbance_read(&disturbance, &counts));
    CHECK(counts.n_minor_faults >= N_PAGES);
    CHECK(counts.n_minor_faults >= static_cast<std::uint32_t>(after.ru_minflt - before.ru_minflt));
    CHECK(counts.n_preempted >= static_cast<std::uint32_t>(after.ru_nivcsw - before.ru_nivcsw));
    munmap(pages, N_PAGES * 4096);
    pal_disturbance_close(&disturbance);
}

TEST_CASE("a processor that is not there is refused by a sentence, and the thread stays where it was") {
    char why[PAL_REALTIME_WORDS_BYTES];
    pal_realtime_choice choice{PAL_POLICY_OTHER, 0, PAL_REALTIME_ANY_CPU, false};
    CHECK(pal_realtime_possible(&choice, why));
    cpu_set_t before, after;
    REQUIRE(sched_getaffinity(0, sizeof before, &before) == 0);
    choice.cpu = 4095;
    CHECK_FALSE(pal_realtime_possible(&choice, why));
    CHECK_THAT(why, Catch::Contains("--cpu 4095: this machine has processors 0 to"));
    for (choice.cpu = 0; !CPU_ISSET(static_cast<std::size_t>(choice.cpu), &before);) ++choice.cpu;
    CHECK(pal_realtime_possible(&choice, why));
    REQUIRE(sched_getaffinity(0, sizeof after, &after) == 0);
    CHECK(CPU_EQUAL(&before, &after));
}
