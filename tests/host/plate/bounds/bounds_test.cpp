// What each rung of the bounds is worth, and that it costs no allocation.
#include "host/plate/bounds/bounds.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "host/plate/bounds/kernels.hpp"
#include "tests/host/plate/bounds/loads.hpp"
#include "tests/host/plate/counting_heap.hpp"
#include "tests/host/plate/fields.hpp"

using namespace palpate::plate;
using Eigen::ArrayXXd;
using Eigen::Index;
using loads::bracket_at;

namespace {

constexpr Index N = 33;
constexpr Node CENTRE{N / 2, N / 2};
constexpr std::array RUNGS{Rung::extremes, Rung::uniform, Rung::modes,
                           Rung::krylov2,  Rung::krylov3, Rung::krylov4};

double linear(double x, double) {
    return 0.5 + x;  // +-50 %
}
double wart5(double x, double z) {
    return 1.0 + 4.0 * fields::bell(x, z, 0.5, 0.5, 0.1);
}
double wart5_aside(double x, double z) {
    return 1.0 + 4.0 * fields::bell(x, z, 0.7, 0.6, 0.1);
}
double jump10(double x, double) {
    return x > 0.4 ? 10.0 : 1.0;
}
double jump10_farther(double x, double) {
    return x > 0.7 ? 10.0 : 1.0;
}

/// Bounds over the truth, in per cent off.
struct Off {
    double lower, upper;
};

Off off(const Bounds& bounds, const Problem& problem, const loads::Force& force, Rung rung) {
    Bounds::Scratch scratch(bounds);
    const Bracket bracket = bracket_at(bounds, problem, rung, scratch);
    const double c = loads::compliance(problem, force);
    return {100.0 * (bracket.lower_m_per_n / c - 1.0), 100.0 * (bracket.upper_m_per_n / c - 1.0)};
}

/// The foundation grows with D where D varies: one material, of varying Young's modulus.
Problem square(double (*rigidity)(double, double), double side_over_l) {
    Problem problem = fields::unit_square(N, rigidity);
    if (side_over_l > 0.0) {
        problem = fields::on_foundation(problem, side_over_l);
        problem.foundation_n_per_m3 *= problem.rigidity_n_m;
    }
    return problem;
}

TEST_CASE("bounds scale as 1/D over all that double holds") {
    const double unit = GENERATE(as<double>{}, 1e-300, 1e-70, 1e70, 1e300);
    Problem problem = fields::on_foundation(fields::unit_square(N, linear), 5.0);
    std::vector<double> force(static_cast<std::size_t>(N * N), 0.0);
    force[static_cast<std::size_t>(CENTRE.ix + N * CENTRE.iz)] = 1.0;
    const Climb climb{.relative_error = 0.0, .last = Rung::krylov2};
    const Bracket plain = bracket(problem, force, climb);
    problem.rigidity_n_m *= unit;
    problem.foundation_n_per_m3 *= unit;
    const Bracket scaled = bracket(problem, force, climb);
    CHECK(scaled.lower_m_per_n * unit == Approx(plain.lower_m_per_n).epsilon(1e-9));
    CHECK(scaled.upper_m_per_n * unit == Approx(plain.upper_m_per_n).epsilon(1e-9));
}

}  // namespace

TEST_CASE("a uniform plate is known to eleven digits on every rung") {
    const Rung rung = GENERATE(as<Rung>{}, Rung::extremes, Rung::uniform, Rung::modes, Rung::krylov2,
                               Rung::krylov3, Rung::krylov4);
    const Problem problem = fields::unit_square(N, fields::one);
    const Bounds bounds(problem, loads::point(N, N, CENTRE));
    Bounds::Scratch scratch(bounds);
    const Bracket bracket = bracket_at(bounds, problem, rung, scratch);
    INFO(name_of(rung));
    CHECK(bracket.rung == rung);
    CHECK(bracket.lower_m_per_n <= bracket.upper_m_per_n);
    CHECK(bracket.relative_error() < 1e-11);
    CHECK(bracket.middle_m_per_n() == Approx(5.696151392e-3).epsilon(1e-9));  // an independent code's
}

TEST_CASE("bounds are as tight as an independent computation of the same theory") {
    struct Case {
        const char* name;
        double (*rigidity)(double, double);
        Rung rung;
        Off off;
    };
    // Rounded to the digits given there; its upper bound of a jump summed cells apart, 0.9 % tighter.
    const Case c = GENERATE(
        as<Case>{}, Case{"linear", linear, Rung::uniform, {-1.9, 3.9}},
        Case{"wart", wart5, Rung::uniform, {-20.0, 18.5}},
        Case{"wart aside", wart5_aside, Rung::uniform, {-6.8, 5.3}},
        Case{"jump", jump10, Rung::uniform, {-22.0, 94.7}},
        Case{"jump farther", jump10_farther, Rung::uniform, {-29.9, 44.3}},
        Case{"hyperbola", fields::hyper10, Rung::uniform, {-10.5, 12.2}},
        Case{"linear", linear, Rung::modes, {-0.01, 0.01}}, Case{"wart", wart5, Rung::modes, {-0.33, 0.02}},
        Case{"wart aside", wart5_aside, Rung::modes, {-3.2, 4.1}},
        Case{"hyperbola", fields::hyper10, Rung::modes, {0.0, 0.48}},
        Case{"jump", jump10, Rung::krylov2, {-3.0, 18.6}}, Case{"jump", jump10, Rung::krylov3, {-0.04, 0.47}},
        Case{"jump farther", jump10_farther, Rung::krylov3, {-0.1, 0.4}},
        Case{"jump", jump10, Rung::krylov4, {0.0, 0.07}});
    const Problem problem = square(c.rigidity, 0.0);
    const loads::Force force = loads::point(N, N, CENTRE);
    const Off found = off(Bounds(problem, force), problem, force, c.rung);
    INFO(c.name << ", " << name_of(c.rung) << ": " << found.lower << " " << found.upper << " %");
    CHECK(found.lower == Approx(c.off.lower).margin(0.06));
    CHECK(found.upper == Approx(c.off.upper).margin(0.11));
}

TEST_CASE("the widths that are promised are kept") {
    const auto width = [](double (*rigidity)(double, double), Rung rung) {
        const Problem problem = square(rigidity, 0.0);
        const loads::Force force = loads::point(N, N, CENTRE);
        const Off found = off(Bounds(problem, force), problem, force, rung);
        return found.upper - found.lower;
    };
    CHECK(width(linear, Rung::uniform) <= 6.0);
    CHECK(width(linear, Rung::modes) <= 0.1);
    CHECK(width(wart5, Rung::modes) <= 0.5);
    CHECK(width(jump10, Rung::krylov3) <= 0.6);
}

TEST_CASE("loads beside the centre and over a disc, and foundations, are bounded as well") {
    struct Case {
        const char* name;
        loads::Force force;
        double side_over_l;
        Off linear, wart;
    };
    const Case c =
        GENERATE(as<Case>{}, Case{"beside", loads::point(N, N, {20, 16}), 0.0, {-1.5, 3.1}, {-14.0, 13.0}},
                 Case{"disc", loads::disc(N, 0.5, 0.5, 0.1), 0.0, {-2.2, 4.2}, {-16.0, 17.0}},
                 Case{"a/l 6.7", loads::point(N, N, CENTRE), 6.7, {-0.7, 1.5}, {-11.0, 24.0}},
                 Case{"a/l 13.5", loads::point(N, N, CENTRE), 13.5, {-0.16, 0.31}, {-2.9, 10.8}},
                 Case{"disc 13.5", loads::disc(N, 0.5, 0.5, 0.1), 13.5, {-0.4, 0.4}, {-2.8, 14.8}});
    INFO(c.name);
    // One foundation, the one that the independent computation had.
    const Bounds::Foundations own{
        .first = std::max(c.side_over_l, 1.0), .last = std::max(c.side_over_l, 1.0), .ratio = 1.1};
    const Bounds bounds(square(linear, c.side_over_l), c.force, own);
    const Off linear_off = off(bounds, square(linear, c.side_over_l), c.force, Rung::uniform);
    const Off wart_off = off(bounds, square(wart5, c.side_over_l), c.force, Rung::uniform);
    INFO("linear " << linear_off.lower << " " << linear_off.upper << ", wart " << wart_off.lower << " "
                   << wart_off.upper);
    CHECK(linear_off.lower == Approx(c.linear.lower).margin(0.1));
    CHECK(linear_off.upper == Approx(c.linear.upper).margin(0.1));
    CHECK(wart_off.lower >=
          c.wart.lower - 0.6);  // the bare plate's trial, tried as well, may be the better one
    CHECK(wart_off.upper == Approx(c.wart.upper).margin(0.6));
}

TEST_CASE("no field of given extremes is bounded worse than Kantorovich's inequality says") {
    const Bounds bounds(fields::unit_square(N, fields::one), loads::point(N, N, CENTRE));
    Bounds::Scratch scratch(bounds);
    CHECK(uniform_rung_error(0.8, 1.2) == Approx(std::sqrt(1.0 + 1.0 / 24.0) - 1.0));  // 4.2 % of up/lo
    fields::Random random(5);
    double worst = 0.0;
    for (int k = 0; k < 50; ++k) {
        Problem problem = fields::unit_square(N, fields::one);
        const double share = random.next();
        problem.rigidity_n_m = ArrayXXd::NullaryExpr(N, N, [&] { return random.next() < share ? 0.5 : 1.5; });
        const double error = bracket_at(bounds, problem, Rung::uniform, scratch).relative_error();
        CHECK(error <= uniform_rung_error(0.5, 1.5) * (1.0 + 1e-9));
        worst = std::max(worst, error);
    }
    CHECK(worst > 0.9 * uniform_rung_error(0.5, 1.5));  // the inequality is sharp
}

TEST_CASE("the climb ends on the first rung that is good enough, and says which") {
    const Problem problem = square(wart5, 0.0);
    const Bounds bounds(problem, loads::point(N, N, CENTRE));
    Bounds::Scratch scratch(bounds);
    const auto climbed = [&](double error) {
        const Bracket bracket =
            bounds.bracket(loads::span_of(problem.rigidity_n_m), {}, {.relative_error = error}, scratch);
        CHECK(bracket.relative_error() <= error);
        return bracket.rung;
    };
    CHECK(climbed(1.5) == Rung::extremes);
    CHECK(climbed(0.3) == Rung::uniform);
    CHECK(climbed(0.01) == Rung::modes);
    CHECK(climbed(0.001) == Rung::krylov4);
    CHECK(bracket(problem, loads::point(N, N, CENTRE), {.relative_error = 0.01}).rung == Rung::modes);
}

TEST_CASE("a bracket allocates nothing") {
    const double side_over_l = GENERATE(as<double>{}, 0.0, 8.0);
    const Problem problem = square(wart5, side_over_l);
    const Bounds bounds(problem, loads::point(N, N, CENTRE), {.first = 6.0, .last = 10.0, .ratio = 1.2});
    Bounds::Scratch scratch(bounds);
    [[maybe_unused]] const Bracket first = bracket_at(bounds, problem, Rung::krylov2, scratch);
    for (const Rung rung : RUNGS) {
        const long before = n_allocations();
        const Bracket bracket = bracket_at(bounds, problem, rung, scratch);
        CHECK(n_allocations() == before);
        CHECK(bracket.rung == rung);
    }
    CHECK(n_allocations() > 0);  // the counter counts
}

TEST_CASE("a sum in doubles is the sum, and the same bits on every instruction set") {
    const bounds::RunnableSums runnable = bounds::runnable_sums();
    fields::Random random(3);
    for (std::size_t n = 1; n <= 41; ++n) {
        constexpr std::size_t N_ROWS = 13;  // groups of eight and four, and one over
        std::vector<double> rows(N_ROWS * n), x(n), w(n);
        for (double& v : rows) v = random.next() - 0.5;
        for (double& v : x) v = random.next() - 0.5;
        for (double& v : w) v = random.next();
        using Found = std::vector<double>;
        const auto found = [&](const bounds::SumKernels& sums) {
            Found all(N_ROWS);
            sums.dot_rows(rows.data(), N_ROWS, x.data(), n, all.data());
            const bounds::Pair both = sums.dot_both(x.data(), w.data(), rows.data(), n);
            for (const double sum : {sums.dot(x.data(), w.data(), n), both.first, both.second,
                                     sums.weighted_square(x.data(), w.data(), n),
                                     sums.weighted_magnitude(x.data(), w.data(), n)})
                all.push_back(sum);
            Found scaled(n), reciprocals(n);
            const bounds::Extremes ends =
                sums.scale_and_invert(x.data(), n, 3.0, 0.7, scaled.data(), reciprocals.data());
            all.insert(all.end(), {ends.least, ends.most, ends.finite ? 1.0 : 0.0});
            all.insert(all.end(), scaled.begin(), scaled.end());
            all.insert(all.end(), reciprocals.begin(), reciprocals.end());
            return all;
        };
        const Found all = found(*runnable.sets[0]);
        for (std::size_t k = 1; k < runnable.n; ++k) {
            CAPTURE(n, runnable.sets[k]->name);
            CHECK(found(*runnable.sets[k]) == all);
        }
        long double dot = 0, square = 0, magnitude = 0;
        for (std::size_t i = 0; i < n; ++i) {
            const long double xi = x[i], wi = w[i];
            dot += xi * wi;
            square += wi * xi * xi;
            magnitude += wi * std::fabs(xi);
        }
        const double rounding = static_cast<double>(n + 1) * 0x1p-53 * static_cast<double>(magnitude);
        CHECK(std::fabs(all[N_ROWS] - static_cast<double>(dot)) <= rounding);
        CHECK(all[N_ROWS + 1] == all[N_ROWS]);
        CHECK(std::fabs(all[N_ROWS + 3] - static_cast<double>(square)) <= rounding);
        CHECK(std::fabs(all[N_ROWS + 4] - static_cast<double>(magnitude)) <= rounding);
        CHECK(all[N_ROWS + 5] == *std::min_element(x.begin(), x.end()) * 3.0 * 0.7);
        CHECK(all[N_ROWS + 6] == *std::max_element(x.begin(), x.end()) * 3.0 * 0.7);
        for (std::size_t i = 0; i < n; ++i) {
            CHECK(all[N_ROWS + 8 + i] == x[i] * 3.0 * 0.7);
            CHECK(all[N_ROWS + 8 + n + i] == 1.0 / all[N_ROWS + 8 + i]);
        }
    }
}

TEST_CASE("a value that is not finite is told wherever it stands") {
    const bounds::RunnableSums runnable = bounds::runnable_sums();
    const double bad = GENERATE(as<double>{}, NAN, INFINITY, -INFINITY);
    for (std::size_t k = 0; k < runnable.n; ++k) {
        for (std::size_t at = 0; at < 21; ++at) {
            std::array<double, 21> x{}, reciprocals{};
            x.fill(2.0);
            CHECK(runnable.sets[k]->invert(x.data(), x.size(), reciprocals.data()).finite);
            x[at] = bad;
            CHECK_FALSE(runnable.sets[k]->invert(x.data(), x.size(), reciprocals.data()).finite);
        }
    }
}

TEST_CASE("portable and best kernels give the same bracket, bit for bit, around the truth") {
    const double side_over_l = GENERATE(as<double>{}, 0.0, 8.0);
    const Problem problem = square(wart5, side_over_l);
    const loads::Force force = loads::point(N, N, CENTRE);
    const Bounds::Foundations few{.first = 6.0, .last = 10.0, .ratio = 1.2};
    const Bounds portable(problem, force, few, Kernel::portable), best(problem, force, few, Kernel::best);
    Bounds::Scratch on_portable(portable), on_best(best);
    const double c = loads::compliance(problem, force);
    CHECK(std::string(portable.kernel()) == "baseline");
    for (const Rung rung : RUNGS) {
        INFO(name_of(rung) << ", " << best.kernel());
        const Bracket a = bracket_at(portable, problem, rung, on_portable);
        const Bracket b = bracket_at(best, problem, rung, on_best);
        CHECK(a.lower_m_per_n == b.lower_m_per_n);
        CHECK(a.upper_m_per_n == b.upper_m_per_n);
        CHECK(b.lower_m_per_n <= c * (1.0 + 1e-12));
        CHECK(b.upper_m_per_n >= c * (1.0 - 1e-12));
    }
}

TEST_CASE("where the foundation has a hole the bare plate bounds from above") {
    Problem problem = square(wart5, 8.0);
    problem.foundation_n_per_m3.block(10, 10, 8, 5).setZero();
    const loads::Force force = loads::point(N, N, CENTRE);
    const Bounds bounds(problem, force, {.first = 6.0, .last = 10.0, .ratio = 1.2});
    Problem bare = problem;
    bare.foundation_n_per_m3.resize(0, 0);
    for (const Rung rung : RUNGS) {
        const Off found = off(bounds, problem, force, rung);
        INFO(name_of(rung) << " " << found.lower << " " << found.upper);
        CHECK(found.lower <= 0.0);
        CHECK(found.upper >= 0.0);
    }
    Bounds::Scratch scratch(bounds);
    CHECK(bracket_at(bounds, problem, Rung::krylov4, scratch).upper_m_per_n ==
          Approx(loads::compliance(bare, force)).epsilon(0.01));
}

TEST_CASE("a laminate, a mask, a varying Poisson's ratio and a plate on nothing have no certificate") {
    const Problem fine = fields::unit_square(9, fields::hyper10);
    CHECK_FALSE(Bounds::none_because(fine));
    const auto words = [](const Problem& problem) { return Bounds::none_because(problem).value_or(""); };
    Problem laminate = fine;
    laminate.harmonic_x_n_m = laminate.harmonic_z_n_m = 0.9 * fine.rigidity_n_m;
    CHECK_THAT(words(laminate), Catch::Contains("laminate"));
    Problem holed = fine;
    holed.solid = Mask::Constant(9, 9, true);
    CHECK_FALSE(Bounds::none_because(holed));
    holed.solid(4, 4) = false;
    CHECK_THAT(words(holed), Catch::Contains("holes"));
    Problem mixed = fine;
    mixed.poisson_at_nodes = ArrayXXd::Constant(9, 9, 0.3);
    CHECK_FALSE(Bounds::none_because(mixed));
    mixed.poisson_at_nodes(2, 3) = 0.2;
    CHECK_THAT(words(mixed), Catch::Contains("Poisson"));
    Problem afloat = fields::on_foundation(fine, 5.0);
    afloat.edges = {Edge::free, Edge::free, Edge::free, Edge::free};
    CHECK_THAT(words(afloat), Catch::Contains("foundation"));
    CHECK_THROWS_AS(Bounds(holed, loads::point(9, 9, {4, 4})), std::invalid_argument);
}

TEST_CASE("loads and fields that mean nothing are refused in words") {
    Problem problem = fields::on_foundation(fields::unit_square(9, fields::one), 5.0);
    CHECK_THROWS_WITH(Bounds(problem, loads::point(9, 9, {0, 4})), Catch::Contains("no force"));
    CHECK_THROWS_WITH(Bounds(problem, loads::Force(80, 1.0)), Catch::Contains("one force per node"));
    loads::Force pull = loads::point(9, 9, {4, 4});
    pull[30] = -0.1;
    CHECK_THROWS_WITH(Bounds(problem, pull), Catch::Contains("none negative"));

    const Bounds bounds(problem, loads::point(9, 9, {4, 4}), {.first = 4.0, .last = 6.0, .ratio = 1.2});
    Bounds::Scratch scratch(bounds);
    const double bad = GENERATE(as<double>{}, 0.0, -1.0, NAN, INFINITY);
    Problem broken = problem;
    broken.rigidity_n_m(3, 7) = bad;
    CHECK_THROWS_WITH(bracket_at(bounds, broken, Rung::uniform, scratch), Catch::Contains("rigidity"));
    broken = problem;
    broken.foundation_n_per_m3(8, 8) = bad == 0.0 ? -1.0 : bad;
    CHECK_THROWS_WITH(bracket_at(bounds, broken, Rung::uniform, scratch), Catch::Contains("foundation"));
    const Bounds bare(fields::unit_square(9, fields::one), loads::point(9, 9, {4, 4}));
    Bounds::Scratch bare_scratch(bare);
    CHECK_THROWS_WITH(bracket_at(bare, problem, Rung::uniform, bare_scratch), Catch::Contains("without"));
}
