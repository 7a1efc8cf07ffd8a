/// Who is near whom: a k-d tree for places, a graph for neighbours along the surface.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "host/cloud/cloud.hpp"

namespace palpate::cloud {

/// k-d tree over a cloud's points (nanoflann). The cloud must outlive it and keep its points. Results are
/// sorted by distance, then index, so that they do not depend on the tree.
class Tree {
public:
    explicit Tree(const std::vector<Eigen::Vector3d>& points_m);
    ~Tree();
    Tree(Tree&&) noexcept;
    [[nodiscard]] Index nearest(const Eigen::Vector3d& at_m) const;
    [[nodiscard]] std::vector<Index> nearest(const Eigen::Vector3d& at_m, std::size_t n) const;
    [[nodiscard]] std::vector<Index> within(const Eigen::Vector3d& at_m, double radius_m) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Outward unit normals for every point: from the faces where the cloud has them (area-weighted), otherwise
/// from the plane through the nearest points, made consistent along a minimum spanning tree of the neighbour
/// graph. Each connected part starts at its point farthest along z, whose normal points to +z; where that
/// point lies on a rim, at the one of its outermost points along +-x, +-y, +-z whose normal is best along
/// that axis. Faces are believed: a file whose faces wind inwards gets inward normals. Without faces, a wall
/// must be thicker than the spacing of its points. O(n log n).
void orient(Cloud& cloud, const Tree& tree);

/// Median distance of a point to its nearest neighbour, m.
[[nodiscard]] double median_spacing_m(const Cloud& cloud, const Tree& tree);

/// A point of a region and how far it is along the surface.
struct Reached {
    Index point;
    double distance_m;
};

/// Neighbours along the surface: an edge joins k-nearest points whose normals differ by less than 75 degrees,
/// so the other wall of a thin object is never a neighbour.
class Graph {
public:
    /// `cloud` needs normals. Symmetric graph of the `k` nearest. O(n k log n).
    Graph(const Cloud& cloud, const Tree& tree, std::size_t k = 10);
    [[nodiscard]] std::span<const Index> neighbours(Index point) const;
    /// All points within `radius_m` of `seed` along the graph's edges, whose normals also stay within 75
    /// degrees of the seed's when `same_side`; by distance, then index. O(m log m) in the size of the answer.
    [[nodiscard]] std::vector<Reached> grow(Index seed, double radius_m, bool same_side) const;

private:
    const Cloud* cloud_;
    std::vector<std::size_t> begin_;
    std::vector<Index> neighbour_;
};

}  // namespace palpate::cloud
