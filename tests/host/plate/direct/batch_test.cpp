#include "host/plate/batch.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "host/plate/plate.hpp"
#include "tests/host/plate/counting_heap.hpp"
#include "tests/host/plate/fields.hpp"

namespace palpate::plate {
namespace {

using Eigen::ArrayXXd;
using Eigen::Index;

Problem lane_problem(Index nx, Index nz, std::size_t lane) {
    Problem problem;
    problem.size_m = {0.03, 0.04};
    problem.foundation_n_per_m3 = Eigen::ArrayXXd::Constant(nx, nz, 1e6);
    problem.rigidity_n_m.resize(nx, nz);
    fields::Random random(20260706 + lane);
    for (double& d : problem.rigidity_n_m.reshaped()) d = 1e-3 * (1.0 + 9.0 * random.next());
    return problem;
}

TEST_CASE("each plate of a batch gives way as it does alone") {
    for (const Kernel kernel : {Kernel::portable, Kernel::best}) {
        for (const auto& [nx, nz] : {std::pair<Index, Index>{5, 5}, {9, 17}, {33, 33}}) {
            Batch batch(lane_problem(nx, nz, 0), kernel);
            std::vector<double> compliances(batch.lanes());
            for (std::size_t lane = 0; lane < batch.lanes(); ++lane)
                batch.set_rigidity(lane, lane_problem(nx, nz, lane).rigidity_n_m);
            batch.centre_compliances_m_per_n(compliances);
            for (std::size_t lane = 0; lane < batch.lanes(); ++lane) {
                CAPTURE(nx, nz, lane, batch.kernel());
                const Plate alone(lane_problem(nx, nz, lane));
                CHECK(compliances[lane] == Approx(alone.centre_compliance_m_per_n()).epsilon(1e-11));
            }
        }
    }
}

/// Everything that a problem can have but jumps: three kinds of edges, uneven lines, a hole, Poisson's ratio
/// and a foundation that vary.
Problem motley_problem(Index n) {
    Problem problem = lane_problem(n, n, 99);
    problem.edges = {Edge::clamped, Edge::free, Edge::supported, Edge::free};
    problem.lines_x_m = problem.size_m.x() * Eigen::ArrayXd::LinSpaced(n, 0.0, 1.0).pow(1.3);
    problem.lines_z_m = problem.size_m.y() * Eigen::ArrayXd::LinSpaced(n, 0.0, 1.0).pow(0.8);
    problem.lines_x_m(n - 1) = problem.size_m.x();
    problem.lines_z_m(n - 1) = problem.size_m.y();
    problem.solid = Mask::Constant(n, n, true);
    problem.solid.block(2, 3, n / 4, n / 3).setConstant(false);
    problem.solid.block(n - 3, n - 4, 3, 4).setConstant(false);
    fields::Random random(7);
    const auto drawn = [&] { return random.next(); };
    problem.poisson_at_nodes = 0.1 + 0.3 * ArrayXXd::NullaryExpr(n, n, drawn);
    problem.foundation_n_per_m3 = 1e6 * ArrayXXd::NullaryExpr(n, n, drawn);
    return problem;
}

TEST_CASE("a batch knows every kind of edge, grid line, outline, Poisson's ratio and foundation") {
    const Kernel kernel = GENERATE(as<Kernel>{}, Kernel::portable, Kernel::best);
    const Index n = GENERATE(as<Index>{}, 9, 17);
    Problem problem = motley_problem(n);
    Batch batch(problem, kernel);
    std::vector<double> compliances(batch.lanes());
    for (std::size_t lane = 0; lane < batch.lanes(); ++lane)
        batch.set_rigidity(lane, lane_problem(n, n, lane).rigidity_n_m);
    batch.centre_compliances_m_per_n(compliances);
    for (std::size_t lane = 0; lane < batch.lanes(); ++lane) {
        CAPTURE(n, lane, batch.kernel());
        problem.rigidity_n_m = lane_problem(n, n, lane).rigidity_n_m;
        CHECK(compliances[lane] == Approx(Plate(problem).centre_compliance_m_per_n()).epsilon(1e-9));
    }
}

TEST_CASE("a batch allocates nothing once it is made") {
    const Kernel kernel = GENERATE(as<Kernel>{}, Kernel::portable, Kernel::best);
    const Problem problem = motley_problem(17);
    Batch batch(problem, kernel);
    std::vector<double> compliances(batch.lanes());
    const long before = n_allocations();
    for (std::size_t lane = 0; lane < batch.lanes(); ++lane) batch.set_rigidity(lane, problem.rigidity_n_m);
    batch.centre_compliances_m_per_n(compliances);
    CHECK(n_allocations() == before);
    CHECK(n_allocations() > 0);  // the counter counts
}

TEST_CASE("a bad plate of a batch has no number, and does its neighbours no harm") {
    const double bad = GENERATE(as<double>{}, -50.0, 0.0, std::numeric_limits<double>::quiet_NaN(),
                                std::numeric_limits<double>::infinity());
    const Kernel kernel = GENERATE(as<Kernel>{}, Kernel::portable, Kernel::best);
    const Problem good = fields::unit_square(17, fields::hyper10);
    Batch batch(good, kernel);
    std::vector<double> compliances(batch.lanes());
    for (std::size_t lane = 1; lane < batch.lanes(); ++lane) batch.set_rigidity(lane, good.rigidity_n_m);
    batch.centre_compliances_m_per_n(compliances);
    CHECK(std::isnan(compliances[0]));  // none was set
    Eigen::ArrayXXd rigidity = good.rigidity_n_m;
    rigidity(3, 11) = bad;
    batch.set_rigidity(0, rigidity);
    batch.centre_compliances_m_per_n(compliances);
    CHECK(std::isnan(compliances[0]));
    for (std::size_t lane = 1; lane < batch.lanes(); ++lane)
        CHECK(compliances[lane] == Approx(2.883232925e-3).epsilon(1e-9));
}

TEST_CASE("an island too stiff for double has no number in a batch, as it has no Plate") {
    const auto island = [](double ratio) {
        return fields::unit_square(
            33, [=](double x, double z) { return x > 0.3 && x < 0.7 && z > 0.3 && z < 0.7 ? ratio : 1.0; });
    };
    const Kernel kernel = GENERATE(as<Kernel>{}, Kernel::portable, Kernel::best);
    Batch batch(island(1.0), kernel);
    std::vector<double> compliances(batch.lanes());
    batch.set_rigidity(0, island(1e6).rigidity_n_m);
    batch.set_rigidity(1, island(1e9).rigidity_n_m);
    batch.centre_compliances_m_per_n(compliances);
    CHECK(compliances[0] == Approx(Plate(island(1e6)).centre_compliance_m_per_n()).epsilon(1e-6));
    CHECK(std::isnan(compliances[1]));
    for (const double ratio : {1e17, 1e20, 1e30}) {  // pivots below 0 by rounding
        batch.set_rigidity(1, island(ratio).rigidity_n_m);
        batch.centre_compliances_m_per_n(compliances);
        CHECK(std::isnan(compliances[1]));
    }
    batch.set_rigidity(1, island(1e6).rigidity_n_m);  // nothing of the failures is left
    batch.centre_compliances_m_per_n(compliances);
    CHECK(compliances[1] == Approx(compliances[0]).epsilon(1e-9));
}

}  // namespace
}  // namespace palpate::plate
