/// Faces for the tests: the convex hull of points on a sphere.
#pragma once
#include <array>
#include <vector>

#include "host/cloud/cloud.hpp"

namespace palpate::cloud::test {

/// Triangles with outward winding, by adding one point after the other. Points in general position; O(n^2).
[[nodiscard]] std::vector<std::array<Index, 3>> convex_hull(const std::vector<Eigen::Vector3d>& points_m);

}  // namespace palpate::cloud::test
