/// How a thing is timed: each sample by itself, so that the median and the slow end are seen, not a mean.
#pragma once
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace palpate::bench {

/// What each benchmark file offers, in the order of the printed tables.
void register_tick();
void register_session();
void register_link();
void register_stiffness();
void register_plate();
void register_cholesky();
void register_jacobi();
void register_bounds();

/// Value below which a share of `values` lies, nearest rank. `values` not empty.
[[nodiscard]] double quantile(std::vector<double> values, double share);

/// `wall`: what a deadline sees, and cheap to read. `cpu`: of this thread alone; on a busy machine the only
/// one that says something about calls longer than a time slice.
enum class Clock { wall, cpu };

[[nodiscard]] double now_s(Clock clock);
/// What reading the clock twice costs, s: the median of many, measured once. Taken off every sample.
[[nodiscard]] double clock_cost_s(Clock clock);

/// Time of `call`, s, without the clock's own.
template <typename Call>
[[nodiscard]] double timed_s(Clock clock, Call&& call) {
    const double begin_s = now_s(clock);
    call();
    const double end_s = now_s(clock);
    return std::max(0.0, end_s - begin_s - clock_cost_s(clock));
}

/// Counters median_s and, from 1000 samples on, p99_s.
void report(benchmark::State& state, const std::vector<double>& times_s);

/// One sample per iteration: `n_calls` times call(k), k counting on, divided by n_calls. `before(k)` runs
/// ahead of each sample, untimed.
template <typename Before, typename Call>
std::vector<double> measure(benchmark::State& state, Clock clock, std::size_t n_calls, Before&& before,
                            Call&& call) {
    std::vector<double> times_s;
    std::size_t k = 0;
    for (auto _ : state) {
        before(k);
        const double time_s = timed_s(clock, [&] {
            for (std::size_t i = 0; i < n_calls; ++i) call(k++);
        });
        times_s.push_back(time_s / static_cast<double>(n_calls));
        state.SetIterationTime(times_s.back());
    }
    report(state, times_s);
    return times_s;
}

/// Registers `run` under "group/name": `n_samples` samples, repeated often enough to show the spread.
template <typename Run>
void add(const std::string& name, int n_samples, Run&& run) {
    constexpr int N_REPETITIONS = 7;
    benchmark::RegisterBenchmark(name.c_str(), std::forward<Run>(run))
        ->Iterations(n_samples)
        ->Repetitions(N_REPETITIONS)
        ->UseManualTime();
}

}  // namespace palpate::bench
