// The plate's multifrontal Cholesky against CHOLMOD and Eigen: from a new D to the centre's compliance, call
// by call in turn, so that all meet the same machine. All have their analysis of the pattern behind them, and
// each timed call follows one of its own, as in use. The plate's own time has everything in it: stencil,
// factor and guards. Theirs have the stencil, the factor and one solution in them; the last ratio has their
// factor alone.
#include <Eigen/SparseCholesky>
#ifdef PALPATE_CHOLMOD
#include <cholmod.h>
#endif
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/plate/direct/analysis.hpp"
#include "host/plate/plate.hpp"
#include "host/plate/stencil.hpp"
#include "tests/bench/measure.hpp"
#include "tests/host/plate/fields.hpp"

namespace palpate::bench {
namespace {

using Eigen::ArrayXXd;
using Eigen::Index;
using plate::Kernel;
using plate::Problem;

constexpr double AGREE = 1e-8;  // a wrong factor would be no competitor

/// K's lower triangle with the nodes in their own order, refilled from a stencil.
struct Matrix {
    plate::Stencil stencil;
    std::vector<int> order;  ///< nested dissection: which unknown comes k-th
    int centre = 0;
    Eigen::SparseMatrix<double> lower;
    std::vector<std::size_t> source;  ///< in the stencil's couplings

    explicit Matrix(const Problem& problem) : stencil(problem) {
        const plate::Layout& grid = stencil.layout();
        const plate::Moving& moving = stencil.moving();
        const auto row = [&](Index ix, Index iz) {
            return static_cast<int>((iz - moving.z0) * (moving.x1 - moving.x0) + ix - moving.x0);
        };
        std::vector<int> row_at(grid.size(), -1);
        std::vector<Eigen::Triplet<double>> entries;
        for (Index iz = moving.z0; iz < moving.z1; ++iz) {
            for (Index ix = moving.x0; ix < moving.x1; ++ix) {
                row_at[grid.at(ix, iz)] = row(ix, iz);
                for (std::size_t c = 0; c < plate::N_COUPLINGS; ++c) {
                    const Index x = ix + plate::OFFSETS[c].dx, z = iz + plate::OFFSETS[c].dz;
                    // Kept as a number for now: where it comes from, exact up to 2^53.
                    if (moving.holds(x, z))
                        entries.emplace_back(row(x, z), row(ix, iz),
                                             static_cast<double>(c * grid.size() + grid.at(ix, iz)));
                }
            }
        }
        lower.resize(moving.count(), moving.count());
        lower.setFromTriplets(entries.begin(), entries.end());
        for (Index e = 0; e < lower.nonZeros(); ++e)
            source.push_back(static_cast<std::size_t>(lower.valuePtr()[e]));
        for (const std::uint32_t at : plate::analysis_for(grid, moving)->node) order.push_back(row_at[at]);
        centre = order.back();
        refill(problem.rigidity_n_m);
    }
    void refill(const ArrayXXd& rigidity_n_m) {
        stencil.set_rigidity(rigidity_n_m);
        for (std::size_t e = 0; e < source.size(); ++e) lower.valuePtr()[e] = stencil.couplings()[source[e]];
    }
};

/// One way from a new D to the centre's compliance. Answers it; `factor_s`, if asked, is the factor's share.
struct Side {
    std::string name;
    std::function<double(const ArrayXXd&, double* factor_s)> run;
    std::vector<double> times_s{}, factor_times_s{};
};

Side own(const std::string& name, const Problem& problem, Kernel kernel) {
    const auto plate = std::make_shared<plate::Plate>(problem, kernel);
    return {name, [plate](const ArrayXXd& d, double*) {
                plate->set_rigidity(d);
                return plate->centre_compliance_m_per_n();
            }};
}

Side eigen(const Problem& problem) {
    struct State {
        Matrix matrix;
        Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
        Eigen::VectorXd load, w;

        explicit State(const Problem& p)
            : matrix(p), load(Eigen::VectorXd::Unit(matrix.lower.rows(), matrix.centre)) {
            solver.analyzePattern(matrix.lower);
        }
    };
    const auto state = std::make_shared<State>(problem);
    return {"eigen", [state](const ArrayXXd& d, double* factor_s) {
                state->matrix.refill(d);
                *factor_s = timed_s(Clock::cpu, [&] { state->solver.factorize(state->matrix.lower); });
                state->w = state->solver.solve(state->load);
                return state->w(state->matrix.centre) * state->matrix.stencil.compliance_m_per_n();
            }};
}

#ifdef PALPATE_CHOLMOD
enum class Order { amd, metis, dissection };

class Cholmod {
public:
    Cholmod(const Problem& problem, int supernodal, Order order) : matrix_(problem) {
        cholmod_start(&common_);
        common_.supernodal = supernodal;
        common_.final_ll = 1;
        common_.nmethods = 1;
        common_.method[0].ordering = order == Order::amd     ? CHOLMOD_AMD
                                     : order == Order::metis ? CHOLMOD_METIS
                                                             : CHOLMOD_GIVEN;
        const auto n = static_cast<std::size_t>(matrix_.lower.rows());
        view_.nrow = view_.ncol = n;
        view_.nzmax = matrix_.source.size();
        view_.p = matrix_.lower.outerIndexPtr();
        view_.i = matrix_.lower.innerIndexPtr();
        view_.x = matrix_.lower.valuePtr();
        view_.stype = -1;
        view_.itype = CHOLMOD_INT;
        view_.xtype = CHOLMOD_REAL;
        view_.dtype = CHOLMOD_DOUBLE;
        view_.sorted = view_.packed = 1;
        int* const given = order == Order::dissection ? matrix_.order.data() : nullptr;
        factor_ = cholmod_analyze_p(&view_, given, nullptr, 0, &common_);
        if (factor_ == nullptr) throw std::runtime_error("cholmod: no analysis");
        load_ = cholmod_zeros(n, 1, CHOLMOD_REAL, &common_);
        static_cast<double*>(load_->x)[matrix_.centre] = 1.0;
    }
    Cholmod(const Cholmod&) = delete;
    Cholmod& operator=(const Cholmod&) = delete;
    ~Cholmod() {
        cholmod_free_dense(&load_, &common_);
        cholmod_free_dense(&w_, &common_);
        cholmod_free_dense(&y_, &common_);
        cholmod_free_dense(&e_, &common_);
        cholmod_free_factor(&factor_, &common_);
        cholmod_finish(&common_);
    }
    double centre_compliance(const ArrayXXd& d, double* factor_s) {
        matrix_.refill(d);
        *factor_s = timed_s(Clock::cpu, [&] { cholmod_factorize(&view_, factor_, &common_); });
        cholmod_solve2(CHOLMOD_A, factor_, load_, nullptr, &w_, nullptr, &y_, &e_, &common_);
        return static_cast<double*>(w_->x)[matrix_.centre] * matrix_.stencil.compliance_m_per_n();
    }

private:
    Matrix matrix_;
    cholmod_common common_{};
    cholmod_sparse view_{};
    cholmod_factor* factor_ = nullptr;
    cholmod_dense *load_ = nullptr, *w_ = nullptr, *y_ = nullptr, *e_ = nullptr;
};

Side cholmod(const std::string& name, const Problem& problem, int supernodal, Order order) {
    const auto solver = std::make_shared<Cholmod>(problem, supernodal, order);
    return {name,
            [solver](const ArrayXXd& d, double* factor_s) { return solver->centre_compliance(d, factor_s); }};
}
#endif

std::vector<Side> others(const Problem& problem) {
    std::vector<Side> all{eigen(problem)};
#ifdef PALPATE_CHOLMOD
    const auto add = [&](const char* name, int supernodal, Order order) {
        all.push_back(cholmod(name, problem, supernodal, order));
    };
    add("simplicial_amd", CHOLMOD_SIMPLICIAL, Order::amd);
    add("simplicial_metis", CHOLMOD_SIMPLICIAL, Order::metis);
    add("simplicial_dissection", CHOLMOD_SIMPLICIAL, Order::dissection);
    add("supernodal_amd", CHOLMOD_SUPERNODAL, Order::amd);
    add("supernodal_metis", CHOLMOD_SUPERNODAL, Order::metis);
    add("supernodal_dissection", CHOLMOD_SUPERNODAL, Order::dissection);
#endif
    return all;
}

void race(benchmark::State& state, Index n) {
    const auto field = [n](double k) {
        return plate::fields::unit_square(n, [k](double x, double) { return 10.0 / (1.0 + k * x); });
    };
    const std::vector<Problem> problems{field(9.0), field(8.0)};
    std::vector<Side> sides = others(problems[0]);
    sides.insert(sides.begin(),
                 {own("best", problems[0], Kernel::best), own("portable", problems[0], Kernel::portable)});
    std::size_t turn = 0;
    for (auto _ : state) {
        const ArrayXXd& d = problems[++turn % 2].rigidity_n_m;
        std::vector<double> compliance(sides.size());
        for (std::size_t k = 0; k < sides.size(); ++k) {
            const std::size_t s = (k + turn) % sides.size();
            double factor_s = 0.0;
            static_cast<void>(sides[s].run(problems[(turn + 1) % 2].rigidity_n_m, &factor_s));
            sides[s].times_s.push_back(
                timed_s(Clock::cpu, [&] { compliance[s] = sides[s].run(d, &factor_s); }));
            sides[s].factor_times_s.push_back(factor_s);
        }
        for (const double c : compliance) {
            if (!(std::fabs(c / compliance[0] - 1.0) < AGREE))
                throw std::runtime_error("cholesky: the sides do not agree");
        }
        state.SetIterationTime(sides[0].times_s.back());
    }
    double best_s = std::numeric_limits<double>::infinity(), best_factor_s = best_s;
    for (std::size_t s = 0; s < sides.size(); ++s) {
        const double time_s = quantile(sides[s].times_s, 0.5);
        state.counters[sides[s].name + "_s"] = time_s;
        if (s < 2) continue;
        best_s = std::min(best_s, time_s);
        best_factor_s = std::min(best_factor_s, quantile(sides[s].factor_times_s, 0.5));
    }
    for (std::size_t s = 0; s < 2; ++s) {
        const double own_s = quantile(sides[s].times_s, 0.5);
        state.counters["ratio_" + sides[s].name] = best_s / own_s;
        state.counters["ratio_" + sides[s].name + "_to_their_factor_alone"] = best_factor_s / own_s;
    }
}

}  // namespace

void register_cholesky() {
    for (const Index n : {17, 33, 65, 129}) {
        add("cholesky/" + std::to_string(n) + " nodes, " + std::to_string((n - 2) * (n - 2)) + " unknowns",
            n > 65   ? 10
            : n > 33 ? 40
                     : 100,
            [n](benchmark::State& state) { race(state, n); });
    }
}

}  // namespace palpate::bench
