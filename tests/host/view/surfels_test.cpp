#include "host/view/surfels.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/host/view/sheet.hpp"

using namespace palpate::view;

namespace {

/// 41 x 41 points 1 mm apart in the plane y = 0, facing up.
Body plane() {
    Body body;
    for (int i = 0; i < 41; ++i) {
        for (int j = 0; j < 41; ++j) {
            body.points_m.emplace_back(0.001F * static_cast<float>(i), 0.0F, 0.001F * static_cast<float>(j));
            body.normals.emplace_back(0, 1, 0);
            body.stiffness_n_per_m.push_back(500.0F);
        }
    }
    return body;
}

}  // namespace

TEST_CASE("a linear dip turns every normal by its slope") {
    const Body body = plane();
    std::vector<Moved> dip;
    for (std::uint32_t i = 0; i < body.points_m.size(); ++i)
        dip.push_back({i, {0, -0.2F * body.points_m[i].x(), 0}});
    Surfels surfels(body);
    surfels.bend(dip, 1.0F);
    // y = -0.2 x has the normal (0.2, 1, 0) / |...|.
    const Eigen::Vector3f expected = Eigen::Vector3f(0.2F, 1.0F, 0.0F).normalized();
    for (const Surfel& disc : surfels.discs()) {
        CHECK(disc.normal[0] == Approx(expected.x()).margin(1e-4));
        CHECK(disc.normal[1] == Approx(expected.y()).margin(1e-4));
        CHECK(disc.normal[2] == Approx(0.0).margin(1e-4));
    }
}

TEST_CASE("exaggeration moves the discs further and leaves the stated dip as it is") {
    Surfels surfels(plane());
    const std::vector<Moved> dip{{5, {0, -0.001F, 0}}};
    surfels.bend(dip, 3.0F);
    CHECK(surfels.discs()[5].at_m[1] == Approx(-0.003F));
    CHECK(surfels.discs()[5].dipped_m == Approx(0.001F));
}

TEST_CASE("the skin goes back when the tool leaves") {
    Surfels surfels(plane());
    const std::vector<Surfel> before(surfels.discs().begin(), surfels.discs().end());
    const std::vector<Moved> dip{{700, {0, -0.002F, 0}}, {701, {0, -0.001F, 0}}};
    surfels.bend(dip, 1.0F);
    CHECK(surfels.discs()[700].at_m[1] < -0.001F);
    CHECK_FALSE(surfels.left_behind().empty());
    surfels.bend({}, 1.0F);
    CHECK(surfels.left_behind().empty());
    for (std::size_t i = 0; i < before.size(); ++i) {
        CHECK(surfels.discs()[i].at_m == before[i].at_m);
        CHECK(surfels.discs()[i].normal == before[i].normal);
    }
}

TEST_CASE("moves of points that do not exist, and moves that are not numbers, are ignored") {
    Surfels surfels(plane());
    const std::vector<Moved> dip{{1u << 30, {0, -1, 0}},
                                 {3, {0, std::numeric_limits<float>::quiet_NaN(), 0}}};
    surfels.bend(dip, 1.0F);
    CHECK(surfels.discs()[3].at_m[1] == 0.0F);
}

TEST_CASE("a body whose arrays differ in length is refused") {
    Body body = plane();
    body.normals.pop_back();
    CHECK_THROWS_AS(Surfels(body), std::invalid_argument);
}

TEST_CASE("bodies of no point and of one point are no trouble") {
    CHECK(Surfels(Body{}).discs().empty());
    Body one;
    one.points_m.emplace_back(0, 0, 0);
    one.normals.emplace_back(0, 0, 0);  // no direction known
    one.stiffness_n_per_m.push_back(1);
    CHECK(Surfels(one).discs()[0].normal == std::array<float, 3>{0, 0, 1});
}

TEST_CASE("unknown stiffness has no place on the scale, equal stiffness the middle") {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<float> values{nan, 3.0F, std::numeric_limits<float>::infinity(), -1.0F};
    const auto range = finite_range(values);
    REQUIRE(range.has_value());
    CHECK(range->min == -1.0F);
    CHECK(range->max == 3.0F);
    CHECK(shade(*range, nan) == -1.0F);
    CHECK(shade(*range, 1.0F) == 0.5F);
    CHECK(shade(Range{2, 2}, 2) == 0.5F);
    CHECK(Range{1000, std::nextafter(1000.0F, 2000.0F)}.is_one_value());  // no labels of four digits differ
    CHECK(shade(Range{245.47F, 245.48F}, 245.47F) == 0.5F);
    CHECK_FALSE(Range{245.4F, 245.5F}.is_one_value());
    CHECK_FALSE(Range{0, 1e-20F}.is_one_value());
    CHECK_FALSE(finite_range(std::vector<float>{nan}).has_value());
}

TEST_CASE("viridis gets lighter from end to end") {
    const auto& table = viridis();
    const auto lightness = [](Rgb c) { return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b; };
    CHECK(table.front() == Rgb{0x44, 0x01, 0x54});
    CHECK(table.back() == Rgb{0xfd, 0xe7, 0x25});
    for (std::size_t i = 1; i < table.size(); ++i)
        CHECK(lightness(table[i]) >= lightness(table[i - 1]) - 0.8);
}
