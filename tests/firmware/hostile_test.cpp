// Somebody writes anything at all into the segment at any moment. The tick reads nothing beyond it, the
// motors stay within force_max_n and their own range, and no number becomes infinite or none.
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <thread>
#include <vector>

#include "tests/firmware/hostile_bench.hpp"

namespace {

using hostile::Bench;

int size(int usual, int soak) {
    return std::getenv("PALPATE_SOAK") != nullptr ? soak : usual;
}

std::unique_ptr<pal_link> new_link() {
    auto link = std::make_unique<pal_link>();
    pal_link_init(link.get(), 1);
    return link;
}

bool publish(pal_link& link, const pal_table& table) {
    pal_table* back = pal_table_ring_back(&link.tables);
    if (back == nullptr) return false;
    std::memcpy(back, &table, table.n_bytes);
    return pal_table_ring_publish(&link.tables);
}

/// NaN, infinities, the largest, the smallest, zeros and a few that a header may hold.
constexpr std::array<std::uint32_t, 12> ODD_FLOATS = {0x7FC00000, 0x7F800000, 0xFF800000, 0x7F7FFFFF,
                                                      0xFF7FFFFF, 0x00000001, 0x00000000, 0x80000000,
                                                      0x3F800000, 0x49742400, 0xC9742400, 0x33D6BF95};

/// Writes words of the segment, one by one, as a broken process would.
class Vandal {
public:
    Vandal(pal_link& link, std::uint32_t seed) : link_(&link), random_(seed), table_(hostile::uneven(1)) {}

    void act() {
        switch (random_() % 16) {
            case 0:
                write(word(pick(sizeof *link_)), any());
                break;  // anywhere
            case 1:
                write(header_word(), any());
                break;
            case 2:
                write(header_word(), ODD_FLOATS[random_() % ODD_FLOATS.size()]);
                break;
            case 3:
                flip(header_word());
                break;
            case 4:
                write(coefficient(), ODD_FLOATS[random_() % ODD_FLOATS.size()]);
                break;
            case 5:
                flip(coefficient());
                break;
            case 6:
                write(nodes_word(), any() % 70);
                break;
            case 7:
                write(rings_word(), any());
                break;
            case 8:
                flip(rings_word());
                break;
            case 9:
                pal_link_store(&link_->tables.state, 0xE4);
                break;  // whole again
            default:
                good_table();
                break;
        }
    }
    [[nodiscard]] std::uint64_t n_acts() const { return n_acts_; }

private:
    std::uint32_t any() { return static_cast<std::uint32_t>(random_()); }
    std::uint32_t* word(std::size_t byte) { return reinterpret_cast<std::uint32_t*>(link_) + byte / 4; }
    std::size_t pick(std::size_t n_bytes) { return random_() % n_bytes; }
    std::size_t slot() {
        const auto* first = reinterpret_cast<const std::uint8_t*>(link_);
        return static_cast<std::size_t>(
            reinterpret_cast<const std::uint8_t*>(&link_->tables.slot[random_() % PAL_TABLE_SLOTS]) - first);
    }
    std::uint32_t* header_word() { return word(slot() + pick(offsetof(pal_table, coef))); }
    std::uint32_t* nodes_word() { return word(slot() + offsetof(pal_table, n_nodes)); }
    std::uint32_t* coefficient() { return word(slot() + offsetof(pal_table, coef) + pick(3 * 19 * 19 * 4)); }
    std::uint32_t* rings_word() {
        const std::array<std::uint32_t*, 3> words = {&link_->tables.state, &link_->ticks.begun,
                                                     &link_->ticks.done};
        return words[random_() % words.size()];
    }
    void write(std::uint32_t* at, std::uint32_t value) {
        __atomic_store_n(at, value, __ATOMIC_RELAXED);
        ++n_acts_;
    }
    void flip(std::uint32_t* at) {
        __atomic_fetch_xor(at, 1U << random_() % 32, __ATOMIC_RELAXED);
        ++n_acts_;
    }
    /// So that there is something in use to spoil.
    void good_table() {
        table_->id = ++last_id_;
        pal_table_seal(table_.get());
        const pal_table* back = pal_table_ring_back(&link_->tables);
        if (back == nullptr) return;
        const auto* words = reinterpret_cast<const std::uint32_t*>(table_.get());
        auto* to = const_cast<std::uint32_t*>(reinterpret_cast<const std::uint32_t*>(back));
        for (std::size_t i = 0; i < table_->n_bytes / 4; ++i) {
            __atomic_store_n(to + i, words[i], __ATOMIC_RELAXED);
        }
        (void)pal_table_ring_publish(&link_->tables);
        if (last_id_ % 4 == 0)
            std::this_thread::yield();  // for some, time for their check before they are spoilt
    }

    pal_link* link_;
    std::mt19937 random_;
    std::unique_ptr<pal_table> table_;
    std::uint64_t last_id_ = 0;
    std::atomic<std::uint64_t> n_acts_{0};
};

/// Brings `table` into use, 3 mm deep in its skin. Returns where it lies.
pal_table* press(Bench& bench, pal_link& link, const pal_table& table) {
    REQUIRE(publish(link, table));
    bench.move(1e-3, -0.5e-3, -3e-3);
    for (int i = 0; i < 4; ++i) {
        (void)bench.tick();
        (void)pal_intake_check(&bench.session.intake);
    }
    REQUIRE(bench.session.intake.now_id == table.id);
    return const_cast<pal_table*>(bench.session.intake.tables.now);
}

}  // namespace

TEST_CASE("whatever is written to the segment while it runs, a tick stays within its limits") {
    const auto link = new_link();
    Bench bench(*link);
    std::atomic<bool> stop{false};
    Vandal vandal(*link, 20261128);
    std::thread writer([&] {
        while (!stop) vandal.act();
    });
    std::thread checker([&] {
        while (!stop) {
            if (!pal_intake_check(&bench.session.intake)) std::this_thread::yield();
        }
    });
    const int n_ticks = size(300000, 10000000);
    int n_unsafe = 0, n_pressed = 0, n_clamped = 0;
    std::uint64_t n_tables = 0, last = 0;
    const auto about_nothing = [&] {
        return n_tables < 50 || vandal.n_acts() < 20000;
    };  // threads may starve
    for (int n = 0; n < n_ticks || (about_nothing() && n < 50 * n_ticks); ++n) {
        if (n % 200 == 0) {  // whatever latched
            bench.session.loop = {};
            pal_link_store(&link->host.estop, 0);
            pal_link_store(&link->host.enable, 1);
        }
        bench.move(4e-3 * std::sin(0.01 * n), 3e-3 * std::cos(0.013 * n), -2e-3 + 4e-3 * std::sin(0.007 * n));
        (void)bench.tick();
        n_unsafe += bench.is_safe() ? 0 : 1;
        n_pressed += bench.force_n() > 0.01 ? 1 : 0;
        n_clamped += bench.force_n() > 7.9 ? 1 : 0;
        if (bench.session.intake.now_id != last) {
            last = bench.session.intake.now_id;
            ++n_tables;
        }
        if (n % 16 == 0) std::this_thread::yield();
    }
    stop = true;
    writer.join();
    checker.join();
    CHECK(n_unsafe == 0);
    CHECK(n_pressed > 0);
    CHECK_FALSE(about_nothing());
    WARN(n_ticks << " ticks, " << vandal.n_acts() << " words spoilt, " << n_tables << " tables in use, "
                 << bench.session.intake.tables.n_bad << " refused, " << n_pressed << " ticks with force, "
                 << n_clamped << " of them at the limit");
}

TEST_CASE("up to three bits flipped before the check: the table is refused, or the bits were not in use") {
    const auto link = new_link();
    Bench bench(*link);
    bench.move(0.0, 0.0, -2e-3);
    std::mt19937 random(1128);
    const auto round = [&] {
        for (int i = 0; i < 3; ++i) {
            (void)bench.tick();
            (void)pal_intake_check(&bench.session.intake);
        }
    };
    const auto table = hostile::uneven(1);
    REQUIRE(publish(*link, *table));
    round();
    const int n_flips = size(20000, 1000000);
    int n_refused = 0, n_outside = 0, n_missed = 0;
    std::uint64_t id = 1;
    for (int n = 0; n < n_flips; ++n) {
        bench.session.loop.fade_tick = bench.session.config.fade_ticks;  // no fade: each is taken at once
        bench.session.loop.before_id = 0;
        table->id = ++id;
        pal_table_seal(table.get());
        pal_table* back = pal_table_ring_back(&link->tables);
        REQUIRE(back != nullptr);
        std::memcpy(back, table.get(), table->n_bytes);
        bool outside = true;
        for (std::size_t k = 1 + random() % 3; k > 0; --k) {
            const std::size_t bit = random() % (n % 4 == 0 ? 8 * sizeof(pal_table) : 8U * table->n_bytes);
            reinterpret_cast<std::uint8_t*>(back)[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
            outside = std::memcmp(back, table.get(), table->n_bytes) == 0;
        }
        REQUIRE(pal_table_ring_publish(&link->tables));
        const std::uint32_t n_bad = bench.session.intake.tables.n_bad;
        round();
        const bool refused = bench.session.intake.tables.n_bad != n_bad;
        n_refused += refused ? 1 : 0;
        n_outside += outside ? 1 : 0;
        n_missed += refused == outside ? 1 : 0;
        REQUIRE(bench.is_safe());
    }
    CHECK(n_missed == 0);
    WARN(n_flips << " spoilt tables: " << n_refused << " refused, " << n_outside
                 << " spoilt only where nothing is read");
}

TEST_CASE("a bit flipped in a table in use costs at most the clamp, a fault or a wrong force within it") {
    const auto link = new_link();
    Bench bench(*link);
    const auto table = hostile::uneven(1);
    pal_table* in_use = press(bench, *link, *table);
    const auto words = bench.words();
    REQUIRE(bench.force_n() > 1.0);
    const pal_loop good = bench.session.loop;
    std::mt19937 random(17);
    const int n_flips = size(40000, 2000000);
    int n_same = 0, n_other = 0, n_fault = 0;
    for (int n = 0; n < n_flips; ++n) {
        bench.session.loop = good;
        // Half of them in the header and the taps under the tool, where a bit is most likely to count.
        const std::size_t n_bits =
            8U * (n % 2 == 0 ? offsetof(pal_table, coef) : std::size_t{table->n_bytes});
        const std::size_t bit = random() % n_bits;
        auto* byte = reinterpret_cast<std::uint8_t*>(in_use) + bit / 8;
        *byte ^= static_cast<std::uint8_t>(1U << bit % 8);
        bool fault = false, other = false;
        for (int i = 0; i < 2; ++i) {
            (void)bench.tick();
            REQUIRE(bench.is_safe());
            fault = fault || !bench.session.loop.touch.inside || bench.session.loop.table_id == 0;
            other = other || bench.words() != words;
        }
        *byte ^= static_cast<std::uint8_t>(1U << bit % 8);
        n_fault += fault ? 1 : 0;
        n_other += !fault && other ? 1 : 0;
        n_same += !fault && !other ? 1 : 0;
    }
    CHECK(n_fault > 0);
    CHECK(n_other > 0);
    CHECK(n_same > 0);
    WARN(n_flips << " bits flipped in use: " << n_same << " without effect, " << n_other
                 << " another force within the limit, " << n_fault << " zero force with a fault");
}

TEST_CASE("odd numbers in a field or all over a plane of a table in use stay within the limits") {
    const auto link = new_link();
    Bench bench(*link);
    const auto table = hostile::uneven(1);
    pal_table* in_use = press(bench, *link, *table);
    const pal_loop good = bench.session.loop;
    constexpr std::size_t N_HEADER = offsetof(pal_table, coef) / 4, N_PLANE = 19 * 19;
    const auto write = [&](std::size_t word, std::uint32_t value) {
        std::memcpy(reinterpret_cast<std::uint8_t*>(in_use) + 4 * word, &value, sizeof value);
    };
    int n_faults = 0, n_cases = 0;
    for (const double z_m : {-3e-3, 2e-3}) {
        bench.move(1e-3, -0.5e-3, z_m);
        for (std::size_t field = 0; field < N_HEADER + 3; ++field) {
            for (const std::uint32_t value : ODD_FLOATS) {
                bench.session.loop = good;
                if (field < N_HEADER) write(field, value);
                for (std::size_t i = 0; field >= N_HEADER && i < N_PLANE; ++i) {
                    write(N_HEADER + (field - N_HEADER) * N_PLANE + i, value);
                }
                for (int i = 0; i < 2; ++i) {
                    (void)bench.tick();
                    INFO("word " << field << ", value " << std::hex << value);
                    REQUIRE(bench.is_safe());
                }
                n_faults += bench.session.loop.touch.inside ? 0 : 1;
                ++n_cases;
                std::memcpy(in_use, table.get(), table->n_bytes);
            }
        }
    }
    CHECK(n_faults > 0);
    CHECK(n_faults < n_cases);
}

TEST_CASE(
    "a damaged word of the table ring: nothing is taken or published, the table grows old, the force goes") {
    const auto link = new_link();
    Bench bench(*link);
    REQUIRE(publish(*link, *hostile::uneven(1)));
    bench.move(0.0, 0.0, -2e-3);
    for (int i = 0; i < 10; ++i) {
        (void)bench.tick();
        (void)pal_intake_check(&bench.session.intake);
    }
    REQUIRE(bench.force_n() > 0.5);
    const auto bit = GENERATE(range(0U, 8U));
    link->tables.state ^= 1U << bit;
    const std::uint32_t damaged = link->tables.state;
    const auto next = hostile::uneven(2);
    for (int i = 0; i < 560; ++i) {
        CHECK_FALSE(publish(*link, *next));
        (void)bench.tick();
        (void)pal_intake_check(&bench.session.intake);
        REQUIRE(bench.is_safe());
        REQUIRE(bench.session.intake.now_id == 1);
    }
    CHECK(link->tables.state == damaged);
    CHECK(bench.force_n() == 0.0);
}
