#include "host/table/stiffness_field.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "host/contact/weights.hpp"

namespace palpate::table {
namespace {

constexpr double SUPPORT_IN_SPACINGS = 2.8;
constexpr double RIM_IN_SPACINGS = 1.5;  // farther from every point than this there is no skin
// Of the variance of the points' weighted mean: beyond it the points do not hold the polynomial. 2 to 30
// among points, 400 half a spacing beyond a rim; a whole one beyond, where two rows are left for three terms,
// the value is noise (17 to 4900 N/m on an even sheet of 426).
constexpr double VARIANCE_MAX = 1e3;
constexpr int QUADRATIC = 6, CUBIC = 10;  // terms of the local polynomial
// Holds the cubic terms where points are few; a switch between degrees would make the field jump. 1e-6 to
// 1e-3 do on the bunny, the last with the smallest force error.
constexpr double CUBIC_RIDGE = 1e-3;
constexpr double NAN_VALUE = std::numeric_limits<double>::quiet_NaN();

}  // namespace

StiffnessField::StiffnessField(const contact::Surface& surface, const chart::Material& material)
    : surface_(&surface),
      material_(material),
      samples_(surface.cloud().points_m.size()),
      near_(samples_.size()),
      shown_(samples_.size(), std::numeric_limits<float>::quiet_NaN()) {}

double StiffnessField::support_m() const {
    return SUPPORT_IN_SPACINGS * material_.spacing_m;
}

const std::vector<cloud::Index>& StiffnessField::near(cloud::Index point) const {
    std::vector<cloud::Index>& list = near_[point];
    if (list.empty()) {
        const double radius_m = 1.35 * support_m() + 2.0 * material_.spacing_m;
        for (const cloud::Reached& r : surface_->graph().grow(point, radius_m, true)) list.push_back(r.point);
    }
    return list;
}

const StiffnessField::Sample& StiffnessField::sample(cloud::Index point) const {
    Sample& s = samples_[point];
    if (s.state != Sample::State::unknown) return s;
    s.state = Sample::State::impossible;
    const auto foot = surface_->foot(surface_->cloud().points_m[point], point);
    if (!foot) return s;
    try {
        const chart::Stiffness k = chart::point_stiffness(*surface_, *foot, material_);
        s = {Sample::State::solved, foot->point_m, k.n_per_m, k.relative_error};
        shown_[point] = static_cast<float>(k.n_per_m);
        ++n_solved_;
        if (k.saddle) ++n_saddles_;
    } catch (const chart::NoPatch& no) {  // such as too near a rim: no value here, the neighbours' serve
        why_not_ = no.what();
    }
    return s;
}

FieldValue StiffnessField::at(const contact::Foot& foot) const {
    constexpr FieldValue NOTHING{NAN_VALUE, NAN_VALUE};
    const double rim_m = RIM_IN_SPACINGS * material_.spacing_m;
    if ((surface_->cloud().points_m[foot.nearest] - foot.point_m).norm() > rim_m) return NOTHING;
    Eigen::Matrix<double, CUBIC, CUBIC> normal_matrix = Eigen::Matrix<double, CUBIC, CUBIC>::Zero();
    Eigen::Matrix<double, CUBIC, 1> right = Eigen::Matrix<double, CUBIC, 1>::Zero();
    double sum_squares = 0.0, sum_weights = 0.0, plate_error = 0.0;
    const Eigen::Vector3d e1 = foot.normal.unitOrthogonal(), e2 = foot.normal.cross(e1);
    int n = 0;
    for (const cloud::Index point : near(foot.nearest)) {
        const Eigen::Vector3d guess = surface_->cloud().points_m[point] - foot.point_m;
        if (guess.norm() > support_m() + material_.spacing_m) continue;
        const Sample& s = sample(point);
        if (s.state != Sample::State::solved) continue;
        const Eigen::Vector3d way = s.at_m - foot.point_m;
        const double w = contact::wendland(way.norm() / support_m());
        if (!(w > 0.0)) continue;
        const double u = way.dot(e1) / support_m(), v = way.dot(e2) / support_m();
        Eigen::Matrix<double, CUBIC, 1> row;
        row << 1.0, u, v, u * u, u * v, v * v, u * u * u, u * u * v, u * v * v, v * v * v;
        normal_matrix += w * row * row.transpose();
        right += w * s.n_per_m * row;
        sum_squares += w * s.n_per_m * s.n_per_m;
        sum_weights += w;
        plate_error = std::max(plate_error, s.relative_error);
        ++n;
    }
    if (n < QUADRATIC + 2) return NOTHING;
    for (int term = QUADRATIC; term < CUBIC; ++term) normal_matrix(term, term) += CUBIC_RIDGE * sum_weights;
    const Eigen::LDLT<Eigen::Matrix<double, CUBIC, CUBIC>> factor(normal_matrix);
    const double variance = sum_weights * factor.solve(Eigen::Matrix<double, CUBIC, 1>::Unit(0))(0);
    if (!(variance > 0.0 && variance <= VARIANCE_MAX)) return NOTHING;
    const Eigen::Matrix<double, CUBIC, 1> c = factor.solve(right);
    const double misfit = std::max(0.0, sum_squares - c.dot(right)) / sum_weights;
    if (!(c(0) > 0.0)) return NOTHING;
    return {c(0), plate_error + std::sqrt(misfit) / c(0)};
}

void StiffnessField::bake(std::span<const cloud::Index> points,
                          const std::function<void(std::size_t)>& progress) const {
    for (std::size_t i = 0; i < points.size(); ++i) {
        static_cast<void>(sample(points[i]));
        progress(i + 1);
    }
}

std::vector<cloud::Index> StiffnessField::needed_for(const contact::Foot& foot, double radius_m) const {
    std::vector<cloud::Index> points;
    const double reach_m = radius_m + support_m() + 2.0 * material_.spacing_m;
    for (const cloud::Reached& r : surface_->graph().grow(foot.nearest, 1.2 * reach_m, true)) {
        if ((surface_->cloud().points_m[r.point] - foot.point_m).norm() < reach_m) points.push_back(r.point);
    }
    return points;
}

}  // namespace palpate::table
