#include "tests/host/cloud/hull.hpp"

#include <Eigen/Geometry>
#include <set>
#include <utility>

namespace palpate::cloud::test {

std::vector<std::array<Index, 3>> convex_hull(const std::vector<Eigen::Vector3d>& points_m) {
    using Face = std::array<Index, 3>;
    const auto volume = [&points_m](const Face& f, Index top) {
        const Eigen::Vector3d& a_m = points_m[f[0]];
        return (points_m[f[1]] - a_m).cross(points_m[f[2]] - a_m).dot(points_m[top] - a_m);
    };
    std::vector<Face> hull{{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
    if (volume(hull[0], 3) > 0.0) {
        for (Face& face : hull) std::swap(face[1], face[2]);
    }
    for (Index next = 4; next < points_m.size(); ++next) {
        std::vector<Face> kept;
        std::set<std::pair<Index, Index>> seen_edges;  // of the faces that the new point sees
        for (const Face& face : hull) {
            if (volume(face, next) > 0.0) {
                for (std::size_t i = 0; i < 3; ++i) seen_edges.emplace(face[i], face[(i + 1) % 3]);
            } else {
                kept.push_back(face);
            }
        }
        for (const auto& [a, b] : seen_edges) {
            if (seen_edges.count({b, a}) == 0) kept.push_back({a, b, next});
        }
        hull = std::move(kept);
    }
    return hull;
}

}  // namespace palpate::cloud::test
