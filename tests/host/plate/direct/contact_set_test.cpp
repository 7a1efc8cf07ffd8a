#include "host/plate/contact_set.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "host/plate/uniform/closed_form.hpp"
#include "tests/host/plate/fields.hpp"

namespace palpate::plate {
namespace {

using Catch::Matchers::Contains;
using Eigen::ArrayXXd;
using Eigen::Index;

constexpr Index M = 17;

template <typename Field>
Problem square(Index n, Field field, double side_over_l) {
    const Problem bare = fields::unit_square(n, field);
    return side_over_l > 0.0 ? fields::on_foundation(bare, side_over_l) : bare;
}

template <typename Field>
ArrayXXd contacts(Index n, Field field, double side_over_l) {
    return contact_compliances_m_per_n(square(n, field, side_over_l), M, Kernel::best);
}

double worst(const ArrayXXd& got, const ArrayXXd& truth) {
    return (got / truth - 1.0).abs().maxCoeff();
}

struct Case {
    std::string name;
    double (*field)(double, double);
    double side_over_l;
};

std::vector<Case> cases() {
    std::vector<Case> all;
    for (const double side_over_l : {0.0, 8.0}) {
        all.push_back({"uniform", fields::one, side_over_l});
        all.push_back({"1 + 9 x", fields::linear10, side_over_l});
        all.push_back({"10/(1 + 9 x)", fields::hyper10, side_over_l});
        all.push_back({"gauss", fields::gauss, side_over_l});
        all.push_back({"wart", fields::wart, side_over_l});
    }
    return all;
}

ArrayXXd every_fourth(const ArrayXXd& contacts) {
    const auto fourth = Eigen::seqN(0, 5, 4);
    return contacts(fourth, fourth);
}

/// Every fourth of 17 x 17 contacts.
ArrayXXd closed_form(const UniformPlate& plate) {
    ArrayXXd m_per_n(5, 5);
    for (Index iz = 0; iz < 5; ++iz) {
        for (Index ix = 0; ix < 5; ++ix) {
            const Eigen::Array2d at(0.25 + 0.125 * static_cast<double>(ix),
                                    0.25 + 0.125 * static_cast<double>(iz));
            m_per_n(ix, iz) =
                UniformSolution(plate, {.at_m = at * plate.size_m.array()}).compliance().m_per_n;
        }
    }
    return m_per_n;
}

TEST_CASE("the contacts of 33 nodes are within 5e-4, those of 65 within 2e-5 of the continuum's") {
    // 129 nodes stand for the continuum: within 4e-7 of 257 nodes, and where D is uniform nearer still.
    for (const double foundation : {0.0, 4096.0}) {
        const ArrayXXd known = closed_form({.size_m = {1.0, 1.0}, .foundation_n_per_m3 = foundation});
        CHECK(worst(every_fourth(contacts(129, fields::one, foundation > 0.0 ? 8.0 : 0.0)), known) < 4e-8);
    }
    for (const Case& c : cases()) {
        INFO(c.name << ", a/l = " << c.side_over_l);
        const ArrayXXd truth = contacts(129, c.field, c.side_over_l);
        CHECK(worst(contacts(33, c.field, c.side_over_l), truth) <= 5e-4);
        CHECK(worst(contacts(65, c.field, c.side_over_l), truth) <= 2e-5);
    }
}

TEST_CASE("the contacts of uniform plates are those of the closed form, whatever the edges and proportions") {
    constexpr auto C = Edge::clamped, S = Edge::supported;
    constexpr std::array<std::array<Edge, 4>, 3> EDGES{{{C, C, C, C}, {S, S, S, S}, {C, S, S, C}}};
    const std::array<Edge, 4> edges = EDGES[GENERATE(as<std::size_t>{}, 0, 1, 2)];
    const double width = GENERATE(as<double>{}, 1.0, 0.7);
    for (const double foundation : {0.0, 4096.0}) {
        const UniformPlate plate{.size_m = {1.0, width}, .foundation_n_per_m3 = foundation, .edges = edges};
        const ArrayXXd truth = closed_form(plate);
        const auto error = [&](Index n) {
            Problem problem = square(n, fields::one, 0.0);
            problem.size_m = plate.size_m;
            problem.edges = edges;
            problem.foundation_n_per_m3 = ArrayXXd::Constant(n, n, foundation);
            return worst(every_fourth(contact_compliances_m_per_n(problem, M, Kernel::best)), truth);
        };
        const double e33 = error(33), e65 = error(65);
        INFO("1 x " << width << ", k_f = " << foundation);
        CHECK(e33 < 5e-5);
        CHECK(e65 < 2e-6);
        CHECK(e65 < e33 / 16.0);  // better than the order 4 of two grids
    }
}

TEST_CASE("contacts off the centre are those of the continuum") {
    // Computed apart from this code: loads at (.75, .5), (.75, .75) and (.625, .625).
    const ArrayXXd table = contacts(65, fields::one, 0.0);
    CHECK(table(8, 8) == Approx(0.005612024020).epsilon(1e-6));
    CHECK(table(16, 8) == Approx(0.0032855433).epsilon(1e-6));
    CHECK(table(16, 16) == Approx(0.002283363).epsilon(1e-6));
    CHECK(table(12, 12) == Approx(0.0045083411).epsilon(1e-6));
    CHECK(table(12, 4) == Approx(table(4, 12)).epsilon(1e-10));
}

TEST_CASE("a table of contacts takes one rigidity after another, and a jump on two grids alone") {
    const Problem problem = square(33, fields::gauss, 8.0);
    const auto step = [](double x, double) { return x > 0.4 ? 10.0 : 1.0; };
    const ArrayXXd jump = fields::sampled(33, step);
    ContactTable table(problem, M);
    const ArrayXXd smooth = table.compliances_m_per_n();
    CHECK(table.n_grids() == 3);

    table.set_rigidity(jump);
    CHECK(table.n_grids() == 2);
    const Problem jumping = square(33, step, 8.0);
    CHECK((table.compliances_m_per_n() == contact_compliances_m_per_n(jumping, M)).all());

    CHECK_THROWS_AS(table.set_rigidity(-jump), Guard);
    CHECK_THROWS_AS(table.compliances_m_per_n(), Guard);
    table.set_rigidity(problem.rigidity_n_m);
    CHECK(table.n_grids() == 3);
    CHECK((table.compliances_m_per_n() == smooth).all());
}

TEST_CASE("where three quarters of the nodes do not serve, two grids are right to 2e-3 from 33 nodes") {
    const ArrayXXd truth = contacts(129, fields::linear10, 0.0);
    Problem holes = square(33, fields::linear10, 0.0);
    holes.solid = Mask::Constant(33, 33, true);
    CHECK(ContactTable(holes, M).n_grids() == 2);
    CHECK(worst(contact_compliances_m_per_n(holes, M), truth) < 2e-3);

    Problem foundation = square(33, fields::linear10, 1.0);
    foundation.foundation_n_per_m3.row(0).setZero();
    CHECK(ContactTable(foundation, M).n_grids() == 2);
    Problem uneven = square(33, fields::linear10, 0.0);
    uneven.poisson_at_nodes = ArrayXXd::Constant(33, 33, 0.2);
    CHECK(ContactTable(uneven, M).n_grids() == 2);
    CHECK(ContactTable(square(25, fields::one, 0.0), 7).n_grids() == 2);
}

TEST_CASE("a rigidity that is noise within a factor of 2 gets a table") {
    fields::Random random(7);
    Problem problem = square(
        33, [&](double, double) { return 1.0 + random.next(); }, 8.0);
    ContactTable table(problem, M);
    const ArrayXXd m_per_n = table.compliances_m_per_n();
    const ArrayXXd mean = contacts(33, fields::one, 8.0);
    CHECK((m_per_n > 0.4 * mean).all());
    CHECK((m_per_n < 1.05 * mean).all());
}

TEST_CASE("contacts that do not fit the nodes are refused in words") {
    CHECK(contact_nodes(33, 17, 9).size() == 81);
    CHECK(contact_nodes(33, 17, 9).front().ix == 8);
    CHECK(contact_nodes(33, 17, 9).back().iz == 12);
    CHECK_THROWS_WITH(contact_nodes(33, 33, 6), Contains("6 contacts do not fit"));
    CHECK_THROWS_WITH(contact_nodes(19, 33, 9), Contains("a side of 19"));
    CHECK_THROWS_AS(contact_nodes(33, 33, 1), std::invalid_argument);
    CHECK_THROWS_WITH(ContactTable(square(33, fields::one, 0.0), 6), Contains("6 contacts do not fit"));
    CHECK_THROWS_WITH(ContactTable(square(21, fields::one, 0.0), 11), Contains("too few nodes on half"));
}

}  // namespace
}  // namespace palpate::plate
