#include "host/plate/shell.hpp"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "host/plate/plate.hpp"

namespace palpate::plate {
namespace {

using Eigen::ArrayXXd;
using Eigen::Index;

constexpr double RADIUS_M = 0.03, THICKNESS_M = 1e-3, YOUNG_PA = 1e6, POISSON = 0.2;
constexpr double KAPPA = 1.0 / RADIUS_M;
constexpr double SIDE_M = 0.04;
constexpr double BEND = THICKNESS_M * THICKNESS_M * THICKNESS_M / (12.0 * (1.0 - POISSON * POISSON));  // D/E
const Shell SPHERE{KAPPA, KAPPA};
const ArrayXXd THICKNESS = ArrayXXd::Constant(1, 1, THICKNESS_M);
const Eigen::Vector2d PATCH_M{SIDE_M, SIDE_M};

ArrayXXd even_skin(Index n) {
    return ArrayXXd::Constant(n, n, YOUNG_PA);
}

ShellTerm term_of(const Shell& shell, const ArrayXXd& young_pa, double side_m = SIDE_M) {
    return shell_term(shell, young_pa, THICKNESS, POISSON, {side_m, side_m});
}

/// Centre compliance of an even patch with its shell term.
double patch_compliance(const Shell& shell, double side_m = SIDE_M) {
    const double rigidity = YOUNG_PA * BEND;
    const double foundation = term_of(shell, even_skin(5), side_m).foundation_n_per_m3(2, 2);
    const double side_over_l = side_m * std::pow(foundation / rigidity, 0.25);
    return uniform_square_compliance(side_over_l) * side_m * side_m / rigidity;
}

/// E around the centre, `contrast` times YOUNG_PA there and YOUNG_PA far away, falling off with `sigma_m`.
ArrayXXd wart(Index n, double contrast, double sigma_m) {
    ArrayXXd young(n, n);
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < n; ++j) {
            const double step = SIDE_M / static_cast<double>(n - 1);
            const double x = step * static_cast<double>(i - n / 2), z = step * static_cast<double>(j - n / 2);
            young(i, j) =
                YOUNG_PA * (1.0 + (contrast - 1.0) * std::exp(-(x * x + z * z) / (2.0 * sigma_m * sigma_m)));
        }
    }
    return young;
}

double compliance_with(const ArrayXXd& young_pa, const ArrayXXd& foundation) {
    Problem problem;
    problem.size_m = PATCH_M;
    problem.rigidity_n_m = young_pa * BEND;
    problem.foundation_n_per_m3 = foundation;
    problem.poisson = POISSON;
    return extrapolated_centre_compliance(problem).m_per_n;
}

TEST_CASE("a sphere's foundation is E h/R^2, and with it a wide patch gives way as Reissner's sphere") {
    const ShellTerm term = term_of(SPHERE, even_skin(9));
    CHECK_FALSE(term.boundary_dominated);
    const double expected = YOUNG_PA * THICKNESS_M * KAPPA * KAPPA;
    CHECK(term.foundation_n_per_m3.minCoeff() == Approx(expected).epsilon(1e-13));
    CHECK(term.foundation_n_per_m3.maxCoeff() == Approx(expected).epsilon(1e-13));
    CHECK(term.l_m == Approx(2.97e-3).margin(5e-6));
    const double reissner =
        std::sqrt(3.0 * (1.0 - POISSON * POISSON)) / 4.0 * RADIUS_M / (YOUNG_PA * THICKNESS_M * THICKNESS_M);
    CHECK(reissner == Approx(0.0127279).margin(5e-8));
    for (const double side_m : {0.04, 0.06}) {
        CHECK(patch_compliance(SPHERE, side_m) == Approx(reissner).epsilon(1e-3));
    }
    CHECK(patch_compliance(SPHERE, 0.02) == Approx(0.012363).margin(1e-6));
}

/// An even spherical patch on a grid.
Problem sphere(Index n, double side_m) {
    Problem problem;
    problem.size_m = {side_m, side_m};
    problem.rigidity_n_m = even_skin(n) * BEND;
    problem.foundation_n_per_m3 = term_of(SPHERE, even_skin(n), side_m).foundation_n_per_m3;
    problem.poisson = POISSON;
    return problem;
}

TEST_CASE("spherical patches of 4 and 6 cm, extrapolated from grids, give way as Reissner's sphere") {
    const double reissner = 0.0127279;
    const double side_m = GENERATE(as<double>{}, 0.04, 0.06);
    Problem problem = sphere(65, side_m);
    CHECK(Plate(problem).compliance_m_per_n({32, 32}) > 1.015 * reissner);
    CHECK(extrapolated_centre_compliance(problem).m_per_n == Approx(reissner).epsilon(1e-3));

    // The same without a uniform plate's known grid error: c_h = c + h^2 (a + b log h) through three grids.
    Eigen::Matrix3d system;
    Eigen::Vector3d m_per_n;
    for (int k = 0; k < 3; ++k) {
        const Index n = (32 << k) + 1;
        const double h = 1.0 / static_cast<double>(n - 1);
        system.row(k) << 1.0, h * h, h * h * std::log(h);
        m_per_n(k) = Plate(sphere(n, side_m)).compliance_m_per_n({n / 2, n / 2});
    }
    CHECK(system.lu().solve(m_per_n)(0) == Approx(reissner).epsilon(1e-3));
}

TEST_CASE("other curvatures give way as the mean over directions") {
    struct Row {
        double ratio, m_per_n;
        bool boundary_dominated;
    };
    // Computed apart from this code, by another plate solver; to the digits given.
    const std::vector<Row> rows{{1.0, 0.01273, false}, {0.5, 0.01798, false}, {0.25, 0.02523, false},
                                {0.0, 0.0430, true},   {-0.5, 0.0363, true},  {-1.0, 0.0279, true}};
    for (const Row& row : rows) {
        CAPTURE(row.ratio);
        const Shell shell{KAPPA, row.ratio * KAPPA};
        CHECK(patch_compliance(shell) == Approx(row.m_per_n).epsilon(1.4e-3));
        CHECK(term_of(shell, even_skin(5)).boundary_dominated == row.boundary_dominated);
    }
}

TEST_CASE("an endless shell has the foundation E h kappa1 kappa2") {
    for (const double ratio : {1.0, 0.8, 0.5, 0.3}) {
        CAPTURE(ratio);
        const double side_m = 0.4;
        const double infinite =
            1.0 / (8.0 * std::sqrt(YOUNG_PA * BEND * YOUNG_PA * THICKNESS_M * ratio) * KAPPA);
        CHECK(patch_compliance({KAPPA, ratio * KAPPA}, side_m) == Approx(infinite).epsilon(2e-4));
        CHECK_FALSE(term_of({KAPPA, ratio * KAPPA}, even_skin(5), side_m).boundary_dominated);
    }
}

TEST_CASE("turning a bowl over, swapping the axes or a little more curvature changes nothing much") {
    const auto foundation = [](double kappa1, double kappa2) {
        return term_of({kappa1, kappa2}, even_skin(5)).foundation_n_per_m3(2, 2);
    };
    for (const double ratio : {1.0, 0.4, 0.05, 0.0, -0.3, -1.0}) {
        CAPTURE(ratio);
        const double k = foundation(KAPPA, ratio * KAPPA);
        CHECK(foundation(-KAPPA, -ratio * KAPPA) == Approx(k).epsilon(1e-12));
        CHECK(foundation(ratio * KAPPA, KAPPA) == Approx(k).epsilon(1e-12));
        CHECK(foundation(KAPPA, (ratio + 1e-6) * KAPPA) == Approx(k).epsilon(1e-3));
    }
}

TEST_CASE("without curvature there is no foundation") {
    const ShellTerm term = term_of({}, even_skin(9));
    CHECK((term.foundation_n_per_m3 == 0.0).all());
    CHECK(term.foundation_n_per_m3.rows() == 9);
    CHECK_FALSE(term.boundary_dominated);
    CHECK(term.l_m == std::numeric_limits<double>::infinity());
    // A breath of curvature: still finite, and next to nothing.
    const ShellTerm slight = term_of({1e-9, 1e-9}, wart(9, 5.0, 0.004));
    CHECK(slight.foundation_n_per_m3.allFinite());
    CHECK(slight.foundation_n_per_m3.maxCoeff() < 1e-12);
}

TEST_CASE("the membrane feels E smoothed over 2 l: warts and soft spots on the sphere") {
    struct Row {
        double contrast, sigma_m, local, smoothed;
    };
    const std::vector<Row> rows{{5.0, 0.004, 0.266, 0.424},
                                {5.0, 0.008, 0.219, 0.275},
                                {5.0, 0.0025, 0.341, 0.536},
                                {0.2, 0.004, 2.58, 2.12}};
    const Index n = 65;
    const double per_young = THICKNESS_M * KAPPA * KAPPA;
    const double uniform = compliance_with(even_skin(n), even_skin(n) * per_young);
    for (const Row& row : rows) {
        CAPTURE(row.contrast, row.sigma_m);
        const ArrayXXd young = wart(n, row.contrast, row.sigma_m);
        CHECK(compliance_with(young, young * per_young) / uniform == Approx(row.local).epsilon(3e-3));
        CHECK(compliance_with(young, term_of(SPHERE, young).foundation_n_per_m3) / uniform ==
              Approx(row.smoothed).epsilon(5e-3));
    }
}

TEST_CASE("a smoothed constant is that constant, and a smoothed field stays between its ends") {
    const double per_young = THICKNESS_M * KAPPA * KAPPA;
    const ShellTerm even = term_of(SPHERE, even_skin(33));
    CHECK((even.foundation_n_per_m3 == even.foundation_n_per_m3(0, 0)).all());
    for (const double contrast : {5.0, 0.2, 1e3}) {
        CAPTURE(contrast);
        const ArrayXXd young = wart(33, contrast, 0.004);
        const ArrayXXd smooth = term_of(SPHERE, young).foundation_n_per_m3 / per_young;
        CHECK(smooth.minCoeff() >= young.minCoeff() * (1.0 - 1e-12));
        CHECK(smooth.maxCoeff() <= young.maxCoeff() * (1.0 + 1e-12));
        CHECK(smooth.maxCoeff() / smooth.minCoeff() < young.maxCoeff() / young.minCoeff());
    }
}

TEST_CASE("the patch ends where it ends: far from a wart, in a corner too, E is what it is there") {
    const double k = term_of(SPHERE, wart(65, 5.0, 0.002)).foundation_n_per_m3(0, 64);
    CHECK(k == Approx(YOUNG_PA * THICKNESS_M * KAPPA * KAPPA).epsilon(1e-4));
}

TEST_CASE("a harmonic mean: where E alternates finely, softness is what averages") {
    ArrayXXd young(65, 65);
    for (Index i = 0; i < 65; ++i)
        for (Index j = 0; j < 65; ++j) young(i, j) = (i + j) % 2 == 0 ? YOUNG_PA : 4.0 * YOUNG_PA;
    const double k = term_of(SPHERE, young).foundation_n_per_m3(32, 32);
    CHECK(k == Approx(1.6 * YOUNG_PA * THICKNESS_M * KAPPA * KAPPA).epsilon(1e-3));
}

TEST_CASE("where there is no skin there is no foundation, and it softens nothing around it") {
    ArrayXXd young = even_skin(33);
    young.topRows(10) = 0.0;
    const ArrayXXd k = term_of(SPHERE, young).foundation_n_per_m3;
    CHECK((k.topRows(10) == 0.0).all());
    CHECK((k.bottomRows(23) == k(16, 16)).all());
    CHECK(k(16, 16) == Approx(YOUNG_PA * THICKNESS_M * KAPPA * KAPPA).epsilon(1e-13));
}

TEST_CASE("thickness may vary from node to node") {
    ArrayXXd thickness(9, 9);
    for (Index i = 0; i < 9; ++i) thickness.row(i) = THICKNESS_M * (1.0 + 0.1 * static_cast<double>(i - 4));
    const ArrayXXd k = shell_term(SPHERE, even_skin(9), thickness, POISSON, PATCH_M).foundation_n_per_m3;
    const ArrayXXd expected = thickness * (YOUNG_PA * KAPPA * KAPPA);
    CHECK(((k - expected).abs() <= 1e-12 * expected).all());
}

TEST_CASE("a shell that cannot be is refused") {
    const auto refused = [](const Shell& shell, const ArrayXXd& young, const ArrayXXd& thickness,
                            double poisson, const Eigen::Vector2d& size) {
        CHECK_THROWS_AS(shell_term(shell, young, thickness, poisson, size), std::invalid_argument);
    };
    const double nan = std::nan("");
    ArrayXXd negative = even_skin(9), unknown = even_skin(9), hole = even_skin(9);
    negative(1, 1) = -1.0;
    unknown(1, 1) = nan;
    hole(4, 4) = 0.0;
    for (const ArrayXXd& young : {negative, unknown, hole, ArrayXXd(even_skin(9).topRows(8)),
                                  ArrayXXd(even_skin(9).leftCols(8)), even_skin(1), ArrayXXd()}) {
        refused(SPHERE, young, THICKNESS, POISSON, PATCH_M);
    }
    refused(SPHERE, even_skin(9), ArrayXXd::Constant(1, 1, 0.0), POISSON, PATCH_M);
    refused(SPHERE, even_skin(9), ArrayXXd::Constant(7, 9, 1e-3), POISSON, PATCH_M);
    refused(SPHERE, even_skin(9), ArrayXXd(), POISSON, PATCH_M);
    refused(SPHERE, even_skin(9), THICKNESS, 0.5, PATCH_M);
    refused(SPHERE, even_skin(9), THICKNESS, nan, PATCH_M);
    refused(SPHERE, even_skin(9), THICKNESS, POISSON, {0.04, 0.0});
    refused({nan, 1.0}, even_skin(9), THICKNESS, POISSON, PATCH_M);
}

}  // namespace
}  // namespace palpate::plate
