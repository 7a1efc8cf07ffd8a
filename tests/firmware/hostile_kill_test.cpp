// Two processes over one mapping, killed at random moments in the middle of what they do: a host that
// publishes without pause and a loop's intake. 20 kills, 1000 with PALPATE_SOAK.
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <random>

#include "firmware/core/intake.h"
#include "tests/common/tables.hpp"

namespace {

constexpr std::uint32_t N_NODES = 33, FADE_POLLS = 4;
/// From the poll that finds a table in the ring to the one that uses it: the one that takes up what was
/// checked before, the fade that it begins, take, use.
constexpr std::uint32_t POLLS_MOST = 1 + FADE_POLLS + 2;

/// What lies in the mapping. Each word has one writer.
struct Shared {
    pal_table_ring ring;
    alignas(64) std::uint32_t last_id;   ///< of the writer: begun, published or not
    std::uint32_t writing;               ///< between the first word of a table and its publication
    alignas(64) std::uint32_t n_tables;  ///< of the reader: taken into use in this life
    std::uint32_t now_id, n_torn, n_back, polls_most;
};

std::uint32_t get(const std::uint32_t& word) {
    return __atomic_load_n(&word, __ATOMIC_ACQUIRE);
}

void set(std::uint32_t& word, std::uint32_t value) {
    __atomic_store_n(&word, value, __ATOMIC_RELEASE);
}

/// Every word that may vary is a function of the id.
void build(pal_table& table, std::uint32_t id) {
    static const auto plain = tables::make({}, N_NODES);
    std::memcpy(&table, plain.get(), plain->n_bytes);
    table.id = id;
    table.source_hash = id * 0x9E3779B97F4A7C15ULL;
    table.tick = id * 40U;
    table.law = id % 2;
    table.error_k_relative = static_cast<float>(id % 97) * 1e-3F;
    for (int i = 0; i < 3; ++i) table.p0_m[i] = table.made_for_m[i] = static_cast<float>(id % 89) * 1e-3F;
    const std::uint32_t n_plane = (N_NODES + 2) * (N_NODES + 2);
    for (std::uint32_t i = 0; i < n_plane; ++i) {
        const std::uint32_t word = (id + i) * 2654435761U >> 20U;  // 0 to 4095
        table.coef[i] = static_cast<float>(word) * 1e-7F;
        table.coef[n_plane + i] = 500.0F + static_cast<float>(word) * 0.1F;
        table.coef[2 * n_plane + i] = static_cast<float>(word);
    }
    pal_table_seal(&table);
}

[[noreturn]] void run_host(Shared& shared) {
    for (;;) {
        const std::uint32_t id = get(shared.last_id) + 1;
        set(shared.last_id, id);
        pal_table* back = pal_table_ring_back(&shared.ring);
        if (back == nullptr) _exit(9);
        set(shared.writing, 1);
        build(*back, id);
        if (!pal_table_ring_publish(&shared.ring)) _exit(9);
        set(shared.writing, 0);
    }
}

/// A table in use and what must be in it, kept in the process's own memory.
struct Held {
    const pal_table* table = nullptr;
    std::unique_ptr<pal_table> words = std::make_unique<pal_table>();
    [[nodiscard]] bool is_whole() const {
        return table == nullptr || std::memcmp(table, words.get(), words->n_bytes) == 0;
    }
};

[[noreturn]] void run_loop(Shared& shared) {
    pal_intake intake{};
    intake.ring = &shared.ring;
    intake.limits = pal_table_limits_default();
    Held now, before;
    std::uint32_t fade_left = 0, waited = 0, n_tables = 0;
    for (;;) {
        const bool dirty = (get(shared.ring.state) >> 8U & 1U) != 0;
        const std::uint64_t was = intake.now_id;
        const pal_loop_tables* tables = pal_intake_poll(&intake, fade_left > 0);
        if (fade_left > 0) --fade_left;
        if (intake.now_id == was) {
            waited = dirty || waited > 0 ? waited + 1 : 0;
        } else {
            if (intake.now_id < was) set(shared.n_back, shared.n_back + 1);
            std::swap(now, before);
            now.table = tables->now;
            before.table = tables->before;
            build(*now.words, static_cast<std::uint32_t>(intake.now_id));
            if (before.table != nullptr) fade_left = FADE_POLLS;
            waited = 0;
            set(shared.now_id, static_cast<std::uint32_t>(intake.now_id));
            set(shared.n_tables, ++n_tables);
        }
        if (waited > shared.polls_most) set(shared.polls_most, waited);
        const bool whole =
            now.is_whole() && (fade_left == 0 || before.is_whole()) && intake.tables.n_bad == 0;
        if (!whole) set(shared.n_torn, shared.n_torn + 1);
        (void)pal_intake_check(&intake);
    }
}

pid_t start(Shared& shared, void (*run)(Shared&)) {
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child != 0) return child;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(0);
    run(shared);
    _exit(0);
}

/// True when it died of that and of nothing before.
bool kill_it(pid_t child) {
    int status = 0;
    return kill(child, SIGKILL) == 0 && waitpid(child, &status, 0) == child && WIFSIGNALED(status) &&
           WTERMSIG(status) == SIGKILL;
}

/// Bounded; how long it takes is the machine's affair.
template <typename Condition>
bool comes(Condition&& condition) {
    for (int i = 0; i < 60000; ++i) {
        if (condition()) return true;
        usleep(500);
    }
    return false;
}

}  // namespace

TEST_CASE("host and loop killed at any moment: no torn table, no id that goes back, nobody stuck") {
    const int n_kills = std::getenv("PALPATE_SOAK") != nullptr ? 1000 : 20;
    const std::uint32_t seed = std::random_device{}();
    std::mt19937 random(seed);
    void* memory = mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    REQUIRE(memory != MAP_FAILED);
    auto& shared = *new (memory) Shared{};
    pal_table_ring_init(&shared.ring);
    pid_t host = start(shared, run_host), loop = start(shared, run_loop);
    int n_in_table = 0, n_stuck = 0, n_died_alone = 0;
    for (int n = 0; n < n_kills; ++n) {
        usleep(1000 + static_cast<useconds_t>(random() % 10000));
        if (random() % 2 == 0) {
            n_died_alone += kill_it(host) ? 0 : 1;
            n_in_table += static_cast<int>(get(shared.writing));
            const std::uint32_t last_id = get(shared.last_id);
            host = start(shared, run_host);
            n_stuck += comes([&] { return get(shared.now_id) > last_id; }) ? 0 : 1;
        } else {
            n_died_alone += kill_it(loop) ? 0 : 1;
            set(shared.n_tables, 0);
            loop = start(shared, run_loop);
            n_stuck += comes([&] { return get(shared.n_tables) > 1; }) ? 0 : 1;
        }
    }
    CHECK(kill_it(host));
    CHECK(kill_it(loop));
    INFO("seed " << seed);
    CHECK(n_stuck == 0);
    CHECK(n_died_alone == 0);
    CHECK(get(shared.n_torn) == 0);
    CHECK(get(shared.n_back) == 0);
    CHECK(get(shared.polls_most) <= POLLS_MOST);
    WARN("seed " << seed << ": " << n_kills << " kills, " << n_in_table << " in the middle of a table, "
                 << get(shared.last_id) << " tables begun, at most " << get(shared.polls_most)
                 << " polls from ring to use");
    munmap(memory, sizeof(Shared));
}
