// What accuracy costs: error of the centre compliance next to its time, one grid and extrapolated pairs.
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "host/plate/batch.hpp"
#include "host/plate/contact_set.hpp"
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

/// A table's 17 x 17 compliances from new D.
void table(benchmark::State& state, Index n, plate::Kernel kernel) {
    const Problem problem = hill_on_foundation(n);
    plate::ContactTable contacts(problem, 17, kernel);
    measure(
        state, Clock::cpu, 1, [](std::size_t) {},
        [&](std::size_t) {
            contacts.set_rigidity(problem.rigidity_n_m);
            benchmark::DoNotOptimize(contacts.compliances_m_per_n());
        });
}

/// From new D to the centre's compliance: all plates of a batch, and as many one after the other.
void batch(benchmark::State& state, Index n, plate::Kernel kernel) {
    const Problem problem = hill_on_foundation(n);
    plate::Batch together(problem, kernel);
    plate::Plate alone(problem, kernel);
    std::vector<double> compliances(together.lanes()), batch_s, alone_s;
    for (auto _ : state) {
        batch_s.push_back(timed_s(Clock::cpu, [&] {
            for (std::size_t lane = 0; lane < together.lanes(); ++lane)
                together.set_rigidity(lane, problem.rigidity_n_m);
            together.centre_compliances_m_per_n(compliances);
        }));
        alone_s.push_back(timed_s(Clock::cpu, [&] {
            for (double& compliance : compliances) {
                alone.set_rigidity(problem.rigidity_n_m);
                compliance = alone.centre_compliance_m_per_n();
            }
        }));
        state.SetIterationTime(batch_s.back());
    }
    const auto lanes = static_cast<double>(together.lanes());
    state.counters["batch_per_plate_s"] = quantile(batch_s, 0.5) / lanes;
    state.counters["alone_per_plate_s"] = quantile(alone_s, 0.5) / lanes;
    state.counters["ratio"] = quantile(alone_s, 0.5) / quantile(batch_s, 0.5);
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
    for (const auto& [name, kernel] :
         {std::pair{"portable", plate::Kernel::portable}, {"best", plate::Kernel::best}}) {
        for (const Index n : {33, 65}) {
            add("plate/17 x 17 contacts from " + std::to_string((n + 1) / 2) + " + " +
                    std::to_string((n - 1) / 4 * 3 + 1) + " + " + std::to_string(n) + ", " + name,
                n > 33 ? 20 : 100, [n, k = kernel](benchmark::State& state) { table(state, n, k); });
        }
        add(std::string("plate/a batch at 33, ") + name, 50,
            [k = kernel](benchmark::State& state) { batch(state, 33, k); });
    }
}

}  // namespace palpate::bench
