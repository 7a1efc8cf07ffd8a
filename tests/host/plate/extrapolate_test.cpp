#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "host/plate/plate.hpp"
#include "host/plate/uniform/uniform.hpp"
#include "tests/host/plate/fields.hpp"
#include "tests/host/plate/square_series.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;
using namespace fields;

TEST_CASE("the series for the uniform square meets what is known of it") {
    CHECK(truth::uniform_square_compliance(0.0) == Approx(0.005612024020).epsilon(2e-10));
    // Foundation patches of a sphere, R 30 mm, h 1 mm, E 1 MPa, nu 0.2: computed apart from this code.
    const double rigidity = 1e6 * 1e-9 / 12.0 / (1.0 - 0.04);
    const double l = std::pow(rigidity / (1e6 * 1e-3 / 9e-4), 0.25);
    const auto sphere = [&](double side) {
        return truth::uniform_square_compliance(side / l) * side * side / rigidity;
    };
    CHECK(sphere(0.02) == Approx(0.012363).margin(6e-7));
    CHECK(sphere(0.04) == Approx(0.012724).margin(6e-7));
    CHECK(sphere(0.06) == Approx(0.012728).margin(6e-7));
    CHECK(8.0 * 9.0 * truth::uniform_square_compliance(3.0) == Approx(0.384).margin(6e-4));
    CHECK(8.0 * 36.0 * truth::uniform_square_compliance(6.0) == Approx(0.931).margin(1e-3));
}

TEST_CASE("the uniform square's table is the series, everywhere and across its seams") {
    for (int k = 0; k <= 150; ++k) {
        const double s = 0.2 * k + 0.003 * (k % 7);
        CAPTURE(s);
        const double allowed = s <= 24.0 ? 1e-9 : 1e-7;
        CHECK(uniform_square_compliance(s) == Approx(truth::uniform_square_compliance(s)).epsilon(allowed));
    }
    for (const double seam : {4.0, 8.0, 16.0, 24.0}) {
        const double below = uniform_square_compliance(std::nextafter(seam, 0.0));
        CHECK(uniform_square_compliance(std::nextafter(seam, 99.0)) == Approx(below).epsilon(2e-7));
    }
    CHECK(uniform_square_compliance(1e3) == Approx(1.0 / 8e6).epsilon(1e-12));
    CHECK_THROWS_AS(uniform_square_compliance(-0.1), std::invalid_argument);
    CHECK_THROWS_AS(uniform_square_compliance(std::nan("")), std::invalid_argument);
}

TEST_CASE("the uniform square's grid values are those of the plate itself") {
    for (const Index n : {Index{9}, Index{17}, Index{33}}) {
        for (const double s : {0.0, 0.7, 3.9, 4.1, 7.7, 11.3, 19.0, 24.0, 37.0, 95.0, 120.0}) {
            CAPTURE(n, s);
            const double solved = Plate(uniform_square(n, s)).centre_compliance_m_per_n();
            CHECK(uniform_square_grid_compliance(n, s) == Approx(solved).epsilon(1e-9));
        }
    }
}

TEST_CASE("a uniform square comes out exact on every grid, however coarse for its l") {
    for (const double s : {0.0, 6.7, 13.5, 30.0, 60.0}) {
        CAPTURE(s);
        const Estimate compliance = extrapolated_centre_compliance(on_foundation(unit_square(17, one), s));
        CHECK(compliance.m_per_n == Approx(uniform_square_compliance(s)).epsilon(1e-8));
        CHECK(compliance.relative_error < 1e-5);
    }
}

TEST_CASE("nine nodes are enough, and one fewer row is not") {
    for (const double s : {0.0, 6.7, 13.5}) {
        const Estimate compliance = extrapolated_centre_compliance(on_foundation(unit_square(9, one), s));
        CHECK(compliance.m_per_n == Approx(uniform_square_compliance(s)).epsilon(1e-8));
        CHECK(compliance.relative_error < 1e-5);
    }
    const Estimate hill = extrapolated_centre_compliance(unit_square(9, gauss));
    const double truth = extrapolated_centre_compliance(unit_square(65, gauss)).m_per_n;
    CHECK(std::fabs(hill.m_per_n / truth - 1.0) <= 2.0 * hill.relative_error);
    CHECK_THROWS_AS(extrapolated_centre_compliance(unit_square(5, one)), std::invalid_argument);
}

struct Known {
    std::string name;
    double (*rigidity)(double, double);
    double poisson;
    double compliance;
    double uncertainty;  ///< relative, of the compliance
    double on_33;        ///< relative error allowed with 17 + 33 nodes
    double on_65;        ///< with 33 + 65
};

/// Computed apart from this code, by a boundary fit and by C1 elements.
std::vector<Known> known() {
    return {{"uniform", one, 0.2, 0.005612024020, 1e-10, 1e-9, 1e-9},
            {"1 + x", [](double x, double) { return 1.0 + x; }, 0.3, 0.00377153, 2e-6, 2e-5, 4e-6},
            {"1 + 4 gauss(.15)", gauss, 0.2, 0.00257143, 2e-6, 2e-4, 1e-5}};
}

TEST_CASE("known compliances are met by 17 + 33 and 33 + 65 nodes, and the error told is honest") {
    for (const Known& k : known()) {
        Problem fine = unit_square(33, k.rigidity);
        fine.poisson = k.poisson;
        Problem finer = unit_square(65, k.rigidity);
        finer.poisson = k.poisson;
        for (const auto& [problem, allowed] : {std::pair{fine, k.on_33}, std::pair{finer, k.on_65}}) {
            const Estimate compliance = extrapolated_centre_compliance(problem);
            const double error = std::fabs(compliance.m_per_n / k.compliance - 1.0);
            INFO(k.name << ", " << problem.rigidity_n_m.rows() << ": error " << error << ", told "
                        << compliance.relative_error);
            CHECK(error <= allowed);
            CHECK(error <= 2.0 * compliance.relative_error + k.uncertainty);
            CHECK(compliance.relative_error < 1e-3);
        }
    }
}

double linear50(double x, double) {
    return 0.5 + x;
}
double hyper_centred(double x, double) {
    return 10.0 / (1.0 + 9.0 * x) / (10.0 / 5.5);
}
double nodule(double x, double z) {
    return 1.0 + 4.0 * bell(x, z, 0.5, 0.5, 0.1);
}
double nodule_aside(double x, double z) {
    return 1.0 + 4.0 * bell(x, z, 0.43, 0.45, 0.1);
}
double step10(double x, double) {
    return 1.0 + 9.0 / (1.0 + std::exp(-(x - 0.55) / 0.03));
}
double step3(double x, double) {
    return x < 0.6 ? 1.0 : 3.0;
}

struct Field {
    std::string name;
    double (*rigidity)(double, double);
    double side_over_l;
    double on_33;  ///< relative error allowed with 17 + 33 nodes
};

TEST_CASE("a foundation costs no accuracy, and the error told is never less than half of what it is") {
    // Truth: 65 + 129 nodes, whose change from 33 + 65 is far below what is checked here (or, at the steps,
    // told).
    const std::vector<Field> fields{
        {"linear +-50 %", linear50, 13.5, 5e-4},  {"hyperbolic", hyper_centred, 11.6, 5e-4},
        {"nodule", nodule, 13.4, 5e-4},           {"nodule aside", nodule_aside, 13.4, 5e-4},
        {"hyperbolic, bare", hyper10, 0.0, 5e-5}, {"wart, bare", wart, 0.0, 5e-4},
        {"steep step", step10, 13.4, 2e-3},       {"jump", step3, 13.4, 3e-2}};
    for (const Field& field : fields) {
        const auto compliance = [&](Index n) {
            return extrapolated_centre_compliance(
                on_foundation(unit_square(n, field.rigidity), field.side_over_l));
        };
        const Estimate truth = compliance(129);
        const Estimate coarse = compliance(17);
        const Estimate fine = compliance(33);
        const double error = std::fabs(fine.m_per_n / truth.m_per_n - 1.0);
        INFO(field.name << ": error " << error << ", told " << fine.relative_error);
        CHECK(error <= field.on_33);
        CHECK(error <= 2.0 * fine.relative_error);
        CHECK(std::fabs(coarse.m_per_n / truth.m_per_n - 1.0) <= 2.0 * coarse.relative_error);
    }
}

TEST_CASE("rectangles and unequal spacing converge to the continuum") {
    // Computed apart from this code.
    const auto rectangle = [](Index nx, Index nz, double size_z) {
        Problem problem;
        problem.size_m = {1.0, size_z};
        problem.rigidity_n_m = Eigen::ArrayXXd::Ones(nx, nz);
        return extrapolated_centre_compliance(problem).m_per_n;
    };
    CHECK(rectangle(33, 65, 2.0) == Approx(0.0072305563).epsilon(2e-4));
    CHECK(rectangle(33, 49, 1.5) == Approx(0.0070428578).epsilon(2e-4));
    CHECK(rectangle(65, 65, 1.5) == Approx(0.0070428578).epsilon(1e-3));
    Problem problem = unit_square(65, [](double x, double z) { return std::exp(x + 0.5 * z); });
    problem.size_m = {1.0, 0.5};
    CHECK(extrapolated_centre_compliance(problem).m_per_n == Approx(0.00085000).epsilon(1e-3));
    problem.rigidity_n_m = Eigen::ArrayXXd(65, 33);
    for (Index ix = 0; ix < 65; ++ix) {
        for (Index iz = 0; iz < 33; ++iz) {
            problem.rigidity_n_m(ix, iz) = std::exp(static_cast<double>(ix + iz) / 64.0);
        }
    }
    CHECK(extrapolated_centre_compliance(problem).m_per_n == Approx(0.00085000).epsilon(2e-4));
}

TEST_CASE("the extrapolated compliance is smooth in the rigidity, where its tables meet too") {
    // Second differences of a smooth function: halving the step quarters them. Uniform D scaled through a/l
    // = 8.
    const auto at = [](double t) {
        Problem problem = on_foundation(unit_square(17, linear50), 8.0);
        problem.rigidity_n_m *= 1.0 + t;
        return extrapolated_centre_compliance(problem).m_per_n;
    };
    const auto second = [&](double t, double step) { return at(t + step) - 2.0 * at(t) + at(t - step); };
    for (const double t : {-0.1, -1e-3, 0.0, 1e-3, 0.1}) {
        CAPTURE(t);
        CHECK(second(t, 2e-3) / second(t, 1e-3) == Approx(4.0).margin(0.02));
    }
}

}  // namespace
}  // namespace palpate::plate
