/// An explorer of all executions of C code on shared memory, under the C11 model and not just in turn.
///
/// Shipped .c files are compiled with PAL_ATOMIC_HOOK, so that each atomic and each noted access of plain
/// memory that changes hands is a step. A thread's next step is made by running its present operation again
/// from the start, with what the earlier steps answered taken from a log; so a state is plain data that can
/// be copied, hashed and gone back to.
///
/// Memory (release and acquire as in RC11, Lahav et al. 2017): an atomic keeps its past values; a load may
/// answer any that its thread has not yet been told to be overwritten; a release store carries all that its
/// thread knows, an acquire load receives it, an exchange adds to what it read. A write of plain memory that
/// does not know of the last write and the last reads of the place, or a read that does not know of the last
/// write, is a data race.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace explore {

constexpr std::size_t N_THREADS = 3, MAX_LOCATIONS = 10, MAX_STORES = 12, MAX_LOG = 64, MAX_PLACES = 8;

/// Sanitizers have nothing to find in the explorer's one thread and are slow at it: they get small scenarios.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool SANITIZED = true;
#else
constexpr bool SANITIZED = false;
#endif

/// PALPATE_SOAK is set: the long size.
inline bool soak() {
    return std::getenv("PALPATE_SOAK") != nullptr;
}

/// What a thread, or a reader of a store, knows.
struct View {
    std::array<std::uint8_t, MAX_LOCATIONS>
        at{};                    ///< of each atomic: the oldest store that may still be read
    std::uint32_t events = ~0U;  ///< bit set: that access of a plain place is known
};

struct Store {
    std::uint32_t value = 0;
    View view;
};

struct Atomic {
    std::size_t n_stores = 0;
    std::array<Store, MAX_STORES> store;
};

struct Thread {
    View view;
    std::uint32_t op = 0;     ///< operations done
    std::uint32_t n_log = 0;  ///< steps of the present one
    std::array<std::uint32_t, MAX_LOG> log{};
};

struct Memory {
    std::array<Atomic, MAX_LOCATIONS> atomic;
    std::array<Thread, N_THREADS> thread;
};

enum class Order : std::uint8_t { relaxed, release, acquire };

/// Takes the steps. One object at a time is `Machine::running`: the hooks go there.
class Machine {
public:
    virtual ~Machine() = default;

    // For the hooks and for what surrounds the shipped code. Each call is one step.
    std::uint32_t load(std::size_t location, Order order);
    void store(std::size_t location, std::uint32_t value, Order order);
    bool swap(std::size_t location, std::uint32_t* seen, std::uint32_t next, Order order);
    /// A plain access; `value` is what it answers, asked for when the step is taken.
    template <typename Access>
    std::uint32_t plain(std::size_t place, bool writes, Access&& access) {
        std::uint32_t answer = 0;
        if (replayed(&answer)) return answer;
        race(place, writes);
        return done(access());
    }
    /// Ends the run: something that must never be is.
    [[noreturn]] void fail(const char* what);

    // What the addresses of the shipped code are; called by the hooks.
    virtual std::uint32_t on_load(const std::uint32_t* word, Order order) = 0;
    virtual void on_store(std::uint32_t* word, std::uint32_t value, Order order) = 0;
    virtual bool on_swap(std::uint32_t* word, std::uint32_t* seen, std::uint32_t next) = 0;
    virtual void on_note(const void* place, bool writes) = 0;

    [[nodiscard]] std::size_t who() const { return who_; }
    [[nodiscard]] Memory& memory() { return *memory_; }
    static Machine* running;

    enum class Outcome : std::uint8_t { stepped, finished, failed, impossible };
    /// The next step of `thread`; where it can answer several values, the one numbered `choice` (0: the
    /// newest). `finished`: the operation ended with this step.
    Outcome step(Memory& memory, std::size_t thread, std::size_t choice);
    /// Of the last step.
    [[nodiscard]] std::size_t n_choices() const { return n_choices_; }
    [[nodiscard]] const char* failure() const { return failure_; }

protected:
    /// Runs the present operation of `thread`; the shipped functions call the hooks.
    virtual void operation(std::size_t thread) = 0;

    /// A new atomic holding `value`, known to all.
    static void reset(Memory& memory, std::size_t location, std::uint32_t value);
    /// Accesses of `place` until now are known to all.
    static void forget(Memory& memory, std::size_t place);
    /// `thread` knows what `other` knows.
    static void join(Memory& memory, std::size_t thread, std::size_t other);
    /// Drops stores that no thread below its `n_ops` can read any more.
    static void tidy(Memory& memory, const std::array<std::uint32_t, N_THREADS>& n_ops);

private:
    bool replayed(std::uint32_t* answer);
    std::uint32_t done(std::uint32_t answer);
    void race(std::size_t place, bool writes);
    std::size_t chosen(std::size_t location);
    Thread& me() { return memory_->thread[who_]; }

    Memory* memory_ = nullptr;
    std::size_t who_ = 0, choice_ = 0, n_choices_ = 1, cursor_ = 0;
    bool taken_ = false;
    const char* failure_ = nullptr;
};

/// 64-bit hashes of the states seen.
class Seen {
public:
    /// True when it was not there.
    bool add(std::uint64_t hash);
    [[nodiscard]] std::size_t size() const { return n_; }

private:
    std::vector<std::uint64_t> cell_ = std::vector<std::uint64_t>(std::size_t{1} << 16U);
    std::size_t n_ = 0;
};

/// Takes words in, gives a hash out.
class Hash {
public:
    void add(std::uint64_t word) {
        value_ = (value_ ^ word) * 0x9FB21C651E98DF25ULL;
        value_ ^= value_ >> 29U;
    }
    void add(const View& view);
    /// All of it that matters.
    void add(const Memory& memory, std::size_t n_locations);
    [[nodiscard]] std::uint64_t value() const { return value_; }

private:
    std::uint64_t value_ = 0x243F6A8885A308D3ULL;
};

struct Result {
    std::size_t n_states = 0, n_steps = 0,
                n_ends = 0;  ///< different states; steps taken; states where all is done
    std::string failure;     ///< empty: none
    std::string trace;       ///< the steps that led there
};

/// All executions of a scenario. `Scenario` is a Machine with a type State (plain data, `Memory memory` in
/// it) and
///   State begin(), std::uint64_t hash(const State&),
///   std::array<std::uint32_t, N_THREADS> n_ops(const State&): operations that each thread has to do,
///   Outcome advance(State&, thread, choice): one step, with what a scenario keeps beside the memory,
///   std::size_t n_crashes() and bool crash(State&, which): kills and restarts; false when it cannot be now,
///   const char* end(const State&): what is wrong where nothing is left to do; nullptr: nothing.
template <typename Scenario>
Result explore(Scenario& scenario) {
    struct Frame {
        typename Scenario::State state;
        std::size_t thread = 0, choice = 0, crash = 0;
        char last[24] = {};
    };
    Result result;
    Seen seen;
    std::vector<Frame> stack;
    const auto found = [&](const char* what) {
        result.failure = what;
        for (std::size_t i = 1; i < stack.size(); ++i) result.trace += stack[i].last;
    };
    const auto enter = [&](const Frame& frame) {
        if (!seen.add(scenario.hash(frame.state))) return true;
        stack.push_back(frame);
        stack.back().thread = stack.back().choice = stack.back().crash = 0;
        const auto n_ops = scenario.n_ops(frame.state);
        for (std::size_t t = 0; t < N_THREADS; ++t) {
            if (frame.state.memory.thread[t].op < n_ops[t]) return true;
        }
        ++result.n_ends;
        if (const char* what = scenario.end(frame.state)) return found(what), false;
        return true;
    };
    Frame next{.state = scenario.begin()};
    bool ok = enter(next);
    while (ok && !stack.empty()) {
        Frame& top = stack.back();
        if (top.thread < N_THREADS) {
            if (top.state.memory.thread[top.thread].op >= scenario.n_ops(top.state)[top.thread]) {
                ++top.thread;
                continue;
            }
            next.state = top.state;
            const auto outcome = scenario.advance(next.state, top.thread, top.choice);
            std::snprintf(next.last, sizeof next.last, " %zu.%zu", top.thread, top.choice);
            if (++top.choice >= scenario.n_choices()) {
                top.choice = 0;
                ++top.thread;
            }
            if (outcome == Scenario::Outcome::impossible) continue;
            ++result.n_steps;
            if (outcome == Scenario::Outcome::failed) {
                stack.push_back(next);
                found(scenario.failure());
                break;
            }
            ok = enter(next);
        } else if (top.crash < scenario.n_crashes()) {
            next.state = top.state;
            std::snprintf(next.last, sizeof next.last, " dies%zu", top.crash);
            if (scenario.crash(next.state, top.crash++)) {
                ++result.n_steps;
                ok = enter(next);
            }
        } else {
            stack.pop_back();
        }
    }
    result.n_states = seen.size();
    return result;
}

}  // namespace explore
