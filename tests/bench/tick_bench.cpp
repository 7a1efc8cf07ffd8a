// One tick of the loop and its two large parts, along a stroke: a circle of 3 mm at 18 mm/s over an uneven
// skin.
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/bench/measure.hpp"
#include "tests/firmware/loop_bench.hpp"

namespace palpate::bench {
namespace {

constexpr std::size_t N_STROKE = 1024;
constexpr int N_TICKS = 50000;
constexpr std::size_t REFRESH_TICKS = 40;  // a host's sign of life; a table older than 100 ticks is stale
constexpr std::size_t BATCH = 64;          // calls per sample of what is too short for the clock
constexpr std::uint32_t N_NODES = 17;      // what a scene with the default tolerance gets

std::unique_ptr<pal_table> uneven_table(double stiffness_n_per_m) {
    tables::Fields fields;
    fields.s_m = [](double u, double v) { return 2e-4 * std::sin(300.0 * u) * std::cos(250.0 * v); };
    fields.k_n_per_m = [=](double u, double v) {
        return stiffness_n_per_m * (1.0 + 0.3 * std::sin(200.0 * u + 150.0 * v));
    };
    return tables::make(fields, N_NODES, 20.0);
}

struct Place {
    float at_m[3];  ///< workspace frame
    std::array<std::int16_t, 3> encoder_counts;
};

/// `depth_m` below the sphere of the table; negative: in the air.
std::vector<Place> stroke(double depth_m) {
    std::vector<Place> places;
    LoopBench bench;
    for (std::size_t k = 0; k < N_STROKE; ++k) {
        const double turn = 2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(N_STROKE);
        const double x = 3e-3 * std::cos(turn), y = 3e-3 * std::sin(turn);
        const double z = -depth_m - 10.0 * (x * x + y * y);  // kappa/2
        bench.move(x, y, z);
        const auto& counts = bench.sense.encoder_counts;
        places.push_back({{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)},
                          {counts[0], counts[1], counts[2]}});
    }
    return places;
}

enum class Kind { no_table, in_air, contact, fade };

/// What the ticks meant to be, they were: otherwise the figure would belong to something else.
void require(Kind kind, const LoopBench& bench) {
    const bool contact = bench.record.depth_m > 0.0F && bench.force_n() > 0.1;
    const bool fading = bench.record.before_id != 0 || pal_loop_fading(&bench.config, &bench.loop);
    bool ok = bench.faults == (kind == Kind::no_table ? std::uint32_t{PAL_FAULT_TABLE_MISSING} : 0U);
    ok = ok && contact == (kind == Kind::contact || kind == Kind::fade);
    if (!ok || (fading && kind != Kind::fade)) {
        throw std::runtime_error("tick: not the tick that was meant, faults " + std::to_string(bench.faults));
    }
}

/// Gives the tick before it what a host would: a sign of life, or a new table as soon as the last fade is
/// over.
class Host {
public:
    Host(Kind kind, LoopBench& bench) : kind_(kind), bench_(&bench) {
        if (kind != Kind::no_table) bench.given.now = first_.get();
    }
    void before_tick(std::size_t k) {
        if (kind_ == Kind::fade && k % bench_->config.fade_ticks == 0) {
            std::swap(first_, second_);
            first_->id = second_->id + 1;
            bench_->given.now = first_.get();
            bench_->given.before = second_.get();
        } else if (kind_ != Kind::fade && k % REFRESH_TICKS == 0) {
            first_->id += 1;
        }
    }

private:
    Kind kind_;
    LoopBench* bench_;
    std::unique_ptr<pal_table> first_ = uneven_table(600.0), second_ = uneven_table(700.0);
};

/// Takes the caches from the tick, as a millisecond of other work would. 4 MB: beyond the second level.
void other_work() {
    static std::vector<std::uint64_t> memory(std::size_t{1} << 19U);
    for (std::size_t i = 0; i < memory.size(); i += 8) memory[i] += i;
    benchmark::DoNotOptimize(memory.data());
}

void tick(benchmark::State& state, Kind kind, bool cold) {
    static const std::vector<Place> in_contact = stroke(2e-3), in_air = stroke(-2e-3);
    const std::vector<Place>& places = kind == Kind::in_air ? in_air : in_contact;
    LoopBench bench;
    Host host(kind, bench);
    const auto sense = [&](std::size_t k) {
        host.before_tick(k);
        const Place& place = places[k % N_STROKE];
        std::copy(place.encoder_counts.begin(), place.encoder_counts.end(), bench.sense.encoder_counts);
    };
    std::size_t n_warm = 0;
    for (; n_warm < 16 * N_STROKE; ++n_warm) {  // homed, no ramp, first fade over
        sense(n_warm);
        bench.step();
    }
    measure(
        state, Clock::wall, 1,
        [&](std::size_t k) {
            if (k > 0) require(kind, bench);
            sense(k);
            if (cold) other_work();
        },
        [&](std::size_t) {
            bench.step();
            benchmark::DoNotOptimize(bench.drive);
        });
    require(kind, bench);
}

void lookup(benchmark::State& state) {
    const std::vector<Place> places = stroke(2e-3);
    const auto table = uneven_table(600.0);
    pal_touch touch{};
    measure(
        state, Clock::wall, BATCH, [](std::size_t) {},
        [&](std::size_t k) {
            pal_table_touch(table.get(), places[k % N_STROKE].at_m, &touch);
            benchmark::DoNotOptimize(touch);
        });
}

void forward(benchmark::State& state) {
    std::vector<std::array<float, 3>> thetas;
    for (const Place& place : stroke(2e-3)) {
        std::array<float, 3> theta{};
        for (std::size_t i = 0; i < 3; ++i)
            theta[i] = pal_delta_theta_rad(&PAL_DELTA_NF1, place.encoder_counts[i]);
        thetas.push_back(theta);
    }
    const pal_loop_config config = pal_loop_config_default();
    std::array<float, 3> at_m{config.centre_m[0], config.centre_m[1], config.centre_m[2]};
    bool ok = pal_delta_forward(&PAL_DELTA_NF1, thetas[0].data(), at_m.data(), 12, at_m.data());
    measure(
        state, Clock::wall, BATCH, [](std::size_t) {},
        [&](std::size_t k) {  // from the last position, like the loop
            ok =
                pal_delta_forward(&PAL_DELTA_NF1, thetas[k % N_STROKE].data(), at_m.data(), 2, at_m.data()) &&
                ok;
            benchmark::DoNotOptimize(at_m);
        });
    if (!ok) throw std::runtime_error("forward kinematics: no answer on the stroke");
}

}  // namespace

void register_tick() {
    const auto add_tick = [](const std::string& name, int n, Kind kind, bool cold) {
        add("tick/" + name, n, [=](benchmark::State& state) { tick(state, kind, cold); });
    };
    add_tick("no table", N_TICKS, Kind::no_table, false);
    add_tick("table, in the air", N_TICKS, Kind::in_air, false);
    add_tick("table in contact", N_TICKS, Kind::contact, false);
    add_tick("fade of two tables in contact", N_TICKS, Kind::fade, false);
    add_tick("fade, caches taken by other work", N_TICKS / 25, Kind::fade, true);
    add("part/table look-up", N_TICKS / 10, lookup);
    add("part/forward kinematics", N_TICKS / 10, forward);
}

}  // namespace palpate::bench
