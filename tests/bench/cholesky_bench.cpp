// The plate's multifrontal Cholesky and Eigen's on one matrix, call by call in turn, so that both meet the
// same machine. Both have their analysis of the pattern behind them, as in use.
#include <Eigen/SparseCholesky>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/plate/direct/factor.hpp"
#include "host/plate/plate.hpp"
#include "tests/bench/measure.hpp"
#include "tests/host/plate/fields.hpp"

namespace palpate::bench {
namespace {

using Eigen::Index;

constexpr double AGREE = 1e-9;  // a wrong factor would be no competitor

struct Matrix {
    std::shared_ptr<const plate::Analysis> analysis;
    std::vector<double> values;          ///< for the plate's factor
    Eigen::SparseMatrix<double> sparse;  ///< the same for Eigen
    Index centre;                        ///< row of the centre node in `sparse`

    explicit Matrix(Index n) : analysis(plate::analysis_for(n, n)) {
        const auto problem =
            plate::fields::on_foundation(plate::fields::unit_square(n, plate::fields::gauss), 8.0);
        const Eigen::MatrixXd dense = plate::Plate(problem).dense_stiffness_n_per_m();
        sparse = dense.sparseView();
        const Index inner = n - 2;
        centre = inner / 2 * inner + inner / 2;
        std::vector<Index> place(analysis->n_unknowns);
        for (Index ix = 0; ix < inner; ++ix) {
            for (Index iz = 0; iz < inner; ++iz)
                place[analysis->number[analysis->node(ix + 1, iz + 1)]] = ix * inner + iz;
        }
        for (std::size_t c = 0; c < analysis->n_unknowns; ++c) {
            for (std::size_t e = analysis->column[c]; e < analysis->column[c + 1]; ++e)
                values.push_back(dense(place[analysis->row[e]], place[c]));
        }
    }
};

/// Times of both sides, sample by sample.
struct Race {
    std::vector<double> own_s, eigen_s;

    /// The first is the second next time.
    template <typename Own, typename Theirs>
    void run(Own&& own, Theirs&& theirs) {
        const bool own_first = own_s.size() % 2 == 0;
        if (own_first) own_s.push_back(timed_s(Clock::cpu, own));
        eigen_s.push_back(timed_s(Clock::cpu, theirs));
        if (!own_first) own_s.push_back(timed_s(Clock::cpu, own));
    }
    void report(benchmark::State& state, const std::string& what) const {
        const double own = quantile(own_s, 0.5), theirs = quantile(eigen_s, 0.5);
        state.counters[what + "_own_s"] = own;
        state.counters[what + "_eigen_s"] = theirs;
        state.counters[what + "_ratio"] = theirs / own;
    }
};

void race(benchmark::State& state, Index n) {
    const Matrix matrix(n);
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> eigen;
    eigen.analyzePattern(matrix.sparse);
    std::optional<plate::Factor> own;
    std::vector<double> x(matrix.values.size());
    Eigen::VectorXd load = Eigen::VectorXd::Unit(matrix.sparse.rows(), matrix.centre), w;
    Race factor, solve;
    for (auto _ : state) {
        factor.run([&] { own.emplace(matrix.analysis, matrix.values); },
                   [&] { eigen.factorize(matrix.sparse); });
        x.assign(matrix.analysis->n_unknowns, 0.0);
        x.back() = 1.0;
        solve.run([&] { own->solve(x); }, [&] { w = eigen.solve(load); });
        state.SetIterationTime(factor.own_s.back());
    }
    const double disagree = std::fabs(x.back() / w(matrix.centre) - 1.0);
    if (!(disagree < AGREE)) throw std::runtime_error("cholesky: the two sides do not agree");
    factor.report(state, "factor");
    solve.report(state, "solve");
}

}  // namespace

void register_cholesky() {
    for (const Index n : {17, 33, 65}) {
        add("cholesky/" + std::to_string(n) + " nodes, " + std::to_string((n - 2) * (n - 2)) + " unknowns",
            n > 33 ? 40 : 200, [n](benchmark::State& state) { race(state, n); });
    }
}

}  // namespace palpate::bench
