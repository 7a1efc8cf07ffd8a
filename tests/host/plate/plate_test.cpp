#include "host/plate/plate.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/host/plate/fields.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;
using namespace fields;

struct Anchor {
    Index n;
    double (*rigidity)(double, double);
    double compliance;
};

/// Deflection under a load per area, from the dense matrix.
Eigen::VectorXd deflection_under(const Plate& plate, const Eigen::VectorXd& load) {
    return plate.dense_stiffness_n_per_m().ldlt().solve(load);
}

double at_centre(const Eigen::VectorXd& interior) {
    return interior(interior.size() / 2);
}

TEST_CASE("the compliance on a grid is that of the energy form, to nine digits") {
    // Found by an independent code.
    const std::vector<Anchor> anchors{{17, one, 5.893088423e-3},         {33, one, 5.696151392e-3},
                                      {65, one, 5.636449687e-3},         {17, hyper10, 2.883232925e-3},
                                      {33, hyper10, 2.791781845e-3},     {65, hyper10, 2.763141024e-3},
                                      {17, linear10, 1.140287018e-3},    {33, linear10, 1.100602759e-3},
                                      {65, linear10, 1.088626285e-3},    {17, wart, 2.802410895e-3},
                                      {33, wart, 2.747091104e-3},        {65, wart, 2.731902175e-3},
                                      {17, jump1000, 1.338722452e-5},    {33, jump1000, 1.222187694e-5},
                                      {65, jump1000, 1.253183819e-5},    {17, soft_centre, 6.362091482e-3},
                                      {33, soft_centre, 5.867652696e-3}, {65, soft_centre, 5.695440974e-3}};
    for (const Anchor& anchor : anchors) {
        CAPTURE(anchor.n, anchor.compliance);
        const Plate plate(unit_square(anchor.n, anchor.rigidity));
        CHECK(plate.centre_compliance_m_per_n() == Approx(anchor.compliance).epsilon(1e-9));
    }
}

TEST_CASE("a uniform load bends the uniform plate by the known amount, with second order") {
    // Discrete values of an independent code (seven digits), and the continuum's.
    constexpr double CONTINUUM = 0.001265319087;
    const auto centre = [](Index n) {
        const auto interior = (n - 2) * (n - 2);
        const double cell = 1.0 / static_cast<double>((n - 1) * (n - 1));
        return at_centre(
            deflection_under(Plate(unit_square(n, one)), Eigen::VectorXd::Constant(interior, cell)));
    };
    const double coarse = centre(17);
    const double fine = centre(33);
    CHECK(coarse == Approx(1.307301e-3).epsilon(1e-6));
    CHECK(fine == Approx(1.275979e-3).epsilon(1e-6));
    CHECK(std::log2((coarse - CONTINUUM) / (fine - CONTINUUM)) == Approx(2.0).margin(0.1));
}

TEST_CASE("the lowest eigenvalue of the uniform plate is the known one") {
    const Plate plate(unit_square(33, one));
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
        plate.dense_stiffness_n_per_m() * (32.0 * 32.0), Eigen::EigenvaluesOnly);
    CHECK(eigen.eigenvalues()(0) == Approx(1282.9).margin(0.05));
}

TEST_CASE("a made-up deflection comes back with second order, for uneven rigidity too") {
    // w = (x(1-x)z(1-z))^2 (1+x) with D = 1 + x: q = lap(D lap w) - (1-nu)(D_xx w_zz + D_zz w_xx - 2 D_xz
    // w_xz), and D is linear: q = D lap^2 w + 2 d/dx lap w.
    const auto largest_error = [](Index n) {
        const Plate plate(unit_square(n, [](double x, double) { return 1.0 + x; }));
        const auto f = [](double x) {
            return std::pow(x * (1.0 - x), 2) * (1.0 + x);
        };  // x^2 - x^3 - x^4 + x^5
        const auto f1 = [](double x) { return 2 * x - 3 * x * x - 4 * x * x * x + 5 * x * x * x * x; };
        const auto f2 = [](double x) { return 2 - 6 * x - 12 * x * x + 20 * x * x * x; };
        const auto f3 = [](double x) { return -6 - 24 * x + 60 * x * x; };
        const auto f4 = [](double x) { return -24 + 120 * x; };
        const auto g = [](double z) { return std::pow(z * (1.0 - z), 2); };  // z^2 - 2 z^3 + z^4
        const auto g2 = [](double z) { return 2 - 12 * z + 12 * z * z; };
        const Eigen::ArrayXXd load = sampled(n, [&](double x, double z) {
            const double biharmonic = f4(x) * g(z) + 2.0 * f2(x) * g2(z) + f(x) * 24.0;
            return (1.0 + x) * biharmonic + 2.0 * (f3(x) * g(z) + f1(x) * g2(z));
        });
        const Eigen::ArrayXXd wanted = sampled(n, [&](double x, double z) { return f(x) * g(z); });
        const Index m = n - 2;
        const double cell = 1.0 / static_cast<double>((n - 1) * (n - 1));
        const Eigen::MatrixXd inner = load.block(1, 1, m, m).matrix().transpose() * cell;
        const Eigen::VectorXd w = deflection_under(plate, inner.reshaped());
        const Eigen::MatrixXd wanted_inner = wanted.block(1, 1, m, m).matrix().transpose();
        return (w - wanted_inner.reshaped()).cwiseAbs().maxCoeff() / wanted.maxCoeff();
    };
    const double coarse = largest_error(17);
    CHECK(coarse < 3.3e-2);
    CHECK(std::log2(coarse / largest_error(33)) == Approx(2.0).margin(0.1));
}

TEST_CASE("a plate much larger than l forgets its edge") {
    // 1/8 l^2/D in the continuum; on this grid of h = l/4 it is h^2 ln(l/h)/(16 pi) and a like amount more: 3
    // %.
    const Plate plate(on_foundation(unit_square(65, one), 16.0));
    CHECK(plate.centre_compliance_m_per_n() * 8.0 * 256.0 == Approx(1.0).margin(3e-2));
    const Eigen::ArrayXXd off_centre = plate.deflection_m(24, 32);
    CHECK(off_centre(24, 32) == Approx(plate.centre_compliance_m_per_n()).epsilon(1e-3));
}

TEST_CASE(
    "the answer is the solution of the matrix, and the matrix does not depend on the order of elimination") {
    Problem problem = on_foundation(unit_square(13, hyper10), 5.0);
    problem.rigidity_n_m.conservativeResize(13, 9);
    problem.foundation_n_per_m3.conservativeResize(13, 9);
    problem.size_m = {0.03, 0.02};
    const Plate plate(problem);
    const Eigen::MatrixXd stiffness = plate.dense_stiffness_n_per_m();
    REQUIRE(stiffness.rows() == 11 * 7);
    Eigen::VectorXd load = Eigen::VectorXd::Zero(stiffness.rows());
    load((4 - 1) * 7 + (2 - 1)) = 1.0;
    const Eigen::VectorXd wanted = stiffness.ldlt().solve(load);
    const Eigen::ArrayXXd deflection = plate.deflection_m(4, 2);
    for (Index ix = 0; ix < 13; ++ix) {
        for (Index iz = 0; iz < 9; ++iz) {
            const bool edge = ix == 0 || iz == 0 || ix == 12 || iz == 8;
            const double w = edge ? 0.0 : wanted((ix - 1) * 7 + (iz - 1));
            CHECK(deflection(ix, iz) == Approx(w).epsilon(1e-9).margin(1e-18));
        }
    }
    CHECK(plate.deflection_m(6, 4)(6, 4) == Approx(plate.centre_compliance_m_per_n()).epsilon(1e-12));
    CHECK((plate.deflection_m(0, 3) == 0.0).all());
}

struct OffCentre {
    double (*rigidity)(double, double);
    double poisson;
    double x, z;     ///< of the load
    double at_load;  ///< deflection there
    double probe_x, probe_z;
    double at_probe;
};

TEST_CASE("deflections under loads off the centre tend to the continuum's") {
    // Anchors of an independent code. Away from the load the error is h^2: Richardson. At the
    // load subtract h^2 ln(1/h)/(16 pi D) first.
    const std::vector<OffCentre> cases{
        {one, 0.2, 0.75, 0.5, 0.0032855433, 0.5, 0.5, 0.0024684514},
        {one, 0.2, 0.75, 0.75, 0.002283363, 0.5, 0.5, 0.001225881},
        {one, 0.2, 0.625, 0.625, 0.0045083411, 0.5, 0.5, 0.0036376382},
        {[](double x, double) { return 1.0 + x; }, 0.3, 0.5, 0.5, 0.00377153, 0.25, 0.5, 0.00182054},
        {[](double x, double) { return 4.0 / (1.0 + 3.0 * x); }, 0.2, 0.25, 0.5, 0.00134940, 0.5, 0.5,
         0.00119703},
        {gauss, 0.2, 0.5, 0.5, 0.00257143, 0.25, 0.5, 0.00146354}};
    for (const OffCentre& c : cases) {
        const auto deflections = [&](Index n) {
            Problem problem = unit_square(n, c.rigidity);
            problem.poisson = c.poisson;
            const auto node = [n](double x) {
                return static_cast<Index>(std::lround(x * static_cast<double>(n - 1)));
            };
            const Eigen::ArrayXXd w = Plate(problem).deflection_m(node(c.x), node(c.z));
            const double h = 1.0 / static_cast<double>(n - 1);
            const double singular = h * h * -std::log(h) / (16.0 * std::numbers::pi * c.rigidity(c.x, c.z));
            return Eigen::Array2d(w(node(c.x), node(c.z)) - singular, w(node(c.probe_x), node(c.probe_z)));
        };
        const Eigen::Array2d continuum = (4.0 * deflections(65) - deflections(33)) / 3.0;
        CAPTURE(c.x, c.z, c.at_load, c.at_probe);
        CHECK(continuum(0) == Approx(c.at_load).epsilon(5e-5));
        CHECK(continuum(1) == Approx(c.at_probe).epsilon(5e-5));
    }
}

TEST_CASE("the energy of a grid with unequal spacing is that of its bending") {
    // w = x^2 z near an inner node has w_xx = 2 z, w_zz = 0, w_xz = 2 x exactly, on any spacing: the row of K
    // must give the discrete form of D lap^2 w = 0 there.
    Problem problem = unit_square(11, one);
    problem.size_m = {1.0, 1.7};
    const Eigen::MatrixXd stiffness = Plate(problem).dense_stiffness_n_per_m();
    Eigen::VectorXd w(81);
    for (Index ix = 1; ix < 10; ++ix) {
        for (Index iz = 1; iz < 10; ++iz) {
            const double x = 0.1 * static_cast<double>(ix);
            const double z = 0.17 * static_cast<double>(iz);
            w((ix - 1) * 9 + (iz - 1)) = x * x * z * z * z;  // lap^2 = 2 * 6 * 2 z = 24 z
        }
    }
    const double force = (stiffness * w)(4 * 9 + 4);
    CHECK(force == Approx(24.0 * 0.85 * 0.1 * 0.17).epsilon(1e-9));
}

TEST_CASE("a foundation adds its pressure times the node's area, and nothing else") {
    Problem problem = unit_square(9, hyper10);
    problem.size_m = {0.04, 0.03};
    const Eigen::MatrixXd bare = Plate(problem).dense_stiffness_n_per_m();
    problem.foundation_n_per_m3 = sampled(9, [](double x, double z) { return 1e9 * (1.0 + x + 2.0 * z); });
    const Eigen::MatrixXd held = Plate(problem).dense_stiffness_n_per_m();
    const Eigen::MatrixXd pressure = problem.foundation_n_per_m3.block(1, 1, 7, 7).matrix().transpose();
    const Eigen::MatrixXd wanted = (pressure.reshaped() * (0.005 * 0.00375)).asDiagonal();
    CHECK((held - bare - wanted).cwiseAbs().maxCoeff() <= 1e-12 * held.maxCoeff());
}

TEST_CASE("deflections are reciprocal: here under a load there equals there under a load here") {
    const Plate plate(on_foundation(unit_square(33, wart), 4.0));
    CHECK(plate.deflection_m(5, 9)(20, 27) == Approx(plate.deflection_m(20, 27)(5, 9)).epsilon(1e-10));
    CHECK(plate.deflection_m(1, 1)(16, 16) == Approx(plate.deflection_m(16, 16)(1, 1)).epsilon(1e-10));
}

/// Fields on which central differences of the paper's equation give negative compliances.
std::vector<Eigen::ArrayXXd> nasty_fields(Index n) {
    std::vector<Eigen::ArrayXXd> all;
    for (const double value : {0.5, 0.2, 5.0, 2.0, 1e-6}) {
        all.push_back(sampled(n, [&](double x, double z) { return x == 0.5 && z == 0.5 ? value : 1.0; }));
    }
    for (const double ratio : {3.0, 1e3, 1e-3, 1e6, 1e15}) {
        all.push_back(sampled(n, [&](double x, double) { return x > 0.4 ? ratio : 1.0; }));
    }
    for (const double ratio : {2.0, 0.2}) {
        all.push_back(sampled(
            n, [&](double x, double z) { return std::hypot(x - 0.5, z - 0.5) < 0.15 ? ratio : 1.0; }));
    }
    Random random(20260101);
    for (const double span : {2.0, 1e3, 1e6}) {
        all.push_back(sampled(n, [&](double, double) { return std::pow(span, random.next()); }));
        all.push_back(sampled(n, [&](double, double) { return random.next() < 0.5 ? 1.0 : span; }));
    }
    return all;
}

TEST_CASE("every positive rigidity gives a symmetric positive definite plate") {
    const double poisson = GENERATE(as<double>{}, -0.99, 0.0, 0.2, 0.4999);
    for (const Index n : {Index{9}, Index{17}}) {
        std::size_t number = 0;
        for (const Eigen::ArrayXXd& field : nasty_fields(n)) {
            CAPTURE(poisson, n, number++);
            Problem problem = unit_square(n, one);
            problem.rigidity_n_m = field;
            problem.poisson = poisson;
            const Plate plate(problem);
            const Eigen::MatrixXd stiffness = plate.dense_stiffness_n_per_m();
            CHECK((stiffness - stiffness.transpose()).cwiseAbs().maxCoeff() == 0.0);
            const Eigen::LLT<Eigen::MatrixXd> dense(stiffness);
            REQUIRE(dense.info() == Eigen::Success);
            const Eigen::MatrixXd half =
                dense.matrixL().solve(Eigen::MatrixXd::Identity(stiffness.rows(), stiffness.cols()));
            CHECK(half.colwise().squaredNorm().minCoeff() > 0.0);
            CHECK(plate.centre_compliance_m_per_n() ==
                  Approx(half.col(stiffness.cols() / 2).squaredNorm()).epsilon(1e-6));
        }
    }
}

TEST_CASE("a stiffer plate never gives way more") {
    const double base = Plate(unit_square(17, hyper10)).centre_compliance_m_per_n();
    for (Index node = 0; node < 17 * 17; node += 5) {
        Problem problem = unit_square(17, hyper10);
        problem.rigidity_n_m(node / 17, node % 17) *= 3.0;
        CHECK(Plate(problem).centre_compliance_m_per_n() <= base * (1.0 + 1e-12));
    }
}

TEST_CASE("compliance scales with side^2/D over any units") {
    const double wanted = Plate(on_foundation(unit_square(33, hyper10), 6.0)).centre_compliance_m_per_n();
    for (const double scale : {1e-12, 1.0, 1e12}) {
        for (const double side : {1e-3, 0.04, 100.0}) {
            Problem problem = on_foundation(unit_square(33, hyper10), 6.0);
            problem.size_m = {side, side};
            problem.rigidity_n_m *= scale;
            problem.foundation_n_per_m3 *= scale / std::pow(side, 4);
            const double compliance = Plate(problem).centre_compliance_m_per_n() * scale / side / side;
            CHECK(compliance == Approx(wanted).epsilon(1e-9));
        }
    }
}

TEST_CASE("a strip in surroundings 1e-6 as stiff bends like a cantilever") {
    // Nodes that carry the strip own a cell each: m rows are m h wide. nu = 0, as the clamped end cannot
    // curl. The strip, clamped at x = 0, ends half a spacing beyond its last node; a line load on that node's
    // row.
    constexpr Index N = 33;
    constexpr Index ROWS = 9;
    constexpr Index TIP = 24;
    constexpr double H = 1.0 / 32.0;
    Problem problem = unit_square(N, one);
    problem.poisson = 0.0;
    problem.rigidity_n_m.setConstant(1e-6);
    problem.rigidity_n_m.block(0, 16 - ROWS / 2, TIP + 1, ROWS).setConstant(1.0);
    const Plate plate(problem);
    double tip = 0.0;
    for (Index row = 16 - ROWS / 2; row <= 16 + ROWS / 2; ++row) {
        tip += plate.deflection_m(TIP, row)(TIP, 16) / static_cast<double>(ROWS);
    }
    const double length = static_cast<double>(TIP) * H;
    const double wanted = length * length * length / (3.0 * static_cast<double>(ROWS) * H);
    CHECK(tip / wanted == Approx(1.0012).margin(2e-3));
}

}  // namespace
}  // namespace palpate::plate
