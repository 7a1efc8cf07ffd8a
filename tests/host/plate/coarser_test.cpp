#include "host/plate/coarser.hpp"

#include <catch2/catch.hpp>

#include "tests/host/plate/fields.hpp"

namespace palpate::plate {
namespace {

using Catch::Matchers::Contains;
using Eigen::ArrayXXd;
using Eigen::Index;

double quintic(double x, double z) {
    return 1.0 + x * x * x * x * x - 2.0 * x * x * z * z * z + z * z * z * z * z;
}

TEST_CASE("every second node has what the field has there") {
    Problem fine = fields::on_foundation(fields::unit_square(17, quintic), 2.0);
    fine.solid = Mask::Constant(17, 17, true);
    fine.solid(6, 8) = false;
    fine.lines_x_m = Eigen::ArrayXd::LinSpaced(17, 0.0, 1.0).square();
    const Problem coarse = every_second_node(fine);
    CHECK((coarse.rigidity_n_m == fields::sampled(9, quintic)).all());
    CHECK(coarse.foundation_n_per_m3.rows() == 9);
    CHECK(coarse.poisson_at_nodes.size() == 0);
    CHECK_FALSE(coarse.solid(3, 4));
    CHECK(coarse.solid.count() == 80);
    CHECK(coarse.lines_x_m(4) == 0.25);
    CHECK(coarse.lines_z_m.size() == 0);
}

TEST_CASE("three quarters of the nodes have a quintic as it is, and smooth fields to sixth order") {
    CHECK((three_quarters(fields::sampled(9, quintic)) - fields::sampled(7, quintic)).abs().maxCoeff() <
          1e-14);
    const auto error = [](Index n) {
        const ArrayXXd got = three_quarters(fields::sampled(n, fields::gauss));
        return (got - fields::sampled(got.rows(), fields::gauss)).abs().maxCoeff();
    };
    CHECK(error(65) < 2e-5);
    CHECK(error(65) > 40.0 * error(129));
}

TEST_CASE("three quarters of a plate keep its lines, and a foundation that ends does not pull") {
    Problem fine = fields::on_foundation(fields::unit_square(17, fields::hyper10), 2.0);
    fine.foundation_n_per_m3.topRows(8).setZero();
    fine.lines_x_m = Eigen::ArrayXd::LinSpaced(17, 0.0, 1.0).square();
    const Problem coarse = three_quarters(fine);
    CHECK(coarse.rigidity_n_m.rows() == 13);
    CHECK(coarse.lines_x_m(6) == Approx(0.25));
    CHECK(coarse.foundation_n_per_m3.minCoeff() == 0.0);
    CHECK_FALSE(problem_with(coarse));
}

TEST_CASE("plates that have no three quarters are refused in words") {
    CHECK_THROWS_WITH(three_quarters(fields::unit_square(19, fields::one)), Contains("19 nodes"));
    CHECK_THROWS_WITH(three_quarters(fields::unit_square(5, fields::one)), Contains("at least 9"));
    Problem holes = fields::unit_square(17, fields::one);
    holes.solid = Mask::Constant(17, 17, true);
    CHECK_THROWS_WITH(three_quarters(holes), Contains("holes"));
}

TEST_CASE("a factor of more than 2 between neighbours is a jump, along either side") {
    ArrayXXd field = ArrayXXd::Ones(5, 5);
    CHECK_FALSE(has_jump(field));
    CHECK_FALSE(has_jump(ArrayXXd()));
    CHECK_FALSE(has_jump(ArrayXXd::Zero(5, 5)));
    field.row(3).setConstant(2.0);
    CHECK_FALSE(has_jump(field));
    field.row(3).setConstant(2.1);
    CHECK(has_jump(field));
    CHECK(has_jump(field.transpose()));
}

}  // namespace
}  // namespace palpate::plate
