#include "host/cloud/outer_side.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>

namespace palpate::cloud {
namespace {

using Eigen::Vector3d;

constexpr double REACH_IN_SPACINGS = 3.0;
constexpr double COS_120_DEGREES = -0.5;
constexpr std::size_t N_NEIGHBOURS = 20;  // half of them may be on the other wall
constexpr Index NONE = std::numeric_limits<Index>::max();

/// Median distance of a point to its nearest neighbour on its own wall: median_spacing_m() of two thin walls
/// is their thickness. 0 without any neighbours.
double spacing_along_m(const Cloud& cloud, const Graph& graph) {
    std::vector<double> nearest_m;
    for (std::size_t i = 0; i < cloud.points_m.size(); ++i) {
        double least_m = std::numeric_limits<double>::infinity();
        for (const Index to : graph.neighbours(static_cast<Index>(i)))
            least_m = std::min(least_m, (cloud.points_m[to] - cloud.points_m[i]).norm());
        if (std::isfinite(least_m)) nearest_m.push_back(least_m);
    }
    if (nearest_m.empty()) return 0.0;
    const auto middle = nearest_m.begin() + static_cast<std::ptrdiff_t>(nearest_m.size() / 2);
    std::nth_element(nearest_m.begin(), middle, nearest_m.end());
    return *middle;
}

/// The point next to `from_m`: the nearest, or a point just by it that faces away from it, if that is
/// nearer along the normal. Across a wall that is thinner than the spacing the nearest point may be on the
/// other side.
Index touched(const Cloud& cloud, const Tree& tree, const Vector3d& from_m, double spacing_m) {
    const Index nearest = tree.nearest(from_m);
    const Vector3d& normal = cloud.normals[nearest];
    const auto away_m = [&](Index point) { return std::abs((from_m - cloud.points_m[point]).dot(normal)); };
    Index found = nearest;
    for (const Index point : tree.within(cloud.points_m[nearest], 1.5 * spacing_m)) {
        if (cloud.normals[point].dot(normal) < COS_120_DEGREES && away_m(point) < away_m(found))
            found = point;
    }
    return found;
}

/// Where the front starts: the flattest place that is joined with `touched` within reach and does not face
/// away from it. A front that started on a rim would go down both walls at once, and each would stop the
/// other.
Index start_at(const Cloud& cloud, const Graph& graph, Index touched, double reach_m) {
    Index start = touched;
    double flattest = -2.0;
    for (const auto& [point, distance_m] : graph.grow(touched, reach_m, false)) {
        if (cloud.normals[point].dot(cloud.normals[touched]) < COS_120_DEGREES) continue;
        double flat = 0.0;
        for (const Index to : graph.neighbours(point)) flat += cloud.normals[point].dot(cloud.normals[to]);
        flat /= static_cast<double>(graph.neighbours(point).size());  // NaN for none
        if (!(flat > flattest)) continue;
        flattest = flat;
        start = point;
    }
    return start;
}

class Front {
public:
    Front(const Cloud& cloud, const Tree& tree, const Graph& graph, double reach_m)
        : cloud_(cloud), tree_(tree), graph_(graph), reach_m_(reach_m), side_(cloud.points_m.size()) {}

    /// Prim's order: always the step over which the normal turns least, so that a wall is covered before its
    /// rim is crossed. By distance the back would be first round a bend whose inside it is. Equal steps in
    /// the order of the points, so that the answer is one.
    void grow(Index start) {
        using Step = std::tuple<double, Index>;  // turn, to
        std::priority_queue<Step, std::vector<Step>, std::greater<>> open;
        open.emplace(0.0, start);
        while (!open.empty()) {
            const Index from = std::get<Index>(open.top());
            open.pop();
            if (side_[from] != Side::unknown) continue;
            side_[from] = is_back(from) ? Side::back : Side::front;
            if (side_[from] == Side::back) continue;
            for (const Index to : graph_.neighbours(from)) {
                if (side_[to] == Side::unknown)
                    open.emplace(1.0 - cloud_.normals[from].dot(cloud_.normals[to]), to);
            }
        }
    }

    [[nodiscard]] std::vector<Index> kept() const {
        std::vector<Index> points;
        for (std::size_t i = 0; i < side_.size(); ++i) {
            const auto point = static_cast<Index>(i);
            if (side_[i] == Side::front || (side_[i] == Side::unknown && !is_back(point)))
                points.push_back(point);
        }
        return points;
    }

private:
    enum class Side : unsigned char { unknown, front, back };

    [[nodiscard]] bool is_back(Index point) const {
        const Vector3d &at_m = cloud_.points_m[point], &normal = cloud_.normals[point];
        for (const Index other : tree_.within(at_m, reach_m_)) {
            if (side_[other] != Side::front) continue;
            const Vector3d &facing = cloud_.normals[other], way_m = cloud_.points_m[other] - at_m;
            if (normal.dot(facing) < COS_120_DEGREES && way_m.dot(normal) < 0.0 && way_m.dot(facing) > 0.0)
                return true;
        }
        return false;
    }

    const Cloud& cloud_;
    const Tree& tree_;
    const Graph& graph_;
    double reach_m_;
    std::vector<Side> side_;
};

}  // namespace

std::vector<Index> outer_side(const Cloud& cloud, const Tree& tree, const Vector3d& from_m) {
    const Graph graph(cloud, tree, N_NEIGHBOURS);
    const double spacing_m = spacing_along_m(cloud, graph), reach_m = REACH_IN_SPACINGS * spacing_m;
    Front front(cloud, tree, graph, reach_m);
    front.grow(start_at(cloud, graph, touched(cloud, tree, from_m, spacing_m), reach_m));
    return front.kept();
}

Cloud subset(const Cloud& cloud, std::span<const Index> points) {
    Cloud part;
    part.n_duplicates = cloud.n_duplicates;
    std::vector<Index> now(cloud.points_m.size(), NONE);
    for (const Index point : points) {
        now[point] = static_cast<Index>(part.points_m.size());
        part.points_m.push_back(cloud.points_m[point]);
        if (!cloud.normals.empty()) part.normals.push_back(cloud.normals[point]);
        if (!cloud.young_pa.empty()) part.young_pa.push_back(cloud.young_pa[point]);
    }
    for (const std::array<Index, 3>& t : cloud.triangles) {
        const std::array<Index, 3> corners{now[t[0]], now[t[1]], now[t[2]]};
        if (std::find(corners.begin(), corners.end(), NONE) == corners.end())
            part.triangles.push_back(corners);
    }
    return part;
}

}  // namespace palpate::cloud
