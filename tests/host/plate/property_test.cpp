// Random plates of every kind: each method meets the error it states, or says that it cannot.
#include <Eigen/SparseCholesky>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "host/plate/bounds/bounds.hpp"
#include "host/plate/compliance.hpp"
#include "host/plate/iterative/eq7.hpp"
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
constexpr double ROUNDING = 2e-6;  ///< what the guard on the pivot ratio leaves at worst
constexpr std::array<Share, 5> SHARES{{{Method::cholesky, 1},
                                       {Method::eigen, 1},
                                       {Method::multigrid, 1},
                                       {Method::damped_jacobi, 8},
                                       {Method::jacobi, 8}}};

/// The certificate of the grid, where there is one, holds the compliance. True when it is there.
bool bracket_holds(const Problem& problem, const Node& load, double truth) {
    if (Bounds::none_because(problem)) return false;
    std::vector<double> force(static_cast<std::size_t>(problem.rigidity_n_m.size()), 0.0);
    force[static_cast<std::size_t>(load.ix + problem.rigidity_n_m.rows() * load.iz)] = 1.0;
    const Bracket range = bracket(problem, force);
    CHECK(range.lower_m_per_n <= truth);
    CHECK(range.upper_m_per_n >= truth);
    return true;
}

TEST_CASE("on random plates every method meets the error it states on its grid, or says that it cannot") {
    std::array<std::array<int, 5>, SHARES.size()> fates{};
    int bracketed = 0;
    for (std::uint64_t seed = 0; seed < n_cases(); ++seed) {
        const RandomCase c = fields::random_case(seed);
        const Problem problem = on_grid(c.sheet, c.nodes.nx, c.nodes.nz, NodeAt{c.load.at_m, 0});
        CAPTURE(c.words);
        REQUIRE(problem_with(problem).value_or("") == "");
        const Node load = nearest_node(problem, c.load.at_m);
        const double truth = truth_m_per_n(Stencil(problem), load);
        REQUIRE(truth > 0.0);
        bracketed += bracket_holds(problem, load, truth);
        for (std::size_t k = 0; k < SHARES.size(); ++k) {
            if (seed % SHARES[k].every != 0) continue;
            CAPTURE(name_of(SHARES[k].method));
            const Fate fate = fate_of(SHARES[k].method, problem, load, truth, ROUNDING);
            CHECK(fate != Fate::wrong);
            ++fates[k][static_cast<std::size_t>(fate)];
        }
    }
    CHECK(bracketed > static_cast<int>(n_cases() / 4));
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

/// What eq. 7 has terms for: an even, clamped grid; D to the power 0.15, else its guard alone would speak.
Problem for_eq7(Problem problem) {
    problem.edges.fill(Edge::clamped);
    problem.lines_x_m = problem.lines_z_m = {};
    problem.harmonic_x_n_m = problem.harmonic_z_n_m = {};
    problem.solid = {};
    problem.rigidity_n_m = problem.rigidity_n_m.pow(0.15);
    return problem;
}

TEST_CASE("on random plates eq. 7 is near the energy form, or its guard speaks") {
    std::array<int, 5> fates{};
    for (std::uint64_t seed = 0; seed < n_cases(); ++seed) {
        const RandomCase c = fields::random_case(seed);
        const Problem problem = for_eq7(on_grid(c.sheet, c.nodes.nx, c.nodes.nz));
        CAPTURE(c.words);
        if (problem_with(problem)) continue;  // D of a hole may end at its rim
        const Node load = nearest_node(problem, c.load.at_m);
        const Fate fate =
            fate_of(Method::eq7, problem, load, truth_m_per_n(Stencil(problem), load), EQ7_OFF_ENERGY_FORM);
        CHECK(fate != Fate::wrong);
        ++fates[static_cast<std::size_t>(fate)];
    }
    INFO("right " << fates[0] << " guarded " << fates[1] << " refused " << fates[3]);
    CHECK(fates[0] > static_cast<int>(n_cases() / 10));
    CHECK(fates[1] > 0);
    CHECK(fates[3] == 0);
}

/// Certifying costs up to half a second, so on a share of the cases.
constexpr std::uint64_t CERTIFY_EVERY = 8;

TEST_CASE("on random plates the compliance is no further from a finer grid's than both say") {
    int told = 0, certified = 0;
    for (std::uint64_t seed = 0; seed < n_cases() / 2; ++seed) {
        const RandomCase c = fields::random_case(seed);
        CAPTURE(c.words);
        const bool certify = seed / fields::N_KINDS % CERTIFY_EVERY == 0;
        const auto ask = [&](const Nodes& nodes, bool bracket) {
            return compliance(c.sheet, nodes, std::array{c.load},
                              {.method = Method::cholesky, .bracket = bracket});
        };
        try {
            const Compliance here = ask(c.nodes, certify),
                             finer = ask({2 * c.nodes.nx - 1, 2 * c.nodes.nz - 1}, false);
            const double finer_error = finer.relative_error * finer.m_per_n;
            CHECK(std::fabs(here.m_per_n - finer.m_per_n) <=
                  here.relative_error * here.m_per_n + finer_error);
            told += finer.relative_error < 0.05;
            if (!here.bracket_m_per_n) continue;
            CHECK(here.bracket_m_per_n->front() <= finer.m_per_n + finer_error);
            CHECK(here.bracket_m_per_n->back() >= finer.m_per_n - finer_error);
            ++certified;
        } catch (const Guard&) {
        }
    }
    CHECK(told > static_cast<int>(n_cases() / 40));
    CHECK(certified > 0);
}

}  // namespace
}  // namespace palpate::plate
