#include "firmware/core/lookup.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/common/tables.hpp"

namespace {

using Vec = std::array<double, 3>;

double basis(double t) {  // cubic B-spline, centred
    t = std::fabs(t);
    if (t < 1.0) return 2.0 / 3.0 - t * t + 0.5 * t * t * t;
    return t < 2.0 ? (2.0 - t) * (2.0 - t) * (2.0 - t) / 6.0 : 0.0;
}

double field(const pal_table& t, int plane, double u, double v) {
    const int side = static_cast<int>(t.n_nodes) + 2;
    const double middle = 0.5 * (t.n_nodes - 1.0);
    double sum = 0.0;
    for (int i = 0; i < side; ++i) {
        const double bu = basis(u / static_cast<double>(t.spacing_m) + middle - (i - 1));
        if (bu == 0.0) continue;
        for (int j = 0; j < side; ++j) {
            sum += bu * basis(v / static_cast<double>(t.spacing_m) + middle - (j - 1)) *
                   static_cast<double>(t.coef[plane * side * side + i * side + j]);
        }
    }
    return sum;
}

struct Truth {
    double f, potential_j;
};

/// U in double precision, straight from the definition: distance to the sphere by its centre, no small
/// tricks.
Truth truth(const pal_table& t, const Vec& at) {
    Vec x{};
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t c = 0; c < 3; ++c)
            x[i] += static_cast<double>(t.axes[3 * i + c]) * (at[c] - static_cast<double>(t.p0_m[c]));
    }
    const double kappa = static_cast<double>(t.kappa_per_m);
    const double q = 1.0 + kappa * x[2];
    double height = x[2];
    if (kappa != 0.0) {
        const double r = 1.0 / kappa;
        const double to_centre = std::sqrt(x[0] * x[0] + x[1] * x[1] + (x[2] + r) * (x[2] + r));
        height = (r > 0.0 ? 1.0 : -1.0) * to_centre - r;
    }
    const double u = x[0] / q, v = x[1] / q;
    const double f = field(t, 0, u, v) - height;
    const double h = field(t, 2, u, v) * f;
    const double psi = (1.0 + static_cast<double>(t.psi[0]) * h + static_cast<double>(t.psi[1]) * h * h +
                        static_cast<double>(t.psi[2]) * h * h * h * h) /
                       (1.0 + static_cast<double>(t.psi[3]) * h + static_cast<double>(t.psi[4]) * h * h);
    return {f, f > 0.0 ? 0.5 * field(t, 1, u, v) * f * f * psi : 0.0};
}

double kappa_of(int shape) {
    return std::array<double, 3>{1.0 / 0.03, -1.0 / 0.03, 0.0}[static_cast<std::size_t>(shape)];
}

/// Bumps, varying K and H, hardening, a tilted frame: nothing is special.
std::unique_ptr<pal_table> bumpy(double kappa_per_m, pal_law law = PAL_LAW_POTENTIAL) {
    tables::Fields fields;
    fields.s_m = [](double u, double v) { return 3.0e-4 * std::sin(1000.0 * u) * std::cos(900.0 * v); };
    fields.k_n_per_m = [](double u, double v) { return 650.0 + 15000.0 * u + 60.0 * std::sin(700.0 * v); };
    fields.h_per_m = [](double u, double v) { return 1000.0 + 2.0e4 * v + 50.0 * std::cos(500.0 * u); };
    auto table = tables::make(fields, 33, kappa_per_m);
    const std::array<float, 5> psi = {0.153F, 0.036F, 0.009F, 0.456F, 0.179F};
    std::copy(psi.begin(), psi.end(), table->psi);
    const std::array<float, 9> axes = {0.8F, 0.0F, -0.6F, 0.36F, 0.8F, 0.48F, 0.48F, -0.6F, 0.64F};
    std::copy(axes.begin(), axes.end(), table->axes);
    table->p0_m[0] = 0.01F;
    table->p0_m[1] = -0.02F;
    table->p0_m[2] = 0.015F;
    table->law = law;
    pal_table_seal(table.get());
    return table;
}

Vec to_workspace(const pal_table& t, const Vec& x) {
    Vec at{};
    for (std::size_t c = 0; c < 3; ++c) {
        at[c] = static_cast<double>(t.p0_m[c]);
        for (std::size_t i = 0; i < 3; ++i) at[c] += static_cast<double>(t.axes[3 * i + c]) * x[i];
    }
    return at;
}

pal_touch touch(const pal_table& t, const Vec& at) {
    const float place[3] = {static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])};
    pal_touch out;
    pal_table_touch(&t, place, &out);
    return out;
}

/// Work on the hand around a closed loop 3 mm below the fitted sphere.
double lap_j(const pal_table& t, double* potential_max_j) {
    constexpr int N = 40000;
    std::array<float, 3> was{};
    pal_touch before{};
    double work = 0.0;
    for (int n = 0; n <= N; ++n) {
        const double angle = 6.283185307179586 * (n % N) / N;
        const Vec x = {5.0e-3 * std::cos(angle), 4.0e-3 * std::sin(angle),
                       -3.0e-3 + 3.0e-4 * std::sin(3.0 * angle)};
        const Vec at = to_workspace(t, x);
        const std::array<float, 3> place = {static_cast<float>(at[0]), static_cast<float>(at[1]),
                                            static_cast<float>(at[2])};
        pal_touch now;
        pal_table_touch(&t, place.data(), &now);
        *potential_max_j = std::max(*potential_max_j, static_cast<double>(now.potential_j));
        for (std::size_t c = 0; n > 0 && c < 3; ++c) {
            work += 0.5 * (static_cast<double>(now.force_n[c]) + static_cast<double>(before.force_n[c])) *
                    (static_cast<double>(place[c]) - static_cast<double>(was[c]));
        }
        before = now;
        was = place;
    }
    return work;
}

}  // namespace

TEST_CASE("the force is minus the gradient of the potential, convex, concave and flat") {
    const int shape = GENERATE(as<int>{}, 0, 1, 2);
    const auto table = bumpy(kappa_of(shape));
    const auto limits = tables::limits();
    REQUIRE(pal_table_check(table.get(), &limits) == PAL_OK);
    std::mt19937 random(17);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    int n_pressed = 0;
    for (int n = 0; n < 400; ++n) {
        const Vec x = {6.0e-3 * unit(random), 6.0e-3 * unit(random), -2.0e-3 + 3.0e-3 * unit(random)};
        Vec at = to_workspace(*table, x);
        for (double& c : at) c = static_cast<double>(static_cast<float>(c));
        const pal_touch felt = touch(*table, at);
        const Truth here = truth(*table, at);
        REQUIRE(felt.inside);
        if (std::fabs(here.f) < 1.0e-5) continue;
        CHECK((felt.depth_m > 0.0F) == (here.f > 0.0));
        CHECK(std::fabs(static_cast<double>(felt.potential_j) - here.potential_j) <
              1.0e-8 + 1.0e-5 * here.potential_j);
        n_pressed += here.f > 0.0 ? 1 : 0;
        for (std::size_t c = 0; c < 3; ++c) {
            constexpr double STEP_M = 1.0e-7;
            Vec lower = at, upper = at;
            lower[c] -= STEP_M;
            upper[c] += STEP_M;
            const double slope =
                (truth(*table, upper).potential_j - truth(*table, lower).potential_j) / (2.0 * STEP_M);
            CHECK(std::fabs(static_cast<double>(felt.force_n[c]) + slope) <
                  1.0e-4);  // float32, forces to 5 N
        }
    }
    CHECK(n_pressed > 200);
}

TEST_CASE("a closed lap nets nothing with the potential law and something without its lateral terms") {
    const int shape = GENERATE(as<int>{}, 0, 1, 2);
    double potential_max_j = 0.0;
    const double kept = lap_j(*bumpy(kappa_of(shape)), &potential_max_j);
    const double made = lap_j(*bumpy(kappa_of(shape), PAL_LAW_NORMAL), &potential_max_j);
    INFO("shape " << shape << ": " << kept << " J of " << potential_max_j << ", normal law " << made);
    CHECK(potential_max_j > 1.0e-3);
    CHECK(std::fabs(kept) < 2.0e-9);
    CHECK(std::fabs(made) > 1.0e-6);
}

TEST_CASE("the normal law makes (k2 - k1) d^2/2 from press soft, slide, release stiff: 2.4 mJ") {
    tables::Fields fields;  // 500 N/m at u = -5 mm, 800 N/m at +5 mm
    fields.k_n_per_m = [](double u, double) { return 650.0 + 30000.0 * u; };
    for (const auto law : {PAL_LAW_POTENTIAL, PAL_LAW_NORMAL}) {
        const auto table = tables::make(fields);
        table->law = law;
        double work = 0.0;
        const auto path = [&](double x0, double z0, double x1, double z1) {
            constexpr int N = 4000;
            for (int n = 0; n < N; ++n) {
                const double m = (n + 0.5) / N;
                const pal_touch felt = touch(*table, {x0 + m * (x1 - x0), 0.0, z0 + m * (z1 - z0)});
                work += (static_cast<double>(felt.force_n[0]) * (x1 - x0) +
                         static_cast<double>(felt.force_n[2]) * (z1 - z0)) /
                        N;
            }
        };
        path(-5.0e-3, 0.0, -5.0e-3, -4.0e-3);
        path(-5.0e-3, -4.0e-3, 5.0e-3, -4.0e-3);
        path(5.0e-3, -4.0e-3, 5.0e-3, 0.0);
        CHECK(std::fabs(work - (law == PAL_LAW_NORMAL ? 2.4e-3 : 0.0)) < 1.0e-6);
    }
}

TEST_CASE("above the surface there is no force, and the height is told as a negative depth") {
    const auto table = tables::make();
    const pal_touch felt = touch(*table, {1.0e-3, 2.0e-3, 2.5e-3});
    CHECK(felt.inside);
    CHECK(felt.depth_m == -2.5e-3F);
    CHECK(felt.potential_j == 0.0F);
    for (const float f : felt.force_n) CHECK(f == 0.0F);
}

TEST_CASE("on a slope depth is the distance and stiffness is the one along the normal") {
    tables::Fields fields;
    fields.s_m = [](double u, double) { return 0.75 * u; };          // normal (-0.6, 0, 0.8)
    fields.k_n_per_m = [](double, double) { return 500.0 * 0.64; };  // K = k g^2, g = 0.8
    const auto table = tables::make(fields);
    const pal_touch felt = touch(*table, {0.6e-3 * 2.0, 0.0, -0.8e-3 * 2.0});  // 2 mm along minus the normal
    CHECK(std::fabs(felt.depth_m - 2.0e-3F) < 1.0e-8F);
    CHECK(std::fabs(felt.k_n_per_m - 500.0F) < 1.0e-2F);
    CHECK(std::fabs(felt.force_n[0] + 0.6F) < 1.0e-5F);
    CHECK(std::fabs(felt.force_n[2] - 0.8F) < 1.0e-5F);
}

TEST_CASE("beyond the valid radius, past the sphere's middle and for NaN the table does not answer") {
    const auto flat = tables::make();
    const auto round = tables::make({}, 33, 1.0 / 0.03);
    const double far_m = GENERATE(as<double>{}, 0.01001, 0.02, 1.0, 1.0e30, INFINITY, NAN);
    for (const Vec& at : {Vec{far_m, 0.0, -1.0e-3}, Vec{0.0, far_m, -1.0e-3}}) {
        const pal_touch felt = touch(*flat, at);
        CHECK_FALSE(felt.inside);
        CHECK(felt.depth_m == 0.0F);
        for (const float f : felt.force_n) CHECK(f == 0.0F);
    }
    CHECK_FALSE(touch(*flat, {0.0, 0.0, static_cast<double>(NAN)}).inside);
    CHECK(touch(*round, {0.0, 0.0, -0.0239}).inside);  // q = 0.203
    CHECK_FALSE(touch(*round, {0.0, 0.0, -0.0241}).inside);
    CHECK_FALSE(touch(*round, {0.0, 0.0, -0.06}).inside);
}

TEST_CASE("crossing a cell line changes the force in proportion to the step") {
    const auto table = bumpy(1.0 / 0.03);
    for (int cell = -8; cell <= 8; ++cell) {
        const double line = cell * static_cast<double>(table->spacing_m) * (1.0 - 2.0e-3 / 0.03);
        const auto jump = [&](double step) {
            const pal_touch a = touch(*table, to_workspace(*table, {line - step, 1.0e-3, -2.0e-3}));
            const pal_touch b = touch(*table, to_workspace(*table, {line + step, 1.0e-3, -2.0e-3}));
            double sum = 0.0;
            for (int c = 0; c < 3; ++c)
                sum += std::pow(static_cast<double>(b.force_n[c]) - static_cast<double>(a.force_n[c]), 2);
            return std::sqrt(sum);
        };
        CHECK(std::fabs(jump(2.0e-5) / jump(4.0e-5) - 0.5) < 0.05);
        CHECK(jump(1.0e-7) < 2.0e-3);
    }
}
