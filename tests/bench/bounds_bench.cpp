// What a certified bracket costs, rung by rung, next to the factorisation that it saves.
#include <string>
#include <vector>

#include "host/plate/bounds/bounds.hpp"
#include "host/plate/plate.hpp"
#include "tests/bench/measure.hpp"
#include "tests/host/plate/fields.hpp"

namespace palpate::bench {
namespace {

using Eigen::Index;
using plate::Bounds;
using plate::Problem;
using plate::Rung;

constexpr Index N = 33;
constexpr double SIDE_OVER_L = 8.0;  // about that of the bunny scene

Problem hill(double side_over_l) {
    const Problem problem = plate::fields::unit_square(N, plate::fields::gauss);
    return side_over_l > 0.0 ? plate::fields::on_foundation(problem, side_over_l) : problem;
}

std::span<const double> span_of(const Eigen::ArrayXXd& field) {
    return {field.data(), static_cast<std::size_t>(field.size())};
}

/// All rungs up to `last`, whatever they find, as a climb to that rung costs.
void climb(benchmark::State& state, double side_over_l, Rung last) {
    constexpr int N_SAMPLES_EACH = 16;
    const Problem problem = hill(side_over_l);
    std::vector<double> force(static_cast<std::size_t>(N * N), 0.0);
    force[force.size() / 2] = 1.0;
    const Bounds bounds(problem, force, {.first = 6.0, .last = 10.0, .ratio = 1.2});
    Bounds::Scratch scratch(bounds);
    plate::Bracket bracket{};
    measure(
        state, Clock::cpu, N_SAMPLES_EACH, [](std::size_t) {},
        [&](std::size_t) {
            bracket = bounds.bracket(span_of(problem.rigidity_n_m), span_of(problem.foundation_n_per_m3),
                                     {.relative_error = 0.0, .last = last}, scratch);
            benchmark::DoNotOptimize(bracket);
        });
    state.counters["error"] = bracket.relative_error();
}

void factorise(benchmark::State& state, double side_over_l) {
    const Problem problem = hill(side_over_l);
    plate::Plate plate(problem);
    measure(
        state, Clock::cpu, 1, [](std::size_t) {},
        [&](std::size_t) {
            plate.set_rigidity(problem.rigidity_n_m);
            benchmark::DoNotOptimize(plate.centre_compliance_m_per_n());
        });
}

}  // namespace

void register_bounds() {
    constexpr int N_SAMPLES = 200;
    for (const double side_over_l : {0.0, SIDE_OVER_L}) {
        const std::string on = side_over_l > 0.0 ? "foundation, " : "bare, ";
        for (const Rung rung : {Rung::extremes, Rung::uniform, Rung::modes, Rung::krylov2, Rung::krylov3}) {
            add("bounds/" + on + plate::name_of(rung), N_SAMPLES,
                [=](benchmark::State& state) { climb(state, side_over_l, rung); });
        }
        add("bounds/" + on + "new factor instead", N_SAMPLES,
            [=](benchmark::State& state) { factorise(state, side_over_l); });
    }
}

}  // namespace palpate::bench
