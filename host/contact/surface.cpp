#include "host/contact/surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "host/contact/weights.hpp"

namespace palpate::contact {
namespace {

constexpr int steps_max = 50;
constexpr double settled_m = 1e-10;
constexpr int along_steps_max = 12;
constexpr std::size_t points_min =
    8;  // a sphere has four unknowns; half of the points may weigh next to nothing

// A point counts fully while its normal is within 37 degrees of the foot's and not at all beyond 60. The
// lists hold all up to 75 degrees from the nearest point's normal, so that a point never enters or leaves
// with a weight.
constexpr double full_cosine = 0.8;
constexpr double no_cosine = 0.5;

/// C2 step from 0 at no_cosine to 1 at full_cosine.
double side_weight(double cosine) {
    if (cosine >= full_cosine) return 1.0;
    if (!(cosine > no_cosine)) return 0.0;
    const double t = (cosine - no_cosine) / (full_cosine - no_cosine);
    return t * t * t * (t * (6.0 * t - 15.0) + 10.0);
}

/// Anderson acceleration of depth two for p = g(p): the error along the last two differences is removed.
class Accelerator {
public:
    /// Next iterate from p and g(p).
    Eigen::Vector3d next(const Eigen::Vector3d& p, const Eigen::Vector3d& g) {
        const Eigen::Vector3d f = g - p;
        if (n_ > 0) {
            df_[1] = df_[0];
            dg_[1] = dg_[0];
            df_[0] = f - f_;
            dg_[0] = g - g_;
        }
        f_ = f;
        g_ = g;
        ++n_;
        if (n_ < 2) return g;
        const double a = df_[0].squaredNorm();
        const double rhs0 = df_[0].dot(f);
        if (!(a > 0.0)) return g;
        double t0 = rhs0 / a;
        double t1 = 0.0;
        if (n_ > 2) {
            const double b = df_[0].dot(df_[1]);
            const double c = df_[1].squaredNorm();
            const double rhs1 = df_[1].dot(f);
            const double det = a * c - b * b;
            if (det > 1e-6 * a * c) {  // else the two differences are parallel and the newer one says all
                t0 = (rhs0 * c - rhs1 * b) / det;
                t1 = (rhs1 * a - rhs0 * b) / det;
            }
        }
        const Eigen::Vector3d correction = t0 * dg_[0] + t1 * dg_[1];
        // Far from the answer the differences may say anything: never undo more than the step itself.
        if (!(correction.squaredNorm() <= f.squaredNorm())) return g;
        return g - correction;
    }

private:
    int n_ = 0;
    Eigen::Vector3d f_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d g_ = Eigen::Vector3d::Zero();
    std::array<Eigen::Vector3d, 2> df_ = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    std::array<Eigen::Vector3d, 2> dg_ = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
};

}  // namespace

struct Surface::Impl {
    /// Points that may have weight while the foot is nearest to one cloud point.
    struct Neighbourhood {
        std::vector<cloud::Index> points;
        bool dense = true;  ///< support_m is enough for every point of it
    };

    const cloud::Cloud* cloud;
    const cloud::Graph* graph;
    double support_m;
    double spacing_m = 0.0;
    std::vector<double> support_at_m;  ///< per point: support_m, or more where the scan is sparse
    std::vector<Neighbourhood> cache;
    std::vector<Eigen::Vector3d> near_m;  // scratch of fit()
    std::vector<double> weights;

    Impl(const cloud::Cloud& c, const cloud::Graph& g, double support);
    const Neighbourhood& around(cloud::Index point);
    [[nodiscard]] cloud::Index walk(const Eigen::Vector3d& to_m, cloud::Index from) const;
    [[nodiscard]] double support_near_m(const Neighbourhood& hood, const Eigen::Vector3d& at_m) const;
    std::optional<Sphere> fit(const Eigen::Vector3d& about_m, const Eigen::Vector3d& normal,
                              cloud::Index nearest);
};

Surface::Impl::Impl(const cloud::Cloud& c, const cloud::Graph& g, double support)
    : cloud(&c), graph(&g), support_m(support) {
    const std::size_t n = c.points_m.size();
    support_at_m.assign(n, support);
    cache.resize(n);
    std::vector<double> nearest_m(n, 0.0);
    std::vector<double> reach_m;
    for (std::size_t i = 0; i < n; ++i) {
        reach_m.clear();
        for (const cloud::Index j : g.neighbours(static_cast<cloud::Index>(i))) {
            reach_m.push_back((c.points_m[j] - c.points_m[i]).norm());
        }
        if (reach_m.empty()) continue;
        std::sort(reach_m.begin(), reach_m.end());
        nearest_m[i] = reach_m.front();
        // With 1.6 times the eighth neighbour's distance at least nine points have a fair weight. Twice the
        // support at most: beyond it is a hole, not a sparse place.
        const double eighth_m = reach_m[std::min(points_min, reach_m.size()) - 1];
        support_at_m[i] = std::clamp(1.6 * eighth_m, support, 2.0 * support);
    }
    if (n > 0) {
        const auto middle = nearest_m.begin() + static_cast<std::ptrdiff_t>(n / 2);
        std::nth_element(nearest_m.begin(), middle, nearest_m.end());
        spacing_m = *middle;
    }
}

const Surface::Impl::Neighbourhood& Surface::Impl::around(cloud::Index point) {
    Neighbourhood& hood = cache[point];
    if (!hood.points.empty()) return hood;
    double largest_m = support_m;
    std::vector<cloud::Reached> reached;
    // A path along edges is longer than the chord, and the foot is up to a spacing away from its nearest
    // point.
    const auto grow = [&] { reached = graph->grow(point, 1.35 * largest_m + 2.0 * spacing_m, true); };
    grow();
    for (const cloud::Reached& r : reached) largest_m = std::max(largest_m, support_at_m[r.point]);
    hood.dense = largest_m == support_m;
    if (!hood.dense) grow();
    hood.points.reserve(reached.size());
    for (const cloud::Reached& r : reached) hood.points.push_back(r.point);
    return hood;
}

/// Downhill along edges to the cloud point nearest to a place.
cloud::Index Surface::Impl::walk(const Eigen::Vector3d& to_m, cloud::Index from) const {
    double best = (cloud->points_m[from] - to_m).squaredNorm();
    for (bool moved = true; moved;) {
        moved = false;
        for (const cloud::Index next : graph->neighbours(from)) {
            const double square = (cloud->points_m[next] - to_m).squaredNorm();
            if (!(square < best)) continue;
            best = square;
            from = next;
            moved = true;
            break;
        }
    }
    return from;
}

/// The support at a place: support_m where the scan is dense, a smooth mean of the points' own where it is
/// sparse.
double Surface::Impl::support_near_m(const Neighbourhood& hood, const Eigen::Vector3d& at_m) const {
    if (hood.dense) return support_m;
    const double reach_m = 1.5 * support_m;
    double sum = 0.0;
    double mean_m = 0.0;
    for (const cloud::Index i : hood.points) {
        const double r = (cloud->points_m[i] - at_m).norm();
        if (!(r < reach_m)) continue;
        const double w = wendland(r / reach_m);
        sum += w;
        mean_m += w * support_at_m[i];
    }
    return sum > 0.0 ? mean_m / sum : support_m;
}

std::optional<Sphere> Surface::Impl::fit(const Eigen::Vector3d& about_m, const Eigen::Vector3d& normal,
                                         cloud::Index nearest) {
    const Neighbourhood& hood = around(nearest);
    const double support = support_near_m(hood, about_m);
    if (!((cloud->points_m[nearest] - about_m).norm() < 0.5 * support)) return std::nullopt;
    near_m.clear();
    weights.clear();
    for (const cloud::Index i : hood.points) {
        const double square = (cloud->points_m[i] - about_m).squaredNorm();
        if (!(square < support * support)) continue;
        const double side = side_weight(cloud->normals[i].dot(normal));
        if (!(side > 0.0)) continue;
        const double w = side * wendland(std::sqrt(square) / support);
        if (!(w > 0.0)) continue;
        near_m.push_back(cloud->points_m[i]);
        weights.push_back(w);
    }
    if (near_m.size() < points_min) return std::nullopt;
    return fit_sphere(near_m, weights, normal);
}

Surface::Surface(const cloud::Cloud& cloud, const cloud::Graph& graph, double support_m)
    : impl_(std::make_unique<Impl>(cloud, graph, support_m)) {}
Surface::~Surface() = default;
Surface::Surface(Surface&&) noexcept = default;

std::optional<Foot> Surface::foot(const Eigen::Vector3d& at_m, cloud::Index seed) const {
    return foot_from({impl_->cloud->points_m[seed], impl_->cloud->normals[seed], 0.0, 0.0, seed}, at_m);
}

/// Foot of `at_m` on the sheet of `begin`, iterated from there.
std::optional<Foot> Surface::foot_from(const Foot& begin, const Eigen::Vector3d& at_m) const {
    Impl& d = *impl_;
    cloud::Index nearest = begin.nearest;
    Eigen::Vector3d p = begin.point_m;
    Eigen::Vector3d normal = begin.normal;
    Accelerator accelerator;
    for (int step = 0; step < steps_max; ++step) {
        const std::optional<Sphere> sphere = d.fit(p, normal, nearest);
        if (!sphere) return std::nullopt;
        const double distance_m = sphere->distance_m(at_m);
        normal = sphere->normal(at_m);
        const Eigen::Vector3d projected = at_m - distance_m * normal;
        const double moved_m = (projected - p).norm();
        if (!(moved_m < 4.0 * d.support_m)) return std::nullopt;  // the seed is no point near the answer
        if (moved_m < settled_m) {
            return Foot{projected, normal, distance_m, sphere->kappa_per_m(), d.walk(projected, nearest)};
        }
        p = accelerator.next(p, projected);
        nearest = d.walk(p, nearest);
    }
    return std::nullopt;
}

std::optional<double> Surface::along(const Eigen::Vector3d& at_m, const Eigen::Vector3d& direction,
                                     double raise_m, double reach_m, cloud::Index seed) const {
    double t = 0.0;
    double t_before = 0.0;
    double gap_before = 0.0;
    std::optional<Foot> here;
    for (int step = 0; step < along_steps_max; ++step) {
        const Eigen::Vector3d place = at_m + t * direction;
        here = here ? foot_from(*here, place) : foot(place, seed);
        if (!here) return std::nullopt;
        const double gap_m = here->distance_m - raise_m;
        double slope = here->normal.dot(direction);
        if (step > 0) {
            // The secant knows the last per cent of the slope that the fit's normal does not.
            const double secant = (gap_m - gap_before) / (t - t_before);
            if (std::fabs(secant - slope) < 0.25 * std::fabs(slope)) slope = secant;
        }
        if (!(std::fabs(slope) > 0.05)) return std::nullopt;  // the line runs along the surface
        const double change = -gap_m / slope;
        if (std::fabs(change) < settled_m) return t + change;
        t_before = t;
        gap_before = gap_m;
        t += change;
        if (!(std::fabs(t) <= reach_m)) return std::nullopt;
    }
    return std::nullopt;
}

double Surface::support_m() const {
    return impl_->support_m;
}
const cloud::Cloud& Surface::cloud() const {
    return *impl_->cloud;
}
const cloud::Graph& Surface::graph() const {
    return *impl_->graph;
}

}  // namespace palpate::contact
