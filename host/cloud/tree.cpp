#include <algorithm>
#include <limits>
#include <nanoflann.hpp>
#include <stdexcept>
#include <utility>

#include "host/cloud/neighbours.hpp"

namespace palpate::cloud {
namespace {

using Points = std::vector<Eigen::Vector3d>;
using Found = std::pair<double, Index>;  // squared distance, point: their order is the order of the answers

// nanoflann prunes by distances to boxes that it sums up in another order than the distance to a point. The
// slack keeps rounding from cutting off a point that ties with the last one kept.
constexpr double PRUNE_SLACK = 1.0 + 1.0e-12;

struct Adaptor {
    const Points* points_m;
    [[nodiscard]] std::size_t kdtree_get_point_count() const { return points_m->size(); }
    [[nodiscard]] double kdtree_get_pt(Index point, std::size_t axis) const {
        return (*points_m)[point][static_cast<Eigen::Index>(axis)];
    }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
        return false;
    }
};

using Kd = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Adaptor, double, Index>,
                                               Adaptor, 3, Index>;

/// The n best by distance, then index, whatever the order in which the tree offers them.
class Best {
public:
    using DistanceType = double;
    using IndexType = Index;
    explicit Best(std::size_t n) : n_(n) { found_.reserve(n + 1); }
    [[nodiscard]] bool full() const { return found_.size() == n_; }
    [[nodiscard]] std::size_t size() const { return found_.size(); }
    [[nodiscard]] double worstDist() const {
        return full() ? found_.back().first * PRUNE_SLACK + std::numeric_limits<double>::min()
                      : std::numeric_limits<double>::max();
    }
    bool addPoint(double distance2, Index point) {
        const Found item{distance2, point};
        if (full() && !(item < found_.back())) return true;
        found_.insert(std::upper_bound(found_.begin(), found_.end(), item), item);
        if (found_.size() > n_) found_.pop_back();
        return true;
    }
    void sort() {}  // newer nanoflann calls it; always sorted
    [[nodiscard]] const std::vector<Found>& found() const { return found_; }

private:
    std::size_t n_;
    std::vector<Found> found_;
};

/// Everything no farther than a radius, the rim included.
class Inside {
public:
    using DistanceType = double;
    using IndexType = Index;
    explicit Inside(double radius_m) : radius2_(radius_m * radius_m) {}
    [[nodiscard]] bool full() const { return true; }
    [[nodiscard]] std::size_t size() const { return found_.size(); }
    [[nodiscard]] double worstDist() const {
        return radius2_ * PRUNE_SLACK + std::numeric_limits<double>::min();
    }
    bool addPoint(double distance2, Index point) {
        if (distance2 <= radius2_) found_.emplace_back(distance2, point);
        return true;
    }
    void sort() { std::sort(found_.begin(), found_.end()); }
    [[nodiscard]] const std::vector<Found>& found() const { return found_; }

private:
    double radius2_;
    std::vector<Found> found_;
};

std::vector<Index> indices(const std::vector<Found>& found) {
    std::vector<Index> result;
    result.reserve(found.size());
    for (const Found& item : found) result.push_back(item.second);
    return result;
}

void check_finite(const Eigen::Vector3d& at_m) {
    if (!at_m.allFinite()) throw std::invalid_argument("Tree: the place asked for is not finite");
}

}  // namespace

struct Tree::Impl {
    explicit Impl(const Points& points_m) : adaptor{&points_m}, kd(3, adaptor) {}
    Adaptor adaptor;
    Kd kd;
};

Tree::Tree(const Points& points_m) {
    if (points_m.empty()) throw std::invalid_argument("Tree: no points");
    if (points_m.size() > std::numeric_limits<Index>::max())
        throw std::invalid_argument("Tree: over 2^32 points");
    impl_ = std::make_unique<Impl>(points_m);
    impl_->kd.buildIndex();
}
Tree::~Tree() = default;
Tree::Tree(Tree&&) noexcept = default;

Index Tree::nearest(const Eigen::Vector3d& at_m) const {
    check_finite(at_m);
    Best best(1);
    impl_->kd.findNeighbors(best, at_m.data(), {});
    return best.found().front().second;
}

std::vector<Index> Tree::nearest(const Eigen::Vector3d& at_m, std::size_t n) const {
    check_finite(at_m);
    if (n == 0) return {};
    Best best(std::min(n, impl_->adaptor.points_m->size()));
    impl_->kd.findNeighbors(best, at_m.data(), {});
    return indices(best.found());
}

std::vector<Index> Tree::within(const Eigen::Vector3d& at_m, double radius_m) const {
    check_finite(at_m);
    if (!(radius_m >= 0.0)) return {};
    Inside inside(radius_m);
    impl_->kd.findNeighbors(inside, at_m.data(), {});
    inside.sort();
    return indices(inside.found());
}

double median_spacing_m(const Cloud& cloud, const Tree& tree) {
    std::vector<double> spacing_m;
    spacing_m.reserve(cloud.points_m.size());
    for (const Eigen::Vector3d& point_m : cloud.points_m) {
        const std::vector<Index> pair = tree.nearest(point_m, 2);
        if (pair.size() == 2) spacing_m.push_back((cloud.points_m[pair[1]] - cloud.points_m[pair[0]]).norm());
    }
    if (spacing_m.empty()) return 0.0;
    const auto middle = spacing_m.begin() + static_cast<std::ptrdiff_t>(spacing_m.size() / 2);
    std::nth_element(spacing_m.begin(), middle, spacing_m.end());
    return *middle;
}

}  // namespace palpate::cloud
