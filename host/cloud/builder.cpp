#include "host/cloud/builder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace palpate::cloud {
namespace {

constexpr double COORDINATE_MAX =
    1.0e12;  ///< squares and areas stay far from overflow; no scan is larger in any unit
constexpr std::size_t POINTS_MIN = 3;

/// For each point the place in the result of the first point equal to it; `kept` receives those in the file's
/// order.
std::vector<Index> merge_map(const std::vector<Eigen::Vector3d>& points_m,
                             std::vector<Eigen::Vector3d>& kept) {
    const std::size_t n = points_m.size();
    std::vector<Index> order(n);
    for (std::size_t i = 0; i < n; ++i) order[i] = static_cast<Index>(i);
    const auto key = [&points_m](Index i) {
        const Eigen::Vector3d& p_m = points_m[i];
        return std::make_tuple(p_m.x(), p_m.y(), p_m.z(), i);
    };
    std::sort(order.begin(), order.end(), [&key](Index a, Index b) { return key(a) < key(b); });
    std::vector<Index> first(n);
    for (std::size_t i = 0; i < n; ++i) {
        const bool repeats = i > 0 && points_m[order[i]] == points_m[order[i - 1]];
        first[order[i]] = repeats ? first[order[i - 1]] : order[i];
    }
    std::vector<Index> map(n);
    for (std::size_t i = 0; i < n; ++i) {
        if (first[i] == i) {
            map[i] = static_cast<Index>(kept.size());
            kept.push_back(points_m[i]);
        } else {
            map[i] = map[first[i]];
        }
    }
    return map;
}

}  // namespace

void Builder::add_point(const std::array<double, 3>& xyz, const Place& place) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string coordinate(1, "xyz"[axis]);
        if (!std::isfinite(xyz[axis]))
            place.fail(coordinate + " of the vertex is not finite (" + std::to_string(xyz[axis]) +
                       "); every coordinate must be a finite number");
        if (!(std::fabs(xyz[axis]) <= COORDINATE_MAX))
            place.fail(coordinate + " of the vertex is beyond 1e12; no scan is that large in any unit");
    }
    if (points_m_.size() == std::numeric_limits<Index>::max())
        place.fail("more vertices than 4294967294; split the scan");
    points_m_.emplace_back(xyz[0], xyz[1], xyz[2]);
}

void Builder::add_polygon(const std::vector<Index>& corners, const Place& place) {
    if (corners.size() < 3)
        place.fail("a face with " + std::to_string(corners.size()) + " corners; a face needs at least 3");
    for (std::size_t i = 2; i < corners.size(); ++i)
        triangles_.push_back({corners[0], corners[i - 1], corners[i]});
}

Cloud Builder::finish(const Place& place) {
    Cloud cloud;
    const std::vector<Index> map = merge_map(points_m_, cloud.points_m);
    const std::size_t n_distinct = cloud.points_m.size();
    cloud.n_duplicates = points_m_.size() - n_distinct;
    if (n_distinct < POINTS_MIN) {
        const std::string repeats =
            cloud.n_duplicates > 0 ? " (and " + std::to_string(cloud.n_duplicates) + " repeats of them)" : "";
        place.fail("only " + std::to_string(n_distinct) + (n_distinct == 1 ? " point" : " points") + repeats +
                   "; a surface needs at least " + std::to_string(POINTS_MIN));
    }
    for (const std::array<Index, 3>& t : triangles_) {
        const std::array<Index, 3> moved{map[t[0]], map[t[1]], map[t[2]]};
        if (moved[0] == moved[1] || moved[1] == moved[2] || moved[2] == moved[0]) continue;
        cloud.triangles.push_back(moved);
    }
    points_m_ = {};
    triangles_ = {};
    return cloud;
}

}  // namespace palpate::cloud
