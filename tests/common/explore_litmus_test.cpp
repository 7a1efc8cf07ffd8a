// The explorer's memory against the C11 model: the outcomes of the classic small programs, allowed and
// forbidden.
#include <catch2/catch.hpp>
#include <set>

#include "tests/common/explore.hpp"

namespace {

using explore::Order;

enum Location : std::size_t { X, Y, N_LOCATIONS };
constexpr std::uint32_t NOTHING = 9;

/// Threads that do no more than a few accesses; what each of two reads answered is the outcome.
struct State {
    explore::Memory memory;
    std::array<std::uint32_t, 2> read{NOTHING, NOTHING};
};

using Program = void (*)(class Litmus&, std::size_t thread);

class Litmus : public explore::Machine {
public:
    using State = ::State;
    explicit Litmus(Program program) : program_(program) {}

    static State begin() {
        State state;
        reset(state.memory, X, 0);
        reset(state.memory, Y, 0);
        for (auto& thread : state.memory.thread) thread.view.events = ~0U;
        return state;
    }
    static std::uint64_t hash(const State& s) {
        explore::Hash hash;
        hash.add(s.memory, N_LOCATIONS);
        for (const std::uint32_t r : s.read) hash.add(r);
        return hash.value();
    }
    static std::array<std::uint32_t, explore::N_THREADS> n_ops(const State&) { return {1, 1, 1}; }
    Outcome advance(State& state, std::size_t thread, std::size_t choice) {
        state_ = &state;
        const Outcome outcome = step(state.memory, thread, choice);
        tidy(state.memory, n_ops(state));
        return outcome;
    }
    static std::size_t n_crashes() { return 0; }
    static bool crash(State&, std::size_t) { return false; }
    const char* end(const State& state) {
        outcomes.insert(state.read);
        return nullptr;
    }
    void answer(std::size_t which, std::uint32_t value) { state_->read[which] = value; }
    void use(bool writes) {
        plain(0, writes, [] { return 0U; });
    }
    std::set<std::array<std::uint32_t, 2>> outcomes;

private:
    void operation(std::size_t thread) override { program_(*this, thread); }
    std::uint32_t on_load(const std::uint32_t*, Order) override { fail("no shipped code here"); }
    void on_store(std::uint32_t*, std::uint32_t, Order) override { fail("no shipped code here"); }
    bool on_swap(std::uint32_t*, std::uint32_t*, std::uint32_t) override { fail("no shipped code here"); }
    void on_note(const void*, bool) override { fail("no shipped code here"); }

    Program program_;
    State* state_ = nullptr;
};

struct Answers {
    std::set<std::array<std::uint32_t, 2>> outcomes;
    std::string failure;
};

Answers all(Program program) {
    Litmus litmus(program);
    const explore::Result result = explore::explore(litmus);
    return {litmus.outcomes, result.failure};
}

using Outcomes = std::set<std::array<std::uint32_t, 2>>;

/// X is stored, then Y; the other thread reads Y, then X.
template <Order STORE, Order LOAD>
void message(Litmus& m, std::size_t thread) {
    if (thread == 0) {
        m.store(X, 1, Order::relaxed);
        m.store(Y, 1, STORE);
    } else if (thread == 1) {
        const std::uint32_t y = m.load(Y, LOAD);
        const std::uint32_t x = m.load(X, Order::relaxed);
        m.answer(0, y);
        m.answer(1, x);
    }
}

/// The same with plain memory in place of X, read only when Y has come.
template <Order STORE, Order LOAD>
void plain_message(Litmus& m, std::size_t thread) {
    if (thread == 0) {
        m.use(true);
        m.store(Y, 1, STORE);
    } else if (thread == 1 && m.load(Y, LOAD) == 1) {
        m.use(false);
    }
}

}  // namespace

TEST_CASE(
    "message passing: with release and acquire the message is there, without one of them it may not be") {
    const Outcomes ordered = {{0, 0}, {0, 1}, {1, 1}};
    const Outcomes any = {{0, 0}, {0, 1}, {1, 0}, {1, 1}};
    CHECK(all(message<Order::release, Order::acquire>).outcomes == ordered);
    CHECK(all(message<Order::relaxed, Order::acquire>).outcomes == any);
    CHECK(all(message<Order::release, Order::relaxed>).outcomes == any);
}

TEST_CASE("plain memory behind a flag is a race unless the flag is released and acquired") {
    CHECK(all(plain_message<Order::release, Order::acquire>).failure.empty());
    CHECK(all(plain_message<Order::relaxed, Order::acquire>).failure == "race: read with a write");
    CHECK(all(plain_message<Order::release, Order::relaxed>).failure == "race: read with a write");
}

TEST_CASE("store buffering: release and acquire let both threads miss the other's store") {
    const auto answers = all([](Litmus& m, std::size_t thread) {
        if (thread == 2) return;
        m.store(thread == 0 ? X : Y, 1, Order::release);
        m.answer(thread, m.load(thread == 0 ? Y : X, Order::acquire));
    });
    CHECK(answers.outcomes == Outcomes{{0, 0}, {0, 1}, {1, 0}, {1, 1}});
}

TEST_CASE("coherence: one thread never reads a word's past after its present") {
    const auto answers = all([](Litmus& m, std::size_t thread) {
        if (thread == 0) m.store(X, 1, Order::relaxed);
        if (thread != 1) return;
        const std::uint32_t first = m.load(X, Order::relaxed);
        const std::uint32_t second = m.load(X, Order::relaxed);
        m.answer(0, first);
        m.answer(1, second);
    });
    CHECK(answers.outcomes == Outcomes{{0, 0}, {0, 1}, {1, 1}});
}

TEST_CASE("a relaxed exchange by a third thread passes a release on") {
    const auto answers = all([](Litmus& m, std::size_t thread) {
        if (thread == 0) {
            m.use(true);
            m.store(Y, 1, Order::release);
        } else if (thread == 1) {
            std::uint32_t seen = 1;
            m.swap(Y, &seen, 2, Order::relaxed);
        } else if (m.load(Y, Order::acquire) == 2) {
            m.use(false);
        }
    });
    CHECK(answers.failure.empty());
}

TEST_CASE("of two exchanges of one value one succeeds") {
    const auto answers = all([](Litmus& m, std::size_t thread) {
        if (thread == 2) return;
        std::uint32_t seen = 0;
        m.answer(thread, m.swap(X, &seen, 1, Order::relaxed) ? 1 : 0);
    });
    CHECK(answers.outcomes == Outcomes{{0, 1}, {1, 0}});
}

TEST_CASE("a write behind a read is a race unless the read is told") {
    CHECK(all([](Litmus& m, std::size_t thread) {
              if (thread == 0) {
                  m.use(false);
                  m.store(Y, 1, Order::release);
              } else if (thread == 1 && m.load(Y, Order::acquire) == 1) {
                  m.use(true);
              }
          }).failure.empty());
    CHECK(all([](Litmus& m, std::size_t thread) {
              if (thread < 2) m.use(thread == 1);
          }).failure.find("race") == 0);
}
