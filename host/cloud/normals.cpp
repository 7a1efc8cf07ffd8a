#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <tuple>
#include <utility>

#include "host/cloud/neighbours.hpp"

namespace palpate::cloud {
namespace {

constexpr std::size_t N_PLANE =
    12;  ///< points a normal's plane is fitted to, and neighbours in the spanning tree
using Eigen::Vector3d;

/// Sum of the cross products of the faces around each point: twice the area times the normal.
std::vector<Vector3d> face_sums(const Cloud& cloud) {
    std::vector<Vector3d> sums(cloud.points_m.size(), Vector3d::Zero());
    for (const std::array<Index, 3>& t : cloud.triangles) {
        const Vector3d& a_m = cloud.points_m[t[0]];
        const Vector3d cross = (cloud.points_m[t[1]] - a_m).cross(cloud.points_m[t[2]] - a_m);
        for (const Index corner : t) sums[corner] += cross;
    }
    return sums;
}

/// Unit normals from the faces; a point in no face takes the normal of the nearest point in one. False when
/// no face has an area.
bool from_faces(Cloud& cloud) {
    std::vector<Vector3d> normals = face_sums(cloud);
    std::vector<Vector3d> known_m;
    std::vector<Index> known;
    for (std::size_t i = 0; i < normals.size(); ++i) {
        const double length = normals[i].norm();
        normals[i] = length > 0.0 ? Vector3d(normals[i] / length) : Vector3d::Zero();
        if (!(length > 0.0)) continue;
        known.push_back(static_cast<Index>(i));
        known_m.push_back(cloud.points_m[i]);
    }
    if (known.empty()) return false;
    if (known.size() < normals.size()) {
        const Tree known_tree(known_m);
        for (std::size_t i = 0; i < normals.size(); ++i) {
            if (normals[i].isZero(0.0)) normals[i] = normals[known[known_tree.nearest(cloud.points_m[i])]];
        }
    }
    cloud.normals = std::move(normals);
    return true;
}

/// Direction of least spread of the points `near`; its sign means nothing.
Vector3d plane_normal(const std::vector<Vector3d>& points_m, const std::vector<Index>& near) {
    Vector3d mean_m = Vector3d::Zero();
    for (const Index i : near) mean_m += points_m[i];
    mean_m /= static_cast<double>(near.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const Index i : near) spread += (points_m[i] - mean_m) * (points_m[i] - mean_m).transpose();
    // The iterative solver needs only sqrt; the direct one calls cos and atan2.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread);
    return eigen.eigenvectors().col(0);
}

/// `normal` at `from` seen in the mirror that swaps `from` and `to`. On a sphere, on a rim and across a thin
/// wall alike this is the normal at `to`, sign included (König and Gumhold 2009).
Vector3d carried(const Vector3d& normal, const Vector3d& from_m, const Vector3d& to_m) {
    const Vector3d step_m = to_m - from_m;
    const double length2 = step_m.squaredNorm();
    if (!(length2 > 0.0)) return normal;
    return normal - (2.0 * step_m.dot(normal) / length2) * step_m;
}

/// The points joined with `first`, in the order found; marks them in `seen`.
std::vector<Index> part_of(Index first, const std::vector<std::vector<Index>>& near,
                           std::vector<char>& seen) {
    std::vector<Index> part{first};
    seen[first] = 1;
    for (std::size_t i = 0; i < part.size(); ++i) {
        for (const Index to : near[part[i]]) {
            if (seen[to] == 0) part.push_back(to);
            seen[to] = 1;
        }
    }
    return part;
}

/// A point whose outward side is known: the outermost one of `part` along an axis, with its normal turned
/// outwards.
struct Start {
    Index point;
    Vector3d normal;
};

/// The highest point along z; where the surface is steep there (a rim, whose plane is a poor one), the one of
/// the six outermost points that faces its axis best.
Start start_of(const std::vector<Index>& part, const std::vector<Vector3d>& points_m,
               const std::vector<Vector3d>& normals) {
    constexpr double FACING_ENOUGH = 0.9;
    const std::array<Vector3d, 6> axes{Vector3d::UnitZ(),  Vector3d::UnitX(),  Vector3d::UnitY(),
                                       -Vector3d::UnitX(), -Vector3d::UnitY(), -Vector3d::UnitZ()};
    Start best{part.front(), normals[part.front()]};
    double best_facing = -1.0;
    for (const Vector3d& axis : axes) {
        const Index outermost = *std::min_element(part.begin(), part.end(), [&](Index a, Index b) {
            return std::make_pair(-points_m[a].dot(axis), a) < std::make_pair(-points_m[b].dot(axis), b);
        });
        const double facing = normals[outermost].dot(axis);
        if (!(std::fabs(facing) > best_facing)) continue;
        best_facing = std::fabs(facing);
        best = {outermost, facing < 0.0 ? Vector3d(-normals[outermost]) : normals[outermost]};
        if (best_facing > FACING_ENOUGH) break;
    }
    return best;
}

/// Flips `normals` so that neighbours agree, along a spanning tree that takes the surest step first (Prim),
/// for each connected part by itself.
class Propagation {
public:
    Propagation(const std::vector<Vector3d>& points_m, const std::vector<std::vector<Index>>& near,
                std::vector<Vector3d>& normals)
        : points_m_(points_m), near_(near), normals_(normals), done_(points_m.size(), 0) {}

    void run() {
        std::vector<char> seen(points_m_.size(), 0);
        for (std::size_t i = 0; i < points_m_.size(); ++i) {
            if (seen[i] != 0) continue;
            const Start start = start_of(part_of(static_cast<Index>(i), near_, seen), points_m_, normals_);
            normals_[start.point] = start.normal;
            settle(start.point);
            spread();
        }
    }

private:
    void spread() {
        while (!open_.empty()) {
            const auto [doubt, to, from] = open_.top();
            open_.pop();
            if (done_[to] != 0) continue;
            if (carried(normals_[from], points_m_[from], points_m_[to]).dot(normals_[to]) < 0.0)
                normals_[to] = -normals_[to];
            settle(to);
        }
    }

    void settle(Index from) {
        done_[from] = 1;
        for (const Index to : near_[from]) {
            if (done_[to] != 0) continue;
            const double agreement =
                carried(normals_[from], points_m_[from], points_m_[to]).dot(normals_[to]);
            open_.emplace(1.0 - std::fabs(agreement), to, from);
        }
    }

    using Step = std::tuple<double, Index, Index>;  // doubt, to, from
    const std::vector<Vector3d>& points_m_;
    const std::vector<std::vector<Index>>& near_;
    std::vector<Vector3d>& normals_;
    std::vector<char> done_;
    std::priority_queue<Step, std::vector<Step>, std::greater<>> open_;
};

void from_planes(Cloud& cloud, const Tree& tree) {
    const std::size_t n = cloud.points_m.size();
    std::vector<std::vector<Index>> near(n);
    std::vector<Vector3d> normals(n);
    for (std::size_t i = 0; i < n; ++i) {
        near[i] = tree.nearest(cloud.points_m[i], N_PLANE + 1);
        normals[i] = plane_normal(cloud.points_m, near[i]);
    }
    const std::size_t n_own = std::min(N_PLANE + 1, n);
    for (std::size_t i = 0; i < n; ++i) {  // a step that one end knows of is open to both
        for (std::size_t j = 0; j < n_own; ++j) near[near[i][j]].push_back(static_cast<Index>(i));
    }
    Propagation(cloud.points_m, near, normals).run();
    cloud.normals = std::move(normals);
}

}  // namespace

void orient(Cloud& cloud, const Tree& tree) {
    if (!from_faces(cloud)) from_planes(cloud, tree);
}

}  // namespace palpate::cloud
