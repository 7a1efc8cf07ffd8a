// What accuracy costs: error of the centre compliance next to its time, one grid and extrapolated pairs.
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "host/plate/plate.hpp"
#include "tests/bench/measure.hpp"
#include "tests/host/plate/fields.hpp"
#include "tests/host/plate/square_series.hpp"

namespace palpate::bench {
namespace {

using Eigen::Index;
using plate::Problem;

constexpr double SIDE_OVER_L = 8.0;  // about that of the bunny scene
constexpr Index REFERENCE_NODES = 257;

struct Case {
    std::string name;
    std::function<Problem(Index)> problem;
    double truth;
};

double extrapolated(const Problem& problem) {
    return plate::extrapolated_centre_compliance(problem).m_per_n;
}

double plain(const Problem& problem) {
    return plate::Plate(problem).centre_compliance_m_per_n();
}

/// Rigidity 1 at the edge, 5 in the middle, smooth.
Problem hill(Index n) {
    return plate::fields::unit_square(n, plate::fields::gauss);
}

Problem hill_on_foundation(Index n) {
    return plate::fields::on_foundation(hill(n), SIDE_OVER_L);
}

/// Uniform squares against Timoshenko's series; hills against the pair 129 + 257.
const std::vector<Case>& cases() {
    static const std::vector<Case> all = {
        {"uniform", [](Index n) { return plate::fields::unit_square(n, plate::fields::one); },
         plate::truth::uniform_square_compliance(0.0)},
        {"uniform_on_foundation",
         [](Index n) {
             return plate::fields::on_foundation(plate::fields::unit_square(n, plate::fields::one),
                                                 SIDE_OVER_L);
         },
         plate::truth::uniform_square_compliance(SIDE_OVER_L)},
        {"hill", hill, extrapolated(hill(REFERENCE_NODES))},
        {"hill_on_foundation", hill_on_foundation, extrapolated(hill_on_foundation(REFERENCE_NODES))}};
    return all;
}

void error_and_time(benchmark::State& state, Index n, double (*compliance)(const Problem&)) {
    for (const Case& c : cases()) {
        const double error = compliance(c.problem(n)) / c.truth - 1.0;
        state.counters["error_" + c.name] = std::fabs(error);
    }
    const Problem problem = hill_on_foundation(n);
    measure(
        state, Clock::cpu, 1, [](std::size_t) {},
        [&](std::size_t) { benchmark::DoNotOptimize(compliance(problem)); });
}

}  // namespace

void register_plate() {
    const auto add_size = [](const std::string& name, Index n, double (*compliance)(const Problem&)) {
        constexpr int NODES_IN_A_REPETITION = 130000;
        add("plate/" + name, NODES_IN_A_REPETITION / static_cast<int>(n * n),
            [=](benchmark::State& state) { error_and_time(state, n, compliance); });
    };
    for (const Index n : {9, 17, 33, 65}) add_size("plain " + std::to_string(n), n, plain);
    for (const Index n : {9, 17, 33, 65}) {
        add_size("pair " + std::to_string((n + 1) / 2) + " + " + std::to_string(n), n, extrapolated);
    }
}

}  // namespace palpate::bench
