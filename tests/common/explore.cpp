#include "tests/common/explore.hpp"

#include <csetjmp>
#include <cstring>

#include "common/atomic.h"

using explore::Machine;
using explore::Order;

Machine* Machine::running = nullptr;

// What the shipped files call instead of the compiler's builtins.
extern "C" {
std::uint32_t pal_atomic_load_relaxed(const std::uint32_t* word) {
    return Machine::running->on_load(word, Order::relaxed);
}
std::uint32_t pal_atomic_load_acquire(const std::uint32_t* word) {
    return Machine::running->on_load(word, Order::acquire);
}
void pal_atomic_store_relaxed(std::uint32_t* word, std::uint32_t value) {
    Machine::running->on_store(word, value, Order::relaxed);
}
void pal_atomic_store_release(std::uint32_t* word, std::uint32_t value) {
    Machine::running->on_store(word, value, Order::release);
}
bool pal_atomic_swap(std::uint32_t* word, std::uint32_t* seen, std::uint32_t next) {
    return Machine::running->on_swap(word, seen, next);
}
void pal_note_read(const void* place) {
    Machine::running->on_note(place, false);
}
void pal_note_write(const void* place) {
    Machine::running->on_note(place, true);
}
void pal_copy_once(void* copy, const void* shared, std::size_t n_bytes) {
    std::memcpy(copy, shared, n_bytes);  // noted beside it
}
}

namespace explore {
namespace {

// The way out of the middle of an operation. No frame between has anything to destroy.
std::jmp_buf way_out;
enum { STOPPED = 1, FAILED = 2, IMPOSSIBLE = 3 };

constexpr std::uint32_t SWAPPED = 1U << 31U;  // in the log: the exchange succeeded

constexpr std::uint32_t write_bit(std::size_t place) {
    return 1U << (4 * place);
}

constexpr std::uint32_t read_bits(std::size_t place) {
    return 0xEU << (4 * place);
}

constexpr std::uint32_t read_bit(std::size_t place, std::size_t thread) {
    return 2U << (4 * place + thread);
}

void merge(View& into, const View& from) {
    for (std::size_t i = 0; i < MAX_LOCATIONS; ++i) {
        if (from.at[i] > into.at[i]) into.at[i] = from.at[i];
    }
    into.events |= from.events;
}

template <typename Change>
void each_view(Memory& memory, Change&& change) {
    for (Thread& thread : memory.thread) change(thread.view);
    for (Atomic& atomic : memory.atomic) {
        for (std::size_t i = 0; i < atomic.n_stores; ++i) change(atomic.store[i].view);
    }
}

// Nothing known beyond what every reader of the store must know anyway.
View bare() {
    View view;
    view.events = 0;
    return view;
}

}  // namespace

bool Machine::replayed(std::uint32_t* answer) {
    Thread& thread = me();
    if (cursor_ < thread.n_log) {
        *answer = thread.log[cursor_++];
        return true;
    }
    if (taken_) std::longjmp(way_out, STOPPED);
    if (thread.n_log >= MAX_LOG) fail("an operation does not end");
    taken_ = true;
    return false;
}

std::uint32_t Machine::done(std::uint32_t answer) {
    Thread& thread = me();
    thread.log[thread.n_log++] = answer;
    cursor_ = thread.n_log;
    return answer;
}

void Machine::fail(const char* what) {
    failure_ = what;
    std::longjmp(way_out, FAILED);
}

void Machine::race(std::size_t place, bool writes) {
    View& view = me().view;
    if ((view.events & write_bit(place)) == 0)
        fail(writes ? "race: write with a write" : "race: read with a write");
    const std::uint32_t mine = writes ? write_bit(place) : read_bit(place, who_);
    if (writes && (view.events & read_bits(place)) != read_bits(place)) fail("race: write with a read");
    each_view(*memory_, [&](View& any) {
        any.events &= ~mine;
        if (writes) any.events |= read_bits(place);  // whoever learns of the write learns of them
    });
    view.events |= mine;
}

std::size_t Machine::chosen(std::size_t location) {
    const std::size_t n_stores = memory_->atomic[location].n_stores;
    n_choices_ = n_stores - me().view.at[location];
    return n_stores - 1 - choice_;
}

std::uint32_t Machine::load(std::size_t location, Order order) {
    std::uint32_t answer = 0;
    if (replayed(&answer)) return answer;
    const std::size_t index = chosen(location);
    const Store& store = memory_->atomic[location].store[index];
    View& view = me().view;
    if (order == Order::acquire) merge(view, store.view);
    if (index > view.at[location]) view.at[location] = static_cast<std::uint8_t>(index);
    return done(store.value);
}

void Machine::store(std::size_t location, std::uint32_t value, Order order) {
    std::uint32_t answer = 0;
    if (replayed(&answer)) return;
    Atomic& atomic = memory_->atomic[location];
    if (atomic.n_stores == MAX_STORES) fail("explorer: too many stores");
    View& view = me().view;
    view.at[location] = static_cast<std::uint8_t>(atomic.n_stores);
    atomic.store[atomic.n_stores++] = {value, order == Order::release ? view : bare()};
    done(0);
}

bool Machine::swap(std::size_t location, std::uint32_t* seen, std::uint32_t next, Order order) {
    std::uint32_t answer = 0;
    if (!replayed(&answer)) {
        const std::size_t index = chosen(location);
        Atomic& atomic = memory_->atomic[location];
        const bool newest = index + 1 == atomic.n_stores;
        const Store was = atomic.store[index];
        const bool equal = was.value == *seen;
        if (equal && !newest) std::longjmp(way_out, IMPOSSIBLE);  // an exchange takes the newest
        View& view = me().view;
        if (order != Order::relaxed) merge(view, was.view);
        view.at[location] = static_cast<std::uint8_t>(index);
        if (equal) {
            if (atomic.n_stores == MAX_STORES) fail("explorer: too many stores");
            view.at[location] = static_cast<std::uint8_t>(atomic.n_stores);
            View carried = order != Order::relaxed ? view : bare();
            merge(carried, was.view);  // an exchange continues the release sequence of what it read
            atomic.store[atomic.n_stores++] = {next, carried};
        }
        answer = done(was.value | (equal ? SWAPPED : 0U));
    }
    *seen = answer & ~SWAPPED;
    return (answer & SWAPPED) != 0;
}

Machine::Outcome Machine::step(Memory& memory, std::size_t thread, std::size_t choice) {
    running = this;
    memory_ = &memory;
    who_ = thread;
    choice_ = choice;
    n_choices_ = 1;
    cursor_ = 0;
    taken_ = false;
    switch (setjmp(way_out)) {
        case 0:
            operation(thread);
            break;
        case FAILED:
            return Outcome::failed;
        case IMPOSSIBLE:
            return Outcome::impossible;
        default:
            return Outcome::stepped;
    }
    memory_->thread[who_].op += 1;
    memory_->thread[who_].n_log = 0;
    return Outcome::finished;
}

void Machine::reset(Memory& memory, std::size_t location, std::uint32_t value) {
    memory.atomic[location].n_stores = 1;
    memory.atomic[location].store[0] = {value, bare()};
    each_view(memory, [&](View& view) { view.at[location] = 0; });
}

void Machine::forget(Memory& memory, std::size_t place) {
    each_view(memory, [&](View& view) { view.events |= write_bit(place) | read_bits(place); });
}

void Machine::join(Memory& memory, std::size_t thread, std::size_t other) {
    merge(memory.thread[thread].view, memory.thread[other].view);
}

void Machine::tidy(Memory& memory, const std::array<std::uint32_t, N_THREADS>& n_ops) {
    for (std::size_t i = 0; i < MAX_LOCATIONS; ++i) {
        Atomic& atomic = memory.atomic[i];
        if (atomic.n_stores < 2) continue;
        std::size_t oldest = atomic.n_stores - 1;
        for (std::size_t t = 0; t < N_THREADS; ++t) {
            const Thread& thread = memory.thread[t];
            if (thread.op < n_ops[t] && thread.view.at[i] < oldest) oldest = thread.view.at[i];
        }
        if (oldest == 0) continue;
        atomic.n_stores -= oldest;
        for (std::size_t k = 0; k < atomic.n_stores; ++k) atomic.store[k] = atomic.store[k + oldest];
        each_view(memory, [&](View& view) {
            view.at[i] = static_cast<std::uint8_t>(view.at[i] > oldest ? view.at[i] - oldest : 0);
        });
    }
}

bool Seen::add(std::uint64_t hash) {
    if (2 * n_ >= cell_.size()) {
        std::vector<std::uint64_t> old(2 * cell_.size());
        old.swap(cell_);
        n_ = 0;
        for (const std::uint64_t h : old) {
            if (h != 0) add(h);
        }
    }
    if (hash == 0) hash = 1;
    const std::size_t mask = cell_.size() - 1;
    std::size_t i = (hash ^ hash >> 32U) & mask;
    for (; cell_[i] != 0; i = (i + 1) & mask) {
        if (cell_[i] == hash) return false;
    }
    cell_[i] = hash;
    ++n_;
    return true;
}

void Hash::add(const View& view) {
    std::uint64_t word = 0;
    for (std::size_t i = 0; i < MAX_LOCATIONS; ++i) word = word * 13 + view.at[i];
    add(word);
    add(view.events);
}

void Hash::add(const Memory& memory, std::size_t n_locations) {
    for (std::size_t i = 0; i < n_locations; ++i) {
        const Atomic& atomic = memory.atomic[i];
        add(atomic.n_stores);
        for (std::size_t k = 0; k < atomic.n_stores; ++k) {
            add(atomic.store[k].value);
            add(atomic.store[k].view);
        }
    }
    for (const Thread& thread : memory.thread) {
        add(thread.view);
        add(std::uint64_t{thread.op} << 32U | thread.n_log);
        for (std::size_t k = 0; k < thread.n_log; ++k) add(thread.log[k]);
    }
}

}  // namespace explore
