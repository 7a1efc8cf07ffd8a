/// The hand-over of tables as the explorer sees it: writer, tick and checker around the shipped table_ring.c
/// and intake.c, with what must hold at each of their steps. Each mutant bends one operation of the same
/// object code.
#pragma once
#include <cstdint>

#include "firmware/core/intake.h"
#include "tests/common/explore.hpp"

namespace hand_over {

using explore::Order;
using Outcome = explore::Machine::Outcome;

enum Who : std::size_t { WRITER, TICK, CHECKER };
enum Location : std::size_t { RING, INTAKE, N_LOCATIONS };
enum Place : std::size_t { SLOTS = 0, PENDING = PAL_TABLE_SLOTS, PENDING_ID, NOW_ID };
constexpr std::uint8_t NONE = 0xFF;

enum class Mutant : std::uint8_t {
    none,
    relaxed_publish,
    relaxed_take,
    relaxed_order,    ///< to the checker
    relaxed_verdict,  ///< of the checker
    split_words,      ///< the reader's two fields in one word, the rest in another
    not_dirty,
    not_checked,
    take_in_fade
};

struct Setting {
    std::uint32_t n_publications = 3, n_polls = 4, n_checks = 2;
    std::uint32_t fade_polls = 1;
    std::uint32_t bad_ids = 0;  ///< bit: a table of this id is broken
    bool warm = true;           ///< two tables have been through already
    std::uint8_t writer_deaths = 1, reader_deaths = 1;
    Mutant mutant = Mutant::none;
};

/// What stands for a table's bytes: written and read in two steps.
struct Slot {
    std::uint8_t id = 0, first = 0, last = 0;
    std::uint8_t checked_id = 0;  ///< of the contents that the checker passed in this life of the reader
};

/// pal_intake without its addresses.
struct Intake {
    std::uint8_t refused = 0, pending = NONE, pending_id = 0, now_id = 0;
    std::uint8_t now = NONE, before = NONE;
};

struct State {
    explore::Memory memory;
    std::array<Slot, PAL_TABLE_SLOTS> slot;
    Intake intake, at_poll;  ///< now; when the present poll began
    std::uint8_t n_published = 0;
    std::uint8_t fade_left = 0, used_id = 0;  ///< the tick's own
    std::uint8_t writer_deaths = 0, reader_deaths = 0;
};

class Hand : public explore::Machine {
public:
    using State = hand_over::State;
    explicit Hand(const Setting& setting) : setting_(setting) {}

    State begin() {
        State state;
        state_ = &state;
        empty(state);
        if (!setting_.warm) return state;
        // Two tables and two ids of room for the scenario's own.
        for (int i = 0; i < 2; ++i) {
            solo(state, WRITER);
            for (const Who who : {TICK, CHECKER, TICK, TICK}) solo(state, who);
        }
        for (auto& thread : state.memory.thread) thread.op = 0;
        return state;
    }

    [[nodiscard]] std::uint64_t hash(const State& s) const {
        explore::Hash hash;
        hash.add(s.memory, N_LOCATIONS);
        for (const Slot& slot : s.slot) hash.add(pack(slot.id, slot.first, slot.last, slot.checked_id));
        for (const Intake* i : {&s.intake, &s.at_poll}) {
            hash.add(std::uint64_t{pack(i->refused, i->pending, i->pending_id, i->now_id)} << 16U |
                     std::uint64_t{i->now} << 8U | i->before);
        }
        hash.add(std::uint64_t{pack(s.n_published, s.fade_left, s.used_id, s.writer_deaths)} << 8U |
                 s.reader_deaths);
        return hash.value();
    }

    [[nodiscard]] std::array<std::uint32_t, explore::N_THREADS> n_ops(const State&) const {
        return {setting_.n_publications, setting_.n_polls, setting_.n_checks};
    }

    Outcome advance(State& state, std::size_t who, std::size_t choice) {
        const Outcome outcome = advance_untidied(state, who, choice);
        tidy(state.memory, n_ops(state));
        return outcome;
    }

    [[nodiscard]] static std::size_t n_crashes() { return 2; }

    bool crash(State& state, std::size_t which) {
        explore::Memory& memory = state.memory;
        if (which == 0) {
            if (state.writer_deaths == setting_.writer_deaths || memory.thread[WRITER].n_log == 0)
                return false;
            ++state.writer_deaths;
            memory.thread[WRITER].n_log = 0;  // the next one publishes with the same number again
            return true;
        }
        if (state.reader_deaths == setting_.reader_deaths) return false;
        ++state.reader_deaths;
        // Another process: nothing of the old one's memory, but all that it saw happened before.
        join(memory, TICK, CHECKER);
        join(memory, CHECKER, TICK);
        for (const Who who : {TICK, CHECKER}) memory.thread[who].n_log = 0;
        reset(memory, INTAKE, PAL_INTAKE_IDLE);
        for (const Place place : {PENDING, PENDING_ID, NOW_ID}) forget(memory, place);
        state.intake = state.at_poll = Intake{};
        state.fade_left = state.used_id = 0;
        for (Slot& slot : state.slot) slot.checked_id = 0;
        return true;
    }

    /// Nobody is stuck: whatever happened, the next good table comes into use within a few polls.
    const char* end(const State& at) {
        State state = at;
        const std::uint32_t bad_ids = setting_.bad_ids;
        setting_.bad_ids = 0;
        const char* what = solo(state, WRITER);
        const std::uint32_t enough = setting_.fade_polls + 5;
        for (std::uint32_t i = 0; i < enough && what == nullptr && state.used_id != state.n_published; ++i) {
            what = solo(state, TICK);
            if (what == nullptr) what = solo(state, CHECKER);
        }
        setting_.bad_ids = bad_ids;
        if (what == nullptr && state.used_id != state.n_published)
            what = "the newest table never comes into use";
        return what;
    }

    /// The checker's look at a table.
    pal_err check(const pal_table* table) {
        const std::size_t at = slot_of(table);
        if (setting_.mutant == Mutant::not_checked) return PAL_OK;
        const std::uint32_t first = read(at, true);
        if (read(at, false) != first) fail("a torn table is checked");
        if (is_bad(first)) return PAL_ERR_CRC;
        state_->slot[at].checked_id = static_cast<std::uint8_t>(first);
        return PAL_OK;
    }

private:
    // --- the shipped code's addresses

    std::uint32_t on_load(const std::uint32_t* word, Order order) override {
        return load(location_of(word), order);
    }

    void on_store(std::uint32_t* word, std::uint32_t value, Order order) override {
        const Mutant relaxed = who() == CHECKER ? Mutant::relaxed_verdict : Mutant::relaxed_order;
        store(location_of(word), value, setting_.mutant == relaxed ? Order::relaxed : order);
    }

    bool on_swap(std::uint32_t* word, std::uint32_t* seen, std::uint32_t next) override {
        const std::size_t location = location_of(word);
        if (who() == WRITER && setting_.mutant == Mutant::not_dirty) next &= ~(1U << 8U);
        if (setting_.mutant == Mutant::split_words && who() == TICK) {
            const std::uint32_t was = *seen;
            const std::uint32_t half = (was & ~0xFU) | (next & 0xFU);
            if (!swap(location, seen, half, Order::acquire)) return false;
            *seen = half;
            return swap(location, seen, next, Order::acquire);
        }
        const Mutant relaxed = who() == WRITER ? Mutant::relaxed_publish : Mutant::relaxed_take;
        const bool swapped =
            swap(location, seen, next, setting_.mutant == relaxed ? Order::relaxed : Order::acquire);
        if (!is_permutation(next)) fail("the slots are no permutation");
        return swapped;
    }

    void on_note(const void* place, bool writes) override {
        plain(place_of(place), writes, [] { return 0U; });
    }

    std::size_t location_of(const std::uint32_t* word) {
        if (word == &ring_.state) return RING;
        if (word == &intake_.state) return INTAKE;
        fail("an atomic that the explorer does not know");
    }

    std::size_t place_of(const void* place) {
        if (place == &intake_.pending) return PENDING;
        if (place == &intake_.pending_id) return PENDING_ID;
        if (place == &intake_.now_id) return NOW_ID;
        return SLOTS + slot_of(static_cast<const pal_table*>(place));
    }

    std::size_t slot_of(const pal_table* table) {
        for (std::size_t i = 0; i < PAL_TABLE_SLOTS; ++i) {
            if (table == &ring_.slot[i].table) return i;
        }
        fail("a place that the explorer does not know");
    }

    static bool is_permutation(std::uint32_t s) {
        return (1U << (s & 3U) | 1U << (s >> 2U & 3U) | 1U << (s >> 4U & 3U) | 1U << (s >> 6U & 3U)) == 15U;
    }

    static std::uint32_t pack(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d) {
        return std::uint32_t{a} << 24U | std::uint32_t{b} << 16U | std::uint32_t{c} << 8U | d;
    }

    static void empty(State& state) {
        reset(state.memory, RING, 0xE4);  // PROTOCOL.md 1: the empty ring
        reset(state.memory, INTAKE, PAL_INTAKE_IDLE);
        for (auto& thread : state.memory.thread) thread.view.events = ~0U;
    }

    // --- the three threads

    void operation(std::size_t who) override {
        if (who == WRITER) publish();
        if (who == TICK) tick();
        if (who == CHECKER) pal_intake_check(&intake_);
    }

    void write(std::size_t at, bool first, std::uint8_t value) {
        plain(SLOTS + at, true, [&] {
            const Intake& reader = state_->intake;
            if (at == reader.now || (state_->fade_left > 0 && at == reader.before))
                fail("written while in use");
            Slot& slot = state_->slot[at];
            (first ? slot.first : slot.last) = value;
            if (first) slot.id = value;
            slot.checked_id = 0;
            return 0U;
        });
    }

    std::uint32_t read(std::size_t at, bool first) {
        return plain(SLOTS + at, false, [&] {
            const Slot& slot = state_->slot[at];
            return std::uint32_t{first ? slot.first : slot.last};
        });
    }

    void publish() {
        const pal_table* back = pal_table_ring_back(&ring_);
        if (back == nullptr) fail("no slot for the writer");
        const auto id = static_cast<std::uint8_t>(state_->n_published + 1);
        const std::size_t at = slot_of(back);
        write(at, true, id);
        write(at, false, id);
        if (!pal_table_ring_publish(&ring_)) fail("not published");
    }

    void use(std::size_t at, std::uint32_t id) {
        if (state_->slot[at].checked_id != id || is_bad(id)) fail("an unchecked table is used");
        const std::uint32_t first = read(at, true);
        if (first != id || read(at, false) != id) fail("a torn table is used");
    }

    void tick() {
        const bool fading = setting_.mutant != Mutant::take_in_fade && state_->fade_left > 0;
        const pal_loop_tables* tables = pal_intake_poll(&intake_, fading);
        if (tables->now == nullptr) return;
        const std::size_t now = slot_of(tables->now);
        const std::uint32_t id = state_->slot[now].id;
        if (id < state_->used_id) fail("ids go back");
        use(now, id);
        if (state_->fade_left == 0) return;
        if (tables->before == nullptr) fail("a fade loses the table before");
        const std::size_t before = slot_of(tables->before);
        use(before, state_->slot[before].id);
    }

    [[nodiscard]] bool is_bad(std::uint32_t id) const { return (setting_.bad_ids >> id & 1U) != 0; }

    // --- one step

    static std::uint8_t index_of(const pal_table* table) {
        if (table == nullptr) return NONE;
        for (std::uint8_t i = 0; i < PAL_TABLE_SLOTS; ++i) {
            if (table == &ring_.slot[i].table) return i;
        }
        return NONE;
    }

    static const pal_table* table_at(std::uint8_t i) { return i == NONE ? nullptr : &ring_.slot[i].table; }

    void lay_out(const State& state, std::size_t who) {
        for (std::size_t i = 0; i < PAL_TABLE_SLOTS; ++i) ring_.slot[i].table.id = state.slot[i].id;
        const Intake& from = who == TICK ? state.at_poll : state.intake;
        intake_ = {};
        intake_.ring = &ring_;
        intake_.refused = from.refused != 0;
        intake_.pending = table_at(from.pending);
        intake_.now_id = from.now_id;
        intake_.pending_id = state.intake.pending_id;  // the checker's
        intake_.tables.now = table_at(from.now);
        intake_.tables.before = table_at(from.before);
    }

    void pick_up(State& state) const {
        state.intake = {static_cast<std::uint8_t>(intake_.refused ? 1 : 0),
                        index_of(intake_.pending),
                        static_cast<std::uint8_t>(intake_.pending_id),
                        static_cast<std::uint8_t>(intake_.now_id),
                        index_of(intake_.tables.now),
                        index_of(intake_.tables.before)};
    }

    Outcome advance_untidied(State& state, std::size_t who, std::size_t choice) {
        state_ = &state;
        lay_out(state, who);
        const Outcome outcome = step(state.memory, who, choice);
        if (who != WRITER) pick_up(state);
        if (outcome != Outcome::finished) return outcome;
        if (who == WRITER) ++state.n_published;
        if (who == TICK) end_of_tick(state);
        return outcome;
    }

    // What the loop keeps beside the intake: a new table fades in while the one before is there.
    void end_of_tick(State& state) const {
        state.at_poll = state.intake;
        state.at_poll.pending_id = 0;
        if (state.fade_left > 0) --state.fade_left;
        if (state.intake.now == NONE) return;
        const std::uint8_t id = state.slot[state.intake.now].id;
        if (id == state.used_id) return;
        if (state.intake.before != NONE) state.fade_left = static_cast<std::uint8_t>(setting_.fade_polls);
        state.used_id = id;
    }

    /// Ends the present operation of one thread while the others rest, each load the newest.
    const char* solo(State& state, Who who) {
        for (std::size_t i = 0; i < explore::MAX_LOG; ++i) {
            const Outcome outcome = advance_untidied(state, who, 0);
            if (outcome == Outcome::failed) return failure();
            tidy(state.memory, {~0U, ~0U, ~0U});
            if (outcome == Outcome::finished) return nullptr;
        }
        return "an operation does not end alone";
    }

    Setting setting_;
    State* state_ = nullptr;
    static inline pal_table_ring ring_{};
    static inline pal_intake intake_{};
};

}  // namespace hand_over
