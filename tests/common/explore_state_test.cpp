// Every execution of the state ring: one writer that may be killed in the middle of a record, two readers,
// one of them just being overtaken, that may be killed too. state_ring.c is the shipped file, see
// explore.hpp; of the 64 words of a record the first and the last are steps, the others behave as these.
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <vector>

#include "common/state_ring.h"
#include "tests/common/explore.hpp"

namespace {

using explore::Order;
using Outcome = explore::Machine::Outcome;

enum Who : std::size_t {
    WRITER,
    NEAR,
    FAR
};  ///< a reader that is close behind, one that is about to be overtaken
enum Location : std::size_t { BEGUN, DONE, WORDS };
constexpr std::uint32_t N_BEFORE = 2 * PAL_STATE_RING_TICKS;  ///< records that are there already
constexpr std::uint32_t N_NEW = 3;                            ///< places in the ring that are steps
constexpr std::size_t N_LOCATIONS = WORDS + 2 * N_NEW, LAST_WORD = PAL_TICK_WORDS - 1;

enum class Mutant : std::uint8_t {
    none,
    done_first,     ///< `done` is stored before the words
    relaxed_words,  ///< who sees a new word need not see `begun`
    relaxed_done,   ///< who sees `done` need not see the words
    blind           ///< a reader does not look at `begun` after its copy
};

struct Setting {
    std::uint32_t n_records = 2, n_near = 2, n_far = 2;  ///< records written; reads by each reader
    std::uint8_t writer_deaths = 1, reader_deaths = 1;
    Mutant mutant = Mutant::none;
};

struct State {
    explore::Memory memory;
    std::array<pal_state_reader, explore::N_THREADS> reader{};  ///< when the present read began
    std::array<std::uint8_t, explore::N_THREADS> deaths{};
};

class Ring : public explore::Machine {
public:
    using State = ::State;
    explicit Ring(const Setting& setting) : setting_(setting) {}

    static State begin() {
        State state;
        reset(state.memory, BEGUN, N_BEFORE);
        reset(state.memory, DONE, N_BEFORE);
        for (std::uint32_t n = 0; n < N_NEW; ++n) {
            for (std::size_t k = 0; k < 2; ++k) {
                reset(state.memory, WORDS + 2 * n + k, content(N_BEFORE - PAL_STATE_RING_TICKS + n, 0));
            }
        }
        for (auto& thread : state.memory.thread) thread.view.events = ~0U;
        state.reader[NEAR] = {.next = N_BEFORE - 1, .n_dropped = 0};
        state.reader[FAR] = {.next = N_BEFORE - PAL_STATE_RING_TICKS, .n_dropped = 0};
        return state;
    }

    [[nodiscard]] static std::uint64_t hash(const State& s) {
        explore::Hash hash;
        hash.add(s.memory, N_LOCATIONS);
        for (const auto& r : s.reader) hash.add(std::uint64_t{r.next} << 32U | r.n_dropped);
        for (const auto n : s.deaths) hash.add(n);
        return hash.value();
    }

    [[nodiscard]] std::array<std::uint32_t, explore::N_THREADS> n_ops(const State&) const {
        return {setting_.n_records, setting_.n_near, setting_.n_far};
    }

    Outcome advance(State& state, std::size_t who, std::size_t choice) {
        state_ = &state;
        reader_ = state.reader[who];
        const Outcome outcome = step(state.memory, who, choice);
        if (outcome == Outcome::finished) state.reader[who] = reader_;
        tidy(state.memory, n_ops(state));
        return outcome;
    }

    [[nodiscard]] static std::size_t n_crashes() { return explore::N_THREADS; }

    /// The writer's next life writes the same record again, with other words in it; a reader's begins at
    /// nothing.
    bool crash(State& state, std::size_t who) const {
        auto& thread = state.memory.thread[who];
        const std::uint8_t allowed = who == WRITER ? setting_.writer_deaths : setting_.reader_deaths;
        if (thread.n_log == 0 || thread.op >= n_ops(state)[who] || state.deaths[who] == allowed) return false;
        ++state.deaths[who];
        thread.n_log = 0;
        state.reader[who] = {.next = 0, .n_dropped = 0};
        return true;
    }

    /// Left alone, each reader moves on until it has read the newest record.
    const char* end(const State& at) {
        State state = at;
        const auto& done = state.memory.atomic[DONE];
        const std::uint32_t newest = done.store[done.n_stores - 1].value;
        for (const Who who : {NEAR, FAR}) {
            const std::uint32_t next = state.reader[who].next;
            if (next == newest) continue;
            Outcome outcome = Outcome::stepped;
            while (outcome == Outcome::stepped) outcome = advance(state, who, 0);
            if (outcome == Outcome::failed) return failure();
            if (state.reader[who].next == next) return "a reader is stuck";
        }
        return nullptr;
    }

private:
    /// A word of record n by the writer's life; never 0.
    static std::uint32_t content(std::uint32_t n, std::uint32_t life) { return n << 4U | life << 1U | 1U; }

    void operation(std::size_t who) override {
        if (who == WRITER) {
            write();
        } else {
            read();
        }
    }

    void write() {
        const std::uint32_t n = N_BEFORE + memory().thread[WRITER].op;
        pal_tick tick{};
        std::uint32_t words[PAL_TICK_WORDS] = {};
        words[0] = words[LAST_WORD] = content(n, state_->deaths[WRITER]);
        std::memcpy(&tick, words, sizeof tick);
        pal_state_ring_push(&ring_, &tick);
    }

    void read() {
        const pal_state_reader was = reader_;
        n_looks_ = 0;
        pal_tick tick{};
        const bool got = pal_state_ring_read(&ring_, &reader_, &tick);
        if (reader_.next - was.next != reader_.n_dropped - was.n_dropped + (got ? 1U : 0U)) {
            fail("read and dropped are not all");
        }
        if (!got) return;
        std::uint32_t words[PAL_TICK_WORDS];
        std::memcpy(words, &tick, sizeof words);
        if (words[0] != words[LAST_WORD]) fail("a torn record is read");
        if (words[0] >> 4U != reader_.next - 1U) fail("another record than the one asked for is read");
    }

    // The old records beyond the places that are steps never change.
    static std::uint32_t old_record(std::size_t place) {
        return N_BEFORE - PAL_STATE_RING_TICKS + static_cast<std::uint32_t>(place);
    }

    std::uint32_t on_load(const std::uint32_t* word, Order order) override {
        if (word == &ring_.done) return load(DONE, order);
        if (word == &ring_.begun) {
            const std::uint32_t begun = load(BEGUN, order);
            const bool after_copy = n_looks_++ % 2 == 1;
            return after_copy && setting_.mutant == Mutant::blind ? reader_.next : begun;
        }
        const auto [place, index] = place_of(word);
        if (index != 0 && index != LAST_WORD) return 0;
        if (place >= N_NEW) return content(old_record(place), 0);
        return load(WORDS + 2 * place + (index == 0 ? 0 : 1), order);
    }

    void on_store(std::uint32_t* word, std::uint32_t value, Order order) override {
        if (word == &ring_.begun) {
            store(BEGUN, value, order);
            if (setting_.mutant == Mutant::done_first) store(DONE, value, Order::release);
            return;
        }
        if (word == &ring_.done) {
            if (setting_.mutant == Mutant::done_first) return;
            store(DONE, value, setting_.mutant == Mutant::relaxed_done ? Order::relaxed : order);
            return;
        }
        const auto [place, index] = place_of(word);
        if (index != 0 && index != LAST_WORD) return;
        if (place >= N_NEW) fail("written beyond the scenario");
        store(WORDS + 2 * place + (index == 0 ? 0 : 1), value,
              setting_.mutant == Mutant::relaxed_words ? Order::relaxed : order);
    }

    bool on_swap(std::uint32_t*, std::uint32_t*, std::uint32_t) override {
        fail("the state ring has no exchange");
    }
    void on_note(const void*, bool) override { fail("the state ring has no plain access"); }

    struct At {
        std::size_t place, index;
    };
    static At place_of(const std::uint32_t* word) {
        const auto n = static_cast<std::size_t>(word - &ring_.word[0][0]);
        return {n / PAL_TICK_WORDS, n % PAL_TICK_WORDS};
    }

    Setting setting_;
    State* state_ = nullptr;
    pal_state_reader reader_{};
    std::uint32_t n_looks_ = 0;  ///< at `begun` in this read: one before each copy, one after
    static inline pal_state_ring ring_{};
};

explore::Result run(const Setting& setting) {
    Ring ring(setting);
    return explore::explore(ring);
}

}  // namespace

TEST_CASE("in no execution is a record torn, out of order, lost without being counted, or a reader stuck") {
    std::vector<Setting> settings = {{2, 2, 2, 0, 0}, {2, 0, 2, 1, 1}};
    if (!explore::SANITIZED) {
        const std::array<Setting, 4> more = {
            {{2, 2, 2, 1, 0}, {3, 2, 2, 0, 0}, {3, 0, 3, 1, 1}, {3, 3, 0, 1, 1}}};
        settings.insert(settings.end(), more.begin(), more.end());
    }
    if (explore::soak()) settings.push_back({3, 2, 2, 1, 0});
    std::size_t n_states = 0, n_steps = 0;
    for (const Setting& setting : settings) {
        const explore::Result result = run(setting);
        INFO(setting.n_records << " records, " << setting.n_near << " and " << setting.n_far
                               << " reads:" << result.trace);
        CHECK(result.failure.empty());
        CHECK(result.n_ends > 0);
        n_states += result.n_states;
        n_steps += result.n_steps;
    }
    WARN(n_states << " states, " << n_steps << " steps");
}

TEST_CASE("the explorer finds what each mutant of the state ring does") {
    struct Case {
        Mutant mutant;
        const char* failure;
    };
    const auto [mutant, failure] = GENERATE(values<Case>({
        {Mutant::done_first, "a torn record is read"},
        {Mutant::relaxed_done, "a torn record is read"},
        {Mutant::relaxed_words, "another record than the one asked for is read"},
        {Mutant::blind, "another record than the one asked for is read"},
    }));
    CHECK(run({2, 2, 2, 0, 0, mutant}).failure == failure);
}
