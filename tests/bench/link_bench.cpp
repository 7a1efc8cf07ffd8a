// Hand-over between host and loop, and what a table's arrival costs.
#include <atomic>
#include <cstddef>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include "common/crc32c.h"
#include "firmware/core/intake.h"
#include "host/link/publisher.hpp"
#include "tests/bench/measure.hpp"
#include "tests/common/tables.hpp"

namespace palpate::bench {
namespace {

constexpr int N_SAMPLES = 5000;
constexpr std::size_t BATCH = 64;
constexpr std::uint32_t USUAL_NODES = 17, MOST_NODES = PAL_TABLE_NODES_MAX;

std::unique_ptr<pal_link> new_link() {
    auto link = std::make_unique<pal_link>();
    pal_link_init(link.get(), 1);
    return link;
}

/// The swaps of the ring's word alone: publish by the writer, take by the reader.
void publish_and_take(benchmark::State& state) {
    const auto link = new_link();
    bool ok = true;
    measure(
        state, Clock::wall, BATCH, [](std::size_t) {},
        [&](std::size_t) {
            benchmark::DoNotOptimize(pal_table_ring_back(&link->tables));
            pal_table_ring_publish(&link->tables);
            ok = pal_table_ring_take(&link->tables) && ok;
            benchmark::DoNotOptimize(pal_table_ring_current(&link->tables));
        });
    if (!ok) throw std::runtime_error("ring: a published table was not taken");
}

/// All that the host does to publish: number, checksum, copy, swap.
void publish_whole(benchmark::State& state, std::uint32_t n_nodes) {
    const auto link = new_link();
    link::Publisher publisher(*link);
    publisher.publish(tables::make({}, n_nodes), 0);
    std::uint32_t tick = 0;
    measure(
        state, Clock::wall, 1, [](std::size_t) {},
        [&](std::size_t) {
            tick += 1000;  // old enough to be published again
            benchmark::DoNotOptimize(publisher.refresh(tick));
        });
}

/// A reader's intake behind a writer that publishes when it is told to, here or on another core.
class Reader {
public:
    Reader() {
        intake_.ring = &link_->tables;
        intake_.limits = pal_table_limits_default();
        publish();
        for (int i = 0; i < 2; ++i) {
            poll();
            static_cast<void>(pal_intake_check(&intake_));
        }
        if (poll()->now == nullptr) throw std::runtime_error("poll: no table in use");
    }
    void publish() {
        table_->id += 1;
        pal_table_seal(table_.get());
        std::memcpy(pal_table_ring_back(&link_->tables), table_.get(), table_->n_bytes);
        pal_table_ring_publish(&link_->tables);
    }
    const pal_loop_tables* poll() { return pal_intake_poll(&intake_, false); }
    /// Checks what was taken and brings it into use; throws when nothing was.
    void finish() {
        const std::uint64_t was = intake_.now_id;
        static_cast<void>(pal_intake_check(&intake_));
        if (poll(); intake_.now_id == was) throw std::runtime_error("poll: a new table was not taken");
    }

private:
    std::unique_ptr<pal_link> link_ = new_link();
    std::unique_ptr<pal_table> table_ = tables::make({}, USUAL_NODES);
    pal_intake intake_{};
};

void poll_nothing_new(benchmark::State& state) {
    Reader reader;
    measure(
        state, Clock::wall, BATCH, [](std::size_t) {},
        [&](std::size_t) { benchmark::DoNotOptimize(reader.poll()); });
}

/// The poll that takes; the writer's stores are in this core's caches.
void poll_new(benchmark::State& state) {
    Reader reader;
    measure(
        state, Clock::wall, 1,
        [&](std::size_t k) {
            if (k > 0) reader.finish();
            reader.publish();
        },
        [&](std::size_t) { benchmark::DoNotOptimize(reader.poll()); });
    reader.finish();
}

/// The same behind a writer on another core, as in a run: the ring's word has to come from there.
void poll_new_from_afar(benchmark::State& state) {
    Reader reader;
    std::atomic<std::size_t> n_asked{0}, n_published{0};
    std::jthread writer([&](const std::stop_token& stop) {
        for (std::size_t n = 0; !stop.stop_requested();) {
            if (n_asked == n) continue;
            reader.publish();
            n_published = ++n;
        }
    });
    measure(
        state, Clock::wall, 1,
        [&](std::size_t k) {
            if (k > 0) reader.finish();
            n_asked = k + 1;
            while (n_published != k + 1) std::this_thread::yield();
        },
        [&](std::size_t) { benchmark::DoNotOptimize(reader.poll()); });
    reader.finish();
}

void push(benchmark::State& state) {
    const auto link = new_link();
    pal_tick record{};
    measure(
        state, Clock::wall, BATCH, [](std::size_t) {},
        [&](std::size_t k) {
            record.tick = static_cast<std::uint32_t>(k);
            pal_state_ring_push(&link->ticks, &record);
        });
    benchmark::DoNotOptimize(link->ticks.done);
}

void check(benchmark::State& state, std::uint32_t n_nodes) {
    const auto table = tables::make({}, n_nodes);
    const pal_table_limits limits = pal_table_limits_default();
    bool ok = true;
    measure(
        state, Clock::wall, 1, [](std::size_t) {},
        [&](std::size_t) { ok = pal_table_check(table.get(), &limits) == PAL_OK && ok; });
    if (!ok) throw std::runtime_error("arrival: a good table was refused");
}

/// The slices that PAL_INTAKE_SLICE_WORDS makes of a check, in turn: the percentiles tell the longest.
void check_slice(benchmark::State& state, std::uint32_t n_nodes) {
    const auto table = tables::make({}, n_nodes);
    const pal_table_limits limits = pal_table_limits_default();
    pal_table_checking checking{};
    pal_err err = PAL_OK;
    bool ok = true;
    measure(
        state, Clock::wall, 1, [](std::size_t) {},
        [&](std::size_t) {
            benchmark::DoNotOptimize(
                pal_table_check_slice(&checking, table.get(), &limits, PAL_INTAKE_SLICE_WORDS, &err));
            ok = err == PAL_OK && ok;
        });
    if (!ok) throw std::runtime_error("arrival: a good table was refused");
}

void checksum(benchmark::State& state, std::uint32_t n_nodes) {
    const auto table = tables::make({}, n_nodes);
    const auto n_bytes = table->n_bytes - static_cast<std::uint32_t>(offsetof(pal_table, id));
    measure(
        state, Clock::wall, 1, [](std::size_t) {},
        [&](std::size_t) { benchmark::DoNotOptimize(pal_crc32c(&table->id, n_bytes)); });
}

}  // namespace

void register_link() {
    add("link/publish and take, swaps alone", N_SAMPLES, publish_and_take);
    for (const std::uint32_t n : {USUAL_NODES, MOST_NODES}) {
        add("link/publish a table of " + std::to_string(n) + " nodes, whole", N_SAMPLES,
            [n](benchmark::State& state) { publish_whole(state, n); });
    }
    add("link/poll, no new table", N_SAMPLES, poll_nothing_new);
    add("link/poll, a new table", N_SAMPLES, poll_new);
    add("link/poll, a new table from another core", N_SAMPLES, poll_new_from_afar);
    add("link/push a tick record", N_SAMPLES, push);
    for (const std::uint32_t n : {USUAL_NODES, MOST_NODES}) {
        const std::string of =
            " of " + std::to_string(n) + " nodes, " + std::to_string(pal_table_bytes(n)) + " bytes";
        add("arrival/whole check" + of, N_SAMPLES, [n](benchmark::State& state) { check(state, n); });
        add("arrival/one slice of the check" + of, N_SAMPLES,
            [n](benchmark::State& state) { check_slice(state, n); });
        add("arrival/checksum alone" + of, N_SAMPLES, [n](benchmark::State& state) { checksum(state, n); });
    }
}

}  // namespace palpate::bench
