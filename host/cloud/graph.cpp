#include <algorithm>
#include <limits>
#include <queue>
#include <stdexcept>
#include <utility>

#include "host/cloud/neighbours.hpp"

namespace palpate::cloud {
namespace {

constexpr double COS_75_DEGREES = 0.25881904510252074;

using Edge = std::pair<Index, Index>;

/// Every edge in both directions, sorted, once.
std::vector<Edge> edges(const Cloud& cloud, const Tree& tree, std::size_t k) {
    std::vector<Edge> result;
    result.reserve(cloud.points_m.size() * 2 * k);
    for (std::size_t i = 0; i < cloud.points_m.size(); ++i) {
        const Index from = static_cast<Index>(i);
        std::size_t n_near = 0;
        for (const Index to : tree.nearest(cloud.points_m[i], k + 1)) {
            if (to == from || n_near == k) continue;
            ++n_near;
            if (!(cloud.normals[from].dot(cloud.normals[to]) > COS_75_DEGREES)) continue;
            result.emplace_back(from, to);
            result.emplace_back(to, from);
        }
    }
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
}

/// Distance per point for the points met so far, in an open-addressed table: a std::map made grow() 2.3 times
/// slower, and an array over all points would make a small region cost as much as the scan. Never iterated,
/// so that its order cannot matter.
class Labels {
public:
    Labels() : slots_(std::size_t{1} << bits_, FREE) {}
    /// The distance kept for `point`; infinite when it is met for the first time. Valid until the next call.
    double& operator[](Index point) {
        if (2 * n_used_ >= slots_.size()) widen();
        Slot& slot = place(point);
        if (slot.point == FREE.point) {
            ++n_used_;
            slot.point = point;
        }
        return slot.distance_m;
    }

private:
    struct Slot {
        Index point;
        double distance_m;
    };
    static constexpr Slot FREE{std::numeric_limits<Index>::max(), std::numeric_limits<double>::infinity()};

    /// Every bit of the place depends on every bit of the index (the finaliser of MurmurHash3, A. Appleby).
    /// A product by the golden ratio alone put neighbours on a Fibonacci lattice, whose indices differ by
    /// Fibonacci numbers, all into one place: the ellipsoid's run took more than twice as long.
    static Index mixed(Index h) {
        h = (h ^ h >> 16U) * 0x85EBCA6BU;
        h = (h ^ h >> 13U) * 0xC2B2AE35U;
        return h ^ h >> 16U;
    }
    Slot& place(Index point) {
        std::size_t at = mixed(point) >> (32U - bits_);
        while (slots_[at].point != point && slots_[at].point != FREE.point)
            at = (at + 1) & (slots_.size() - 1);
        return slots_[at];
    }
    void widen() {
        const std::vector<Slot> old = std::move(slots_);
        ++bits_;
        slots_.assign(std::size_t{1} << bits_, FREE);
        for (const Slot& slot : old) {
            if (slot.point != FREE.point) place(slot.point) = slot;
        }
    }

    unsigned bits_ = 9;
    std::size_t n_used_ = 0;
    std::vector<Slot> slots_;
};

}  // namespace

Graph::Graph(const Cloud& cloud, const Tree& tree, std::size_t k) : cloud_(&cloud) {
    if (cloud.normals.size() != cloud.points_m.size())
        throw std::invalid_argument("Graph: the cloud has no normals; call orient() first");
    const std::vector<Edge> all = edges(cloud, tree, k);
    begin_.assign(cloud.points_m.size() + 1, 0);
    neighbour_.reserve(all.size());
    for (const Edge& edge : all) {
        ++begin_[edge.first + std::size_t{1}];
        neighbour_.push_back(edge.second);
    }
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
}

std::span<const Index> Graph::neighbours(Index point) const {
    return std::span(neighbour_).subspan(begin_[point], begin_[point + std::size_t{1}] - begin_[point]);
}

// Dijkstra. A point's distance is the least sum of rounded edge lengths over all paths, so it does not depend
// on the order in which equal distances are taken.
std::vector<Reached> Graph::grow(Index seed, double radius_m, bool same_side) const {
    using Item = std::pair<double, Index>;
    std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
    std::vector<Reached> result;
    if (!(radius_m >= 0.0)) return result;
    Labels best_m;
    open.emplace(0.0, seed);
    best_m[seed] = 0.0;
    while (!open.empty()) {
        const auto [distance_m, from] = open.top();
        open.pop();
        if (distance_m > best_m[from]) continue;
        result.push_back({from, distance_m});
        for (const Index to : neighbours(from)) {
            if (same_side && !(cloud_->normals[seed].dot(cloud_->normals[to]) > COS_75_DEGREES)) continue;
            const double next_m = distance_m + (cloud_->points_m[to] - cloud_->points_m[from]).norm();
            if (next_m > radius_m) continue;
            double& known_m = best_m[to];
            if (!(next_m < known_m)) continue;
            known_m = next_m;
            open.emplace(next_m, to);
        }
    }
    std::sort(result.begin(), result.end(), [](const Reached& a, const Reached& b) {
        return std::pair(a.distance_m, a.point) < std::pair(b.distance_m, b.point);
    });
    return result;
}

}  // namespace palpate::cloud
