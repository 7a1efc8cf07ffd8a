#include "host/view/surfels.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <set>
#include <stdexcept>

#include "host/cloud/neighbours.hpp"

namespace palpate::view {
namespace {

constexpr float kDiscReach = 1.35F;  ///< disc radius over the distance to the farthest of the nearest four
constexpr float kDotRadius = 0.16F;  ///< of a left-behind dot over the distance between dots
constexpr float kSameSide = 0.2F;    ///< least cosine between normals of neighbours

Eigen::Vector3f vector_of(const std::array<float, 3>& a) {
    return {a[0], a[1], a[2]};
}
std::array<float, 3> array_of(const Eigen::Vector3f& v) {
    return {v.x(), v.y(), v.z()};
}

}  // namespace

Surfels::Surfels(const Body& body) {
    const std::size_t n = body.points_m.size();
    if (body.normals.size() != n || body.stiffness_n_per_m.size() != n) {
        throw std::invalid_argument("a body needs one normal and one stiffness per point");
    }
    const Range range = finite_range(body.stiffness_n_per_m).value_or(Range{});
    rest_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        const float length = body.normals[i].norm();
        const Eigen::Vector3f normal =
            length > 0.0F ? Eigen::Vector3f(body.normals[i] / length) : Eigen::Vector3f(0.0F, 0.0F, 1.0F);
        rest_[i] = {array_of(body.points_m[i]), array_of(normal), 0.0F,
                    shade(range, body.stiffness_n_per_m[i]), 0.0F};
    }
    moved_by_m_.assign(n, Eigen::Vector3f::Zero());
    is_touched_.assign(n, false);
    find_neighbours(body);
    thin_dots(body);
    discs_ = rest_;
}

/// Keeps the first point in each cell of a cubic lattice.
void Surfels::thin_dots(const Body& body) {
    const std::size_t n = body.points_m.size();
    const float cell_m = std::max(2.0F * body.view_radius_m / kDotsAcross, spacing_m_);
    dot_radius_m_ = kDotRadius * cell_m;
    has_dot_.assign(n, false);
    std::set<std::array<int, 3>> taken;
    for (std::size_t i = 0; i < n && cell_m > 0.0F; ++i) {
        const Eigen::Array3f cell = (body.points_m[i] / cell_m).array().floor();
        if (!(cell.abs() < 1.0e6F).all()) continue;
        has_dot_[i] =
            taken.insert({static_cast<int>(cell[0]), static_cast<int>(cell[1]), static_cast<int>(cell[2])})
                .second;
    }
}

void Surfels::find_neighbours(const Body& body) {
    const std::size_t n = body.points_m.size();
    std::array<std::uint32_t, kNeighbours> none{};
    none.fill(kNone);
    neighbours_.assign(n, none);
    if (n < 2) return;
    std::vector<Eigen::Vector3d> points_m(n);
    for (std::size_t i = 0; i < n; ++i) points_m[i] = body.points_m[i].cast<double>();
    const cloud::Tree tree(points_m);
    std::vector<float> reach_m(n);
    for (std::size_t i = 0; i < n; ++i) {
        std::size_t n_kept = 0;
        std::size_t n_seen = 0;
        for (const auto j : tree.nearest(points_m[i], kNeighbours + 1)) {
            if (j == i) continue;
            if (n_seen < 4) reach_m[i] = static_cast<float>((points_m[j] - points_m[i]).norm());
            ++n_seen;
            if (n_kept == kNeighbours || body.normals[j].dot(body.normals[i]) < kSameSide) continue;
            neighbours_[i][n_kept++] = static_cast<std::uint32_t>(j);
        }
    }
    std::vector<float> sorted = reach_m;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(n / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    spacing_m_ = *middle;
    // A lone point far from the rest does not become a plate.
    for (std::size_t i = 0; i < n; ++i)
        rest_[i].radius_m = kDiscReach * std::min(reach_m[i], 3.0F * spacing_m_);
}

void Surfels::bend(std::span<const Moved> dip, float scale) {
    for (const std::uint32_t point : touched_) {
        discs_[point] = rest_[point];
        moved_by_m_[point].setZero();
        is_touched_[point] = false;
    }
    touched_.clear();
    left_behind_.clear();
    float deepest_m = 0.0F;
    for (const Moved& move : dip) {
        if (move.point >= rest_.size() || !move.by_m.allFinite()) continue;
        moved_by_m_[move.point] = move.by_m;
        deepest_m = std::max(deepest_m, move.by_m.norm());
    }
    if (!(deepest_m > 0.0F)) return;
    for (const Moved& move : dip) {
        if (move.point >= rest_.size()) continue;
        if (!is_touched_[move.point]) turn(move.point, scale);
        for (const std::uint32_t j : neighbours_[move.point]) {
            if (j != kNone && !is_touched_[j]) turn(j, scale);
        }
        if (!has_dot_[move.point]) continue;
        Surfel dot = rest_[move.point];
        dot.radius_m = dot_radius_m_;
        dot.shade = move.by_m.norm() / deepest_m;
        left_behind_.push_back(dot);
    }
}

/// With w = displacement along the normal n, the surface moved to x + w n has the normal n - grad w to first
/// order; grad w in the tangent plane is the least-squares slope over the neighbours.
void Surfels::turn(std::uint32_t point, float scale) {
    is_touched_[point] = true;
    touched_.push_back(point);
    const Eigen::Vector3f at_m = vector_of(rest_[point].at_m);
    const Eigen::Vector3f n = vector_of(rest_[point].normal);
    const Eigen::Vector3f t1 = n.unitOrthogonal();
    const Eigen::Vector3f t2 = n.cross(t1);
    Eigen::Matrix2f normal_equations = Eigen::Matrix2f::Zero();
    Eigen::Vector2f right_side = Eigen::Vector2f::Zero();
    for (const std::uint32_t j : neighbours_[point]) {
        if (j == kNone) break;
        const Eigen::Vector3f d_m = vector_of(rest_[j].at_m) - at_m;
        const Eigen::Vector2f d(d_m.dot(t1), d_m.dot(t2));
        normal_equations += d * d.transpose();
        right_side += d * (moved_by_m_[j] - moved_by_m_[point]).dot(n);
    }
    Eigen::Vector3f turned = n;
    const float spread = 0.5F * normal_equations.trace();
    if (normal_equations.determinant() > 1.0e-3F * spread * spread) {
        const Eigen::Vector2f slope = normal_equations.inverse() * right_side;
        turned = (n - scale * (slope.x() * t1 + slope.y() * t2)).normalized();
    }
    discs_[point].at_m = array_of(at_m + scale * moved_by_m_[point]);
    discs_[point].dipped_m = moved_by_m_[point].norm();
    discs_[point].normal = array_of(turned);
}

}  // namespace palpate::view
