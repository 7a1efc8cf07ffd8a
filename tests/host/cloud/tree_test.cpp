#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "host/cloud/neighbours.hpp"
#include "tests/host/cloud/samples.hpp"

namespace palpate::cloud {
namespace {

using Points = std::vector<Eigen::Vector3d>;

/// Every point by distance to `at_m`, then index.
std::vector<Index> by_force(const Points& points_m, const Eigen::Vector3d& at_m) {
    std::vector<std::pair<double, Index>> all;
    for (std::size_t i = 0; i < points_m.size(); ++i)
        all.emplace_back((points_m[i] - at_m).squaredNorm(), static_cast<Index>(i));
    std::sort(all.begin(), all.end());
    std::vector<Index> result;
    for (const auto& item : all) result.push_back(item.second);
    return result;
}

/// A grid of whole numbers, where most distances tie, or scattered points.
Points sample(bool on_grid) {
    Points points_m;
    test::Random random(1);
    for (int i = 0; i < 1000; ++i) {
        if (on_grid)
            points_m.emplace_back(i % 10, (i / 10) % 10, i / 100);
        else
            points_m.push_back(10.0 * random.uniform() * random.on_unit_sphere());
    }
    return points_m;
}

}  // namespace

TEST_CASE("the nearest points are those of a search through all of them, ties by index") {
    const bool on_grid = GENERATE(as<bool>{}, false, true);
    const Points points_m = sample(on_grid);
    const Tree tree(points_m);
    for (std::size_t i = 0; i < points_m.size(); i += 37) {
        const Eigen::Vector3d at_m = i % 2 == 0 ? points_m[i] : Eigen::Vector3d(points_m[i].array() + 0.5);
        const std::vector<Index> truth = by_force(points_m, at_m);
        REQUIRE(tree.nearest(at_m) == truth[0]);
        for (const std::size_t n : {1U, 7U, 27U, 1000U, 2000U}) {
            const std::vector<Index> expected(
                truth.begin(), truth.begin() + static_cast<std::ptrdiff_t>(std::min(n, truth.size())));
            REQUIRE(tree.nearest(at_m, n) == expected);
        }
    }
    CHECK(tree.nearest(points_m[0], 0).empty());
}

TEST_CASE("the points within a radius include those on its rim") {
    const Points points_m = sample(true);
    const Tree tree(points_m);
    const Eigen::Vector3d at_m(5, 5, 5);
    CHECK(tree.within(at_m, 1.0).size() == 7);
    CHECK(tree.within(at_m, 0.999).size() == 1);
    CHECK(tree.within(at_m, 0.0) == std::vector<Index>{555});
    CHECK(tree.within(at_m, -1.0).empty());
    CHECK(tree.within({50, 0, 0}, 1.0).empty());
    const std::vector<Index> truth = by_force(points_m, at_m);
    const std::vector<Index> inside = tree.within(at_m, 3.0);
    CHECK(inside ==
          std::vector<Index>(truth.begin(), truth.begin() + static_cast<std::ptrdiff_t>(inside.size())));
    CHECK(inside.size() == 123);  // whole-number points with i^2 + j^2 + k^2 <= 9
}

TEST_CASE("a place that is not finite is refused, as is a tree of nothing") {
    const Points points_m = sample(true);
    const Tree tree(points_m);
    const Eigen::Vector3d bad(0.0, std::numeric_limits<double>::quiet_NaN(), 0.0);
    CHECK_THROWS_AS(tree.nearest(bad), std::invalid_argument);
    CHECK_THROWS_AS(tree.nearest(bad, 3), std::invalid_argument);
    CHECK_THROWS_AS(tree.within(bad, 1.0), std::invalid_argument);
    CHECK_THROWS_AS(Tree(Points{}), std::invalid_argument);
}

TEST_CASE("the median spacing of a grid is its spacing") {
    Cloud cloud;
    cloud.points_m = sample(true);
    CHECK(median_spacing_m(cloud, Tree(cloud.points_m)) == 1.0);
    cloud.points_m.resize(1);
    CHECK(median_spacing_m(cloud, Tree(cloud.points_m)) == 0.0);
}

}  // namespace palpate::cloud
