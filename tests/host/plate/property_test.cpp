// Random plates of every kind: each method meets the error it states, or says that it cannot.
#include <Eigen/SparseCholesky>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "host/plate/compliance.hpp"
#include "host/plate/solver.hpp"
#include "host/plate/stencil.hpp"
#include "tests/host/plate/random_sheet.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;
using fields::Kind;
using fields::RandomCase;

bool soak() {
    return std::getenv("PALPATE_SOAK") != nullptr;
}
std::uint64_t n_cases() {
    return soak() ? 10000 : 200;
}

/// Compliance at a node on the grid, from the stencil in long double by another factorisation.
double truth_m_per_n(const Stencil& stencil, const Node& node) {
    using Matrix = Eigen::SparseMatrix<long double>;
    const Moving& m = stencil.moving();
    const auto number = [&](Index ix, Index iz) { return (ix - m.x0) + (m.x1 - m.x0) * (iz - m.z0); };
    std::vector<Eigen::Triplet<long double>> entries;
    for (Index iz = m.z0; iz < m.z1; ++iz) {
        for (Index ix = m.x0; ix < m.x1; ++ix) {
            for (std::size_t k = CENTRE; k < N_COUPLINGS; ++k) {
                const Index x = ix + OFFSETS[k].dx, z = iz + OFFSETS[k].dz;
                if (!m.holds(x, z)) continue;
                const auto value = static_cast<long double>(
                    stencil.coupling(static_cast<Coupling>(k))[stencil.layout().at(ix, iz)]);
                const auto [low, high] = std::minmax({number(ix, iz), number(x, z)});
                entries.emplace_back(static_cast<int>(high), static_cast<int>(low), value);
            }
        }
    }
    Matrix lower(m.count(), m.count());
    lower.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Matrix, Eigen::Lower> factor(lower);
    Eigen::Matrix<long double, Eigen::Dynamic, 1> unit =
        Eigen::Matrix<long double, Eigen::Dynamic, 1>::Zero(m.count());
    unit(number(node.ix, node.iz)) = 1.0L;
    const auto w = factor.solve(unit).eval();
    return static_cast<double>(w(number(node.ix, node.iz))) * stencil.compliance_m_per_n();
}

/// What became of one method on one case.
enum class Fate { right, guarded, unfinished, refused, wrong };

/// |w'r| <= max(w) |r|_1 is what a residual allows, and a direct method has rounding beside it.
Fate fate_of(Method method, const Problem& problem, const Node& load, double truth, double rounding) {
    const auto n = static_cast<std::size_t>(problem.rigidity_n_m.size());
    std::vector<double> force(n, 0.0), w(n, 0.0);
    const auto at = static_cast<std::size_t>(load.ix + problem.rigidity_n_m.rows() * load.iz);
    force[at] = 1.0;
    try {
        const Options options{.tolerance = 1e-4 / static_cast<double>(n)};
        const Report report = make_solver(method, problem, options)->solve(force, w);
        if (report.status != Status::solved) return Fate::unfinished;
        const double largest = *std::max_element(
            w.begin(), w.end(), [](double a, double b) { return std::fabs(a) < std::fabs(b); });
        const double allowed =
            report.residual * static_cast<double>(n) * std::fabs(largest) / truth + rounding;
        return std::fabs(w[at] / truth - 1.0) <= allowed ? Fate::right : Fate::wrong;
    } catch (const Guard&) {
        return Fate::guarded;
    } catch (const std::invalid_argument&) {
        return Fate::refused;
    }
}

/// Every method is asked on a share of the cases that its slowness allows.
struct Share {
    Method method;
    std::uint64_t every;
};
constexpr std::array<Share, 5> SHARES{{{Method::cholesky, 1},
                                       {Method::eigen, 1},
                                       {Method::multigrid, 1},
                                       {Method::damped_jacobi, 8},
                                       {Method::jacobi, 8}}};
constexpr double ROUNDING = 2e-6;  ///< what the guard on the pivot ratio leaves at worst

TEST_CASE("on random plates every method meets the error it states on its grid, or says that it cannot") {
    std::array<std::array<int, 5>, SHARES.size()> fates{};
    for (std::uint64_t seed = 0; seed < n_cases(); ++seed) {
        const RandomCase c = fields::random_case(seed);
        const Problem problem = on_grid(c.sheet, c.nodes.nx, c.nodes.nz, NodeAt{c.load.at_m, 0});
        CAPTURE(c.words);
        REQUIRE(problem_with(problem).value_or("") == "");
        const Node load = nearest_node(problem, c.load.at_m);
        const double truth = truth_m_per_n(Stencil(problem), load);
        REQUIRE(truth > 0.0);
        for (std::size_t k = 0; k < SHARES.size(); ++k) {
            if (seed % SHARES[k].every != 0) continue;
            CAPTURE(name_of(SHARES[k].method));
            const Fate fate = fate_of(SHARES[k].method, problem, load, truth, ROUNDING);
            CHECK(fate != Fate::wrong);
            ++fates[k][static_cast<std::size_t>(fate)];
        }
    }
    for (std::size_t k = 0; k < SHARES.size(); ++k) {
        INFO(name_of(SHARES[k].method) << ": right " << fates[k][0] << " guarded " << fates[k][1]
                                       << " unfinished " << fates[k][2] << " refused " << fates[k][3]);
        if (SHARES[k].method == Method::jacobi) {
            CHECK(fates[k][0] == 0);  // plain Jacobi never converges on a plate
        } else {
            CHECK(fates[k][0] > 0);
        }
        if (SHARES[k].method == Method::cholesky || SHARES[k].method == Method::eigen)
            CHECK(fates[k][0] >= static_cast<int>(n_cases() * 9 / 10));
    }
}

TEST_CASE("on random plates the compliance is no further from a finer grid's than both say") {
    int told = 0;
    for (std::uint64_t seed = 0; seed < n_cases() / 2; ++seed) {
        const RandomCase c = fields::random_case(seed);
        CAPTURE(c.words);
        const auto ask = [&](const Nodes& nodes) {
            return compliance(c.sheet, nodes, std::array{c.load},
                              {.method = Method::cholesky, .bracket = false});
        };
        try {
            const Compliance here = ask(c.nodes), finer = ask({2 * c.nodes.nx - 1, 2 * c.nodes.nz - 1});
            const double allowed = here.relative_error * here.m_per_n + finer.relative_error * finer.m_per_n;
            CHECK(std::fabs(here.m_per_n - finer.m_per_n) <= allowed);
            told += finer.relative_error < 0.05;
        } catch (const Guard&) {
        }
    }
    CHECK(told > static_cast<int>(n_cases() / 40));
}

}  // namespace
}  // namespace palpate::plate
