#include "host/plate/direct/factor.hpp"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "host/plate/plate.hpp"
#include "tests/host/plate/fields.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Grid {
    Index nx, nz;
    std::array<Edge, 4> edges;
    std::string name;
};

std::vector<Grid> grids() {
    constexpr auto C = Edge::clamped, S = Edge::supported, F = Edge::free;
    return {{5, 5, {C, C, C, C}, "smallest"},    {5, 9, {C, C, C, C}, "one leaf"},
            {6, 8, {C, C, C, C}, "even counts"}, {9, 13, {S, S, S, S}, "supported"},
            {33, 17, {C, C, C, C}, "rectangle"}, {13, 21, {C, F, S, F}, "one of each"},
            {7, 24, {F, F, C, F}, "cantilever"}, {11, 11, {F, F, F, F}, "free, on its foundation alone"}};
}

/// Uneven D, and a foundation so that every plate is held.
Problem problem_on(const Grid& grid) {
    Problem problem;
    problem.size_m = {0.03, 0.04};
    problem.edges = grid.edges;
    problem.rigidity_n_m.resize(grid.nx, grid.nz);
    fields::Random random(20260704);
    for (double& d : problem.rigidity_n_m.reshaped()) d = 1e-3 * (1.0 + 9.0 * random.next());
    problem.foundation_n_per_m3 = Eigen::ArrayXXd::Constant(grid.nx, grid.nz, 1e6);
    return problem;
}

/// K by elimination number, in the stencil's units.
MatrixXd dense(const Stencil& stencil, const Analysis& analysis) {
    const auto n = static_cast<Index>(analysis.n_unknowns);
    const Layout& grid = stencil.layout();
    MatrixXd k = MatrixXd::Zero(n, n);
    for (Index iz = 0; iz < grid.nz; ++iz) {
        for (Index ix = 0; ix < grid.nx; ++ix) {
            for (std::size_t c = 0; c < N_COUPLINGS; ++c) {
                const Index x = ix + OFFSETS[c].dx, z = iz + OFFSETS[c].dz;
                if (!stencil.moving().holds(ix, iz) || !stencil.moving().holds(x, z)) continue;
                const auto i = static_cast<Index>(analysis.number[grid.at(ix, iz)]);
                const auto j = static_cast<Index>(analysis.number[grid.at(x, z)]);
                k(i, j) = k(j, i) = stencil.coupling(static_cast<Coupling>(c))[grid.at(ix, iz)];
            }
        }
    }
    return k;
}

VectorXd solved(const Factor& factor, const VectorXd& load) {
    FactorWorkspace work(factor.analysis());
    VectorXd x = load;
    factor.solve({x.data(), static_cast<std::size_t>(x.size())}, work);
    return x;
}

VectorXd diagonal(const Factor& factor) {
    FactorWorkspace work(factor.analysis());
    VectorXd all(static_cast<Index>(factor.analysis().n_unknowns));
    for (Index k = 0; k < all.size(); ++k) all(k) = factor.compliance(static_cast<std::size_t>(k), work);
    return all;
}

double difference(const VectorXd& a, const VectorXd& b) {
    return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

TEST_CASE("the factor of every kernel solves the plate, whatever its grid and edges") {
    for (const Grid& grid : grids()) {
        const Stencil stencil(problem_on(grid));
        const auto analysis = analysis_for(stencil.layout(), stencil.moving());
        const MatrixXd k = dense(stencil, *analysis);
        const Eigen::LDLT<MatrixXd> truth(k);
        const MatrixXd inverse = truth.solve(MatrixXd::Identity(k.rows(), k.cols()));
        fields::Random random(20260705);
        const VectorXd load = VectorXd::NullaryExpr(k.rows(), [&] { return random.next() - 0.5; });
        VectorXd portable, portable_diagonal;
        const RunnableKernels runnable = runnable_kernels();
        for (std::size_t s = 0; s < runnable.n; ++s) {
            CAPTURE(grid.name, runnable.sets[s]->name);
            Factor factor(analysis, *runnable.sets[s]);
            CHECK_FALSE(factor.smallest_pivot_ratio() > 0.0);
            factor.factorise(stencil);
            REQUIRE(factor.smallest_pivot_ratio() > 1e-8);
            const VectorXd x = solved(factor, load), every = diagonal(factor);
            // The condition number is 1e4 to 1e6.
            CHECK(difference(x, truth.solve(load)) < 1e-9);
            CHECK(difference(every, inverse.diagonal()) < 1e-9);
            CHECK(factor.last_compliance() == Approx(inverse(k.rows() - 1, k.rows() - 1)).epsilon(1e-9));
            VectorXd last(k.rows());
            FactorWorkspace work(*analysis);
            factor.solve_last({last.data(), analysis->n_unknowns}, work);
            CHECK(difference(last, inverse.col(k.rows() - 1)) < 1e-9);
            if (s == 0) portable = x, portable_diagonal = every;
            CHECK(difference(x, portable) < 1e-11);
            CHECK(difference(every, portable_diagonal) < 1e-11);
        }
    }
}

TEST_CASE("the smallest pivot ratio is that of a dense Cholesky in the same order") {
    const Stencil stencil(problem_on(grids()[4]));
    const auto analysis = analysis_for(stencil.layout(), stencil.moving());
    const MatrixXd k = dense(stencil, *analysis);
    const MatrixXd l = k.llt().matrixL();
    const double wanted = (l.diagonal().array().square() / k.diagonal().array()).minCoeff();
    const RunnableKernels runnable = runnable_kernels();
    for (std::size_t s = 0; s < runnable.n; ++s) {
        Factor factor(analysis, *runnable.sets[s]);
        factor.factorise(stencil);
        CHECK(factor.smallest_pivot_ratio() == Approx(wanted).epsilon(1e-9));
    }
}

TEST_CASE("a pivot that is not positive and finite is told by every kernel, wherever it is") {
    constexpr double NOT_A_NUMBER = std::numeric_limits<double>::quiet_NaN();
    constexpr double INFINITE = std::numeric_limits<double>::infinity();
    const double bad = GENERATE_COPY(as<double>{}, -1e4, NOT_A_NUMBER, INFINITE);
    Problem problem = fields::unit_square(17, fields::hyper10);
    Stencil stencil(problem);
    const auto analysis = analysis_for(stencil.layout(), stencil.moving());
    const RunnableKernels runnable = runnable_kernels();
    for (std::size_t s = 0; s < runnable.n; ++s) {
        Factor factor(analysis, *runnable.sets[s]);
        for (Index node = 0; node < 17 * 17; ++node) {
            CAPTURE(runnable.sets[s]->name, bad, node);
            Eigen::ArrayXXd rigidity = problem.rigidity_n_m;
            rigidity(node) = bad;
            stencil.set_rigidity(rigidity);
            factor.factorise(stencil);
            CHECK_FALSE(factor.smallest_pivot_ratio() > 0.0);
        }
        stencil.set_rigidity(problem.rigidity_n_m);
        factor.factorise(stencil);
        CHECK(factor.smallest_pivot_ratio() > 0.01);
        CHECK(1.0 / factor.last_compliance() ==
              Approx(stencil.compliance_m_per_n() / 2.883232925e-3).epsilon(1e-9));
    }
}

TEST_CASE("the centre is eliminated last and its front has no border") {
    for (const Grid& grid : grids()) {
        CAPTURE(grid.name);
        const Analysis analysis(grid.nx, grid.nz, Moving(grid.nx, grid.nz, grid.edges));
        CHECK(analysis.number[analysis.layout.at(grid.nx / 2, grid.nz / 2)] == analysis.n_unknowns - 1);
        CHECK(analysis.fronts.back().n_border == 0);
        CHECK(analysis.fronts.back().parent == Analysis::NONE);
    }
}

}  // namespace
}  // namespace palpate::plate
