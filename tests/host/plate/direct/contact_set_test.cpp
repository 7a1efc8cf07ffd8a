#include "host/plate/contact_set.hpp"

#include <catch2/catch.hpp>
#include <functional>
#include <vector>

#include "tests/host/plate/fields.hpp"

namespace palpate::plate {
namespace {

using Catch::Matchers::Contains;
using Eigen::ArrayXXd;
using Eigen::Index;

constexpr Index M = 17;

template <typename Field>
ArrayXXd contacts(Index n, Field field, double side_over_l) {
    const auto on = [&](Index nodes) {
        const Problem bare = fields::unit_square(nodes, field);
        return side_over_l > 0.0 ? fields::on_foundation(bare, side_over_l) : bare;
    };
    return contact_compliances_m_per_n(on(n), Plate(on(n), Kernel::best),
                                       Plate(on((n + 1) / 2), Kernel::best), M);
}

double worst(const ArrayXXd& got, const ArrayXXd& truth) {
    return (got / truth - 1.0).abs().maxCoeff();
}

TEST_CASE("the contacts of two grids tend to those of finer grids, also where one grid has no node") {
    // 17 + 33 nodes share 9 x 9 of the contacts, 33 + 65 and 65 + 129 all.
    for (const auto& field : {fields::one, fields::hyper10, fields::gauss, fields::wart}) {
        const ArrayXXd truth = contacts(129, field, 0.0);
        CHECK(worst(contacts(33, field, 0.0), truth) < 5e-4);
        CHECK(worst(contacts(65, field, 0.0), truth) < 3e-5);
    }
    const ArrayXXd truth = contacts(129, fields::gauss, 8.0);
    CHECK(worst(contacts(33, fields::gauss, 8.0), truth) < 7e-4);
    CHECK(worst(contacts(65, fields::gauss, 8.0), truth) < 5e-5);
}

TEST_CASE("contacts off the centre are those of the continuum") {
    // PLATE section 9, numbers 3, 4 and 5: loads at (.75, .5), (.75, .75) and (.625, .625).
    const ArrayXXd table = contacts(65, fields::one, 0.0);
    CHECK(table(8, 8) == Approx(0.005612024020).epsilon(3e-5));
    CHECK(table(16, 8) == Approx(0.0032855433).epsilon(3e-5));
    CHECK(table(16, 16) == Approx(0.002283363).epsilon(3e-5));
    CHECK(table(12, 12) == Approx(0.0045083411).epsilon(3e-5));
    CHECK(table(12, 4) == Approx(table(4, 12)).epsilon(1e-10));
}

TEST_CASE("contacts that do not fit the nodes are refused in words") {
    CHECK(contact_nodes(33, 17, 9).size() == 81);
    CHECK(contact_nodes(33, 17, 9).front().ix == 8);
    CHECK(contact_nodes(33, 17, 9).back().iz == 12);
    CHECK_THROWS_WITH(contact_nodes(33, 33, 6), Contains("6 contacts do not fit"));
    CHECK_THROWS_WITH(contact_nodes(19, 33, 9), Contains("a side of 19"));
    CHECK_THROWS_AS(contact_nodes(33, 33, 1), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::plate
