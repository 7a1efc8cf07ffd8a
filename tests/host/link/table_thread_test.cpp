// The thread that builds and sends tables in real time, against the ring that it fills; no sleeping, no
// clock.
#include "host/app/table_thread.hpp"

#include <catch2/catch.hpp>
#include <future>

#include "tests/fuzz/good_table.hpp"

using namespace palpate;

namespace {

/// A table thread whose builder hands out one table, then works for as long as the test wants.
struct Slow {
    std::unique_ptr<pal_link> link = std::make_unique<pal_link>();
    std::promise<void> at_work, may_end;
    int n_updates = 0;
    app::TableThread thread;

    Slow() : thread([this](const pal_tick&) { return update(); }, init()) {}

    pal_link& init() {
        pal_link_init(link.get(), 1);
        return *link;
    }
    std::unique_ptr<pal_table> update() {
        auto table = std::make_unique<pal_table>();
        fuzz::fill_good(*table, 5, 0);
        if (n_updates++ == 0) return table;
        at_work.set_value();
        may_end.get_future().wait();
        throw std::runtime_error("the plate broke");
    }
    void offer(std::uint32_t tick) {
        pal_tick record{};
        record.tick = tick;
        thread.offer(record);
    }
    /// Ticks one by one from `first` to before `end`; the ticks at which a table came.
    std::vector<std::uint32_t> came(std::uint32_t first, std::uint32_t end) {
        std::vector<std::uint32_t> ticks;
        for (std::uint32_t tick = first; tick < end; ++tick) {
            offer(tick);
            if (pal_table_ring_take(&link->tables)) ticks.push_back(tick);
        }
        return ticks;
    }
};

}  // namespace

TEST_CASE("in real time the last table is kept fresh for a short build, and not for one that hangs") {
    Slow slow;
    slow.offer(100);
    while (!pal_table_ring_take(&slow.link->tables)) std::this_thread::yield();
    slow.offer(130);
    slow.at_work.get_future().wait();
    CHECK(slow.came(131, 1000) == std::vector<std::uint32_t>{140});  // at 180 the build is 50 ticks old
    slow.may_end.set_value();
    slow.thread.stop();
    CHECK(slow.came(1000, 1200).empty());
    REQUIRE(slow.thread.failure());
    CHECK_THROWS_WITH(std::rethrow_exception(slow.thread.failure()), "the plate broke");
    CHECK(slow.thread.tables().size() == 2);
}
