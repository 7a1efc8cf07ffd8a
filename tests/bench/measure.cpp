#include "tests/bench/measure.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpate::bench {
namespace {

constexpr std::size_t N_FOR_P99 = 1000;

double measured_cost_s(Clock clock) {
    std::vector<double> costs_s;
    for (int i = 0; i < 20001; ++i) {
        const double begin_s = now_s(clock);
        costs_s.push_back(now_s(clock) - begin_s);
    }
    return quantile(std::move(costs_s), 0.5);
}

}  // namespace

double quantile(std::vector<double> values, double share) {
    const double rank = std::ceil(share * static_cast<double>(values.size())) - 1.0;
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(std::max(0.0, rank));
    std::nth_element(values.begin(), place, values.end());
    return *place;
}

double now_s(Clock clock) {
    timespec now{};
    clock_gettime(clock == Clock::wall ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double clock_cost_s(Clock clock) {
    static const double wall_s = measured_cost_s(Clock::wall), cpu_s = measured_cost_s(Clock::cpu);
    return clock == Clock::wall ? wall_s : cpu_s;
}

void report(benchmark::State& state, const std::vector<double>& times_s) {
    state.counters["median_s"] = quantile(times_s, 0.5);
    if (times_s.size() >= N_FOR_P99) state.counters["p99_s"] = quantile(times_s, 0.99);
}

}  // namespace palpate::bench
