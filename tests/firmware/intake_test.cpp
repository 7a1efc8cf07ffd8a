#include "firmware/core/intake.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <thread>

#include "tests/common/tables.hpp"

namespace {

struct Bench {
    std::unique_ptr<pal_table_ring> ring = std::make_unique<pal_table_ring>();
    pal_intake intake{};
    Bench() {
        pal_table_ring_init(ring.get());
        intake.ring = ring.get();
        intake.limits = pal_table_limits_default();
    }
    void publish(std::uint64_t id, bool good = true, std::uint32_t n_nodes = 17) {
        const auto table = tables::make({}, n_nodes, 0.0, id);
        if (!good) table->coef[100] = NAN;
        pal_table_seal(table.get());
        std::memcpy(pal_table_ring_back(ring.get()), table.get(), sizeof(pal_table));
        pal_table_ring_publish(ring.get());
    }
    /// One tick with the check in line.
    const pal_loop_tables& tick(bool fading = false) {
        pal_intake_poll(&intake, fading);
        pal_intake_check(&intake);
        return *pal_intake_poll(&intake, fading);
    }
};

}  // namespace

TEST_CASE("a table is used only after its check") {
    Bench bench;
    CHECK(bench.tick().now == nullptr);
    bench.publish(1);
    CHECK(pal_intake_poll(&bench.intake, false)->now == nullptr);
    CHECK(pal_intake_poll(&bench.intake, false)->now == nullptr);
    CHECK(pal_intake_check(&bench.intake));
    CHECK_FALSE(pal_intake_check(&bench.intake));
    REQUIRE(pal_intake_poll(&bench.intake, false)->now != nullptr);
    CHECK(bench.intake.tables.now->id == 1);
    CHECK(bench.intake.tables.before == nullptr);
}

TEST_CASE("the table before stays for the fade, and none is taken while it runs") {
    Bench bench;
    bench.publish(1);
    bench.tick();
    bench.publish(2);
    const pal_loop_tables& tables = bench.tick();
    CHECK(tables.now->id == 2);
    CHECK(tables.before->id == 1);
    for (std::uint64_t id = 3; id < 10; ++id) {
        bench.publish(id);
        CHECK(bench.tick(true).now->id == 2);
        CHECK(bench.tick(true).before->id == 1);
    }
    CHECK(bench.tick(false).now->id == 9);
    CHECK(bench.intake.tables.before->id == 2);
}

TEST_CASE("a bad table is refused, counted, and the one in use stays through any number of them") {
    Bench bench;
    bench.publish(1);
    bench.tick();
    for (std::uint32_t n = 1; n <= 5; ++n) {
        bench.publish(1 + n, false);
        const pal_loop_tables& tables = bench.tick();
        CHECK(tables.n_bad == n);
        CHECK(tables.now->id == 1);
        CHECK(tables.before == nullptr);
        CHECK(bench.intake.last_err == static_cast<std::uint32_t>(-PAL_ERR_NOT_FINITE));
        CHECK(pal_table_header_ok(tables.now));
    }
    bench.publish(7);
    const pal_loop_tables& tables = bench.tick();
    CHECK(tables.now->id == 7);
    CHECK(tables.before->id == 1);
}

TEST_CASE("a bad first table leaves the loop without one") {
    Bench bench;
    bench.publish(1, false);
    CHECK(bench.tick().now == nullptr);
    bench.publish(2);
    CHECK(bench.tick().now->id == 2);
    CHECK(bench.intake.tables.before == nullptr);
}

TEST_CASE("a table that is not newer than the one in use is refused") {
    Bench bench;
    bench.publish(5);
    bench.tick();
    for (const std::uint64_t id : {5U, 4U}) {
        bench.publish(id);
        CHECK(bench.tick().now->id == 5);
        CHECK(bench.intake.last_err == static_cast<std::uint32_t>(-PAL_ERR_RANGE));
    }
    CHECK(bench.intake.tables.n_bad == 2);
}

TEST_CASE("what was checked is what is used, whatever the ring's word says by then") {
    Bench bench;
    bench.publish(1);
    pal_intake_poll(&bench.intake, false);
    const pal_table* taken = pal_table_ring_current(bench.ring.get());
    const auto word = GENERATE(as<std::uint32_t>{}, 0xE4, 0x1B, 0x00, 0xFFFFFFFF);
    bench.ring->state = word;
    CHECK(pal_intake_check(&bench.intake));
    CHECK(pal_intake_poll(&bench.intake, false)->now == taken);
}

TEST_CASE("an id that is rewritten in the table in use lets no older table in") {
    Bench bench;
    bench.publish(5);
    bench.tick();
    const_cast<pal_table*>(bench.intake.tables.now)->id = 1;
    bench.publish(3);
    CHECK(bench.tick().n_bad == 1);
    CHECK(bench.intake.now_id == 5);
}

TEST_CASE("a check in slices ends with the last, and only then is the table used") {
    Bench bench;
    CHECK_FALSE(pal_intake_check_slice(&bench.intake, PAL_INTAKE_SLICE_WORDS));
    bench.publish(1, true, 65);
    for (int slice = 1; slice <= 5; ++slice) {
        CHECK(pal_intake_poll(&bench.intake, false)->now == nullptr);
        CHECK(pal_intake_check_slice(&bench.intake, PAL_INTAKE_SLICE_WORDS) == (slice == 5));
    }
    CHECK_FALSE(pal_intake_check_slice(&bench.intake, PAL_INTAKE_SLICE_WORDS));
    REQUIRE(pal_intake_poll(&bench.intake, false)->now != nullptr);
    CHECK(bench.intake.tables.now->id == 1);
    bench.publish(2);
    pal_intake_poll(&bench.intake, false);
    CHECK(pal_intake_check_slice(&bench.intake, PAL_INTAKE_SLICE_WORDS));
    CHECK(pal_intake_poll(&bench.intake, false)->now->id == 2);
}

TEST_CASE("a table that is refused in a slice leaves nothing behind for the next one's check") {
    const auto n_words_max = GENERATE(as<std::uint32_t>{}, 1, 100, 1000, 4096);
    Bench bench;
    const auto sliced = [&] {
        pal_intake_poll(&bench.intake, false);
        while (!pal_intake_check_slice(&bench.intake, n_words_max)) pal_intake_poll(&bench.intake, false);
        return pal_intake_poll(&bench.intake, false)->now;
    };
    for (std::uint64_t id = 1; id <= 20; ++id) {
        const bool good = id % 2 == 0;
        bench.publish(id, good, id % 3 == 0 ? 33 : 17);
        const pal_table* now = sliced();
        CHECK((now == nullptr ? 0 : now->id) == (good ? id : id - 1));
    }
    CHECK(bench.intake.tables.n_bad == 10);
}

TEST_CASE("the whole check takes up what slices have left") {
    Bench bench;
    bench.publish(1, true, 65);
    pal_intake_poll(&bench.intake, false);
    for (int slice = 0; slice < 5; ++slice) CHECK_FALSE(pal_intake_check_slice(&bench.intake, 4096));
    CHECK(pal_intake_check(&bench.intake));
    CHECK(pal_intake_poll(&bench.intake, false)->now->id == 1);
}

TEST_CASE("an id that is rewritten between two slices is refused and shuts out none that come after it") {
    Bench bench;
    bench.publish(1);
    bench.tick();
    const std::uint32_t n_slices = (9 * 19 * 19 + 35 + 99) / 100;
    std::uint64_t id = 1;
    for (std::uint32_t at = 1; at < n_slices; ++at) {
        bench.publish(++id);
        pal_intake_poll(&bench.intake, false);
        for (std::uint32_t n = 1; n <= at; ++n) REQUIRE_FALSE(pal_intake_check_slice(&bench.intake, 100));
        const_cast<pal_table*>(bench.intake.pending)->id = 0xFFFFFFFFFFFFFFFFU;
        while (!pal_intake_check_slice(&bench.intake, 100)) {
        }
        CHECK(pal_intake_poll(&bench.intake, false)->n_bad == at);
        bench.publish(++id);
        CHECK(bench.tick().now->id == id);
    }
}

TEST_CASE("writer, checker and tick in three threads: only whole, checked tables, ids only grow",
          "[concurrency]") {
    Bench bench;
    constexpr std::uint64_t N_TABLES = 2000;
    std::uint32_t stop = 0;
    std::thread writer([&bench] {
        for (std::uint64_t id = 1; id <= N_TABLES; ++id) bench.publish(id, id % 5 != 0 || id == N_TABLES);
    });
    std::thread checker([&bench, &stop] {
        while (__atomic_load_n(&stop, __ATOMIC_ACQUIRE) == 0) {
            if (!pal_intake_check(&bench.intake)) std::this_thread::yield();
        }
    });
    std::uint64_t last = 0;
    bool ok = true;
    const pal_table_limits limits = pal_table_limits_default();
    while (last < N_TABLES) {
        const pal_loop_tables* tables = pal_intake_poll(&bench.intake, false);
        if (tables->now == nullptr || tables->now->id == last) continue;
        ok = ok && tables->now->id > last && pal_table_check(tables->now, &limits) == PAL_OK;
        ok = ok && (last == 0 ? tables->before == nullptr : tables->before->id == last);
        last = tables->now->id;
    }
    __atomic_store_n(&stop, 1U, __ATOMIC_RELEASE);
    writer.join();
    checker.join();
    CHECK(ok);
}
