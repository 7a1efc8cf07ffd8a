// The theorem: whatever the field, the discrete plate's compliance is where the bounds say, on every rung.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/host/plate/bounds/loads.hpp"
#include "tests/host/plate/bounds/random_field.hpp"

using namespace palpate::plate;
using Eigen::ArrayXXd;
using Eigen::Index;
using fields::Random;

namespace {

constexpr std::array RUNGS{Rung::extremes, Rung::uniform, Rung::modes,
                           Rung::krylov2,  Rung::krylov3, Rung::krylov4};
// The factor's own relative error: 2e-14 over its pivot ratio, which is at least 1e-8 (MATH.md eq. 5), and
// 1e-4 of that in all but stiff islands.
constexpr double SOLVER_ERROR = 1e-8;

/// A plate, a load, and what they are ready for.
struct Stand {
    Problem problem;
    loads::Force force;
    bool on_foundation;
};

Stand make_stand(int k, Random& random) {
    constexpr std::array<Index, 3> SIZES{17, 33, 21};
    const Index n = SIZES[static_cast<std::size_t>(k) % SIZES.size()];
    Stand stand{fields::unit_square(n, fields::one), {}, k % 2 == 1};
    stand.problem.size_m = {0.04, k % 3 == 0 ? 0.04 : 0.03};
    stand.problem.poisson = -0.4 + 0.85 * random.next();
    if (k % 4 >= 2) stand.problem.edges = {Edge::clamped, Edge::supported, Edge::free, Edge::clamped};
    if (stand.on_foundation) stand.problem = fields::on_foundation(stand.problem, 1.0);
    const auto place = [&] { return static_cast<Index>(static_cast<double>(n - 4) * random.next()) + 2; };
    stand.force = k % 5 == 4 ? loads::disc(n, 0.3 + 0.4 * random.next(), 0.5, 0.15)
                             : loads::point(n, n, k % 5 == 0 ? Node{n / 2, n / 2} : Node{place(), place()});
    return stand;
}

/// D of contrast up to 1e6; k_f for a/l up to 24 at D = 1, of contrast up to 1e3, every third time with a
/// hole.
void draw(Stand& stand, int k, Random& random) {
    const Index n = stand.problem.rigidity_n_m.rows();
    const auto kind = static_cast<fields::Kind>(k % fields::N_KINDS);
    stand.problem.rigidity_n_m =
        fields::sampled(n, fields::random_field(random, kind, fields::log_uniform(random, 1e6)));
    if (!stand.on_foundation) return;
    const auto other = static_cast<fields::Kind>((k / 5) % fields::N_KINDS);
    const double side_over_l = 24.0 * random.next();
    stand.problem.foundation_n_per_m3 =
        std::pow(side_over_l / 0.04, 4.0) *
        fields::sampled(n, fields::random_field(random, other, fields::log_uniform(random, 1e3)));
    if (k % 3 == 0) stand.problem.foundation_n_per_m3.block(n / 4, n / 3, n / 4, n / 2).setZero();
}

}  // namespace

TEST_CASE("a thousand plates of all kinds lie inside their brackets on every rung") {
    constexpr int N_STANDS = 20, N_DRAWS = 50;
    Random random(20);
    int n_checked = 0, n_refused = 0;
    double tightest = 1.0;
    for (int stand_k = 0; stand_k < N_STANDS; ++stand_k) {
        Stand stand = make_stand(stand_k, random);
        const Bounds bounds(stand.problem, stand.force, {.first = 2.0, .last = 16.0, .ratio = 1.5});
        Bounds::Scratch scratch(bounds);
        for (int k = 0; k < N_DRAWS; ++k) {
            draw(stand, k, random);
            double c = 0.0;
            try {
                c = loads::compliance(stand.problem, stand.force);
            } catch (const Guard&) {  // the factorisation cannot be trusted; nothing to compare with
                ++n_refused;
                continue;
            }
            double width = 1e300;
            for (const Rung rung : RUNGS) {
                const Bracket bracket = loads::bracket_at(bounds, stand.problem, rung, scratch);
                INFO("stand " << stand_k << ", draw " << k << ", " << name_of(rung)
                              << ": c/lower - 1 = " << c / bracket.lower_m_per_n - 1.0
                              << ", upper/c - 1 = " << bracket.upper_m_per_n / c - 1.0);
                REQUIRE(bracket.lower_m_per_n <= c * (1.0 + SOLVER_ERROR));
                REQUIRE(bracket.upper_m_per_n >= c * (1.0 - SOLVER_ERROR));
                REQUIRE(bracket.lower_m_per_n > 0.0);
                REQUIRE(bracket.relative_error() <= width);  // no rung forgets what a lower one knew
                width = bracket.relative_error();
            }
            tightest = std::min(tightest, width);
            ++n_checked;
        }
    }
    INFO(n_checked << " checked, " << n_refused << " refused by the solver, tightest " << tightest);
    CHECK(n_checked >= 950);
    CHECK(tightest < 1e-6);
}
