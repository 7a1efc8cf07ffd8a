#include "host/chart/patch.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "host/contact/weights.hpp"

namespace palpate::chart {
namespace {

constexpr Eigen::Index NODES_MIN = 33, NODES_MAX = 129;  // of the finer grid
constexpr double FREE_EDGE = 1e-6;         // of the largest D: a free edge (MATH.md, cantilever)
constexpr double COVERED_MIN = 0.5;        // share of nodes that need skin
constexpr double REACH_IN_SPACINGS = 2.0;  // a node takes E from points this near
constexpr double FIT_SUPPORT = 0.75;       // of the patch side: radius of the weights of fit and curvature
// Of 1/side^2. With the other sign so much Gaussian curvature would change k by 0.1 % (MATH.md eq. 26): less
// is a plane or a cylinder, and rounding.
constexpr double SADDLE_MIN = 1e-3;

std::string millimetres(double m) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.1f mm", 1e3 * m);
    return text.data();
}

/// The points around a contact along the surface, with their fitting weights.
struct Around {
    std::vector<cloud::Index> points;
    std::vector<Eigen::Vector3d> at_m;
    std::vector<double> weight;
};

Around points_around(const contact::Surface& surface, const contact::Foot& foot, const Material& material) {
    const double corner_m = material.patch_size_m * std::sqrt(0.5);
    const double radius_m = 1.2 * corner_m + (REACH_IN_SPACINGS + 1.0) * material.spacing_m;
    const double support_m = FIT_SUPPORT * material.patch_size_m;
    Around around;
    for (const cloud::Reached& reached : surface.graph().grow(foot.nearest, radius_m, true)) {
        const Eigen::Vector3d& p = surface.cloud().points_m[reached.point];
        around.points.push_back(reached.point);
        around.at_m.push_back(p);
        around.weight.push_back(contact::wendland((p - foot.point_m).norm() / support_m));
    }
    return around;
}

contact::Sphere fitted_sphere(const Around& around, const contact::Foot& foot, double side_m) {
    try {
        return contact::fit_sphere(around.at_m, around.weight, foot.normal);
    } catch (const contact::NoFit& no) {
        throw NoPatch("the scan is too sparse for a patch of " + millimetres(side_m) + ": " + no.what());
    }
}

/// Frame at the foot whose sphere is concentric with the fitted one.
Frame fitted_frame(const Around& around, const contact::Foot& foot, double side_m) {
    const contact::Sphere sphere = fitted_sphere(around, foot, side_m);
    const double raised_m = sphere.distance_m(foot.point_m);
    const double kappa = sphere.kappa_per_m() / (1.0 + sphere.kappa_per_m() * raised_m);
    return frame_at(foot.point_m, sphere.normal(foot.point_m), kappa);
}

/// kappa1 kappa2 at the contact: the fitted sphere's curvature corrected by the quadratic part of the heights
/// over it.
double gaussian_curvature(const Around& around, const Frame& frame, double scale_m) {
    Eigen::Matrix<double, 6, 6> normal_matrix = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    for (std::size_t i = 0; i < around.points.size(); ++i) {
        if (!(around.weight[i] > 0.0)) continue;
        const auto uvh = gnomonic(frame, frame.local_m(around.at_m[i]));
        if (!uvh) continue;
        const double u = uvh->x() / scale_m, v = uvh->y() / scale_m;
        Eigen::Matrix<double, 6, 1> row;
        row << 1.0, u, v, 0.5 * u * u, u * v, 0.5 * v * v;
        normal_matrix += around.weight[i] * row * row.transpose();
        right += around.weight[i] * uvh->z() * row;
    }
    const Eigen::Matrix<double, 6, 1> c = normal_matrix.ldlt().solve(right) / (scale_m * scale_m);
    const double kappa = frame.kappa_per_m;
    return (kappa - c(3)) * (kappa - c(5)) - c(4) * c(4);
}

/// Young's modulus at the nodes from the points within reach of each; 0 where there are none.
Eigen::ArrayXXd young_at_nodes(const std::vector<PlatePoint>& points, const std::vector<double>& young_pa,
                               double side_m, Eigen::Index nodes, double reach_m) {
    const double step_m = side_m / static_cast<double>(nodes - 1);
    Eigen::ArrayXXd sum = Eigen::ArrayXXd::Zero(nodes, nodes), weights = sum;
    const auto first = [&](double x) { return static_cast<Eigen::Index>(std::ceil((x - reach_m) / step_m)); };
    const auto last = [&](double x) { return static_cast<Eigen::Index>(std::floor((x + reach_m) / step_m)); };
    for (const PlatePoint& p : points) {
        const double x = p.at_m.x() + 0.5 * side_m, z = p.at_m.y() + 0.5 * side_m;
        for (Eigen::Index i = std::max<Eigen::Index>(0, first(x)); i <= std::min(nodes - 1, last(x)); ++i) {
            for (Eigen::Index j = std::max<Eigen::Index>(0, first(z)); j <= std::min(nodes - 1, last(z));
                 ++j) {
                const double dx = static_cast<double>(i) * step_m - x,
                             dz = static_cast<double>(j) * step_m - z;
                const double w = contact::wendland(std::sqrt(dx * dx + dz * dz) / reach_m);
                weights(i, j) += w;
                sum(i, j) += w * young_pa[p.point];
            }
        }
    }
    return (weights > 0.0).select(sum / weights.max(1e-300), 0.0);
}

/// Deflection under 1 N at the centre.
Eigen::ArrayXXd unit_dip_m(const Patch& patch) {
    const Eigen::Index middle = patch.problem.rigidity_n_m.rows() / 2;
    try {
        return plate::Plate(patch.problem).deflection_m(middle, middle);
    } catch (const plate::Guard& guard) {
        throw NoPatch(guard.what());
    }
}

}  // namespace

Patch cut_patch(const contact::Surface& surface, const contact::Foot& foot, const Material& material,
                Eigen::Index nodes) {
    const Around around = points_around(surface, foot, material);
    Patch patch{.frame = fitted_frame(around, foot, material.patch_size_m),
                .problem = {},
                .points = {},
                .covered = 0.0,
                .gauss_per_m2 = 0.0,
                .saddle = false};
    for (std::size_t i = 0; i < around.points.size(); ++i) {
        const auto uvh = gnomonic(patch.frame, patch.frame.local_m(around.at_m[i]));
        if (!uvh) continue;
        patch.points.push_back(
            {around.points[i], to_plate(patch.frame, material.projection, uvh->x(), uvh->y())});
    }
    const double side_m = material.patch_size_m;
    const Eigen::ArrayXXd young = young_at_nodes(patch.points, surface.cloud().young_pa, side_m, nodes,
                                                 REACH_IN_SPACINGS * material.spacing_m);
    patch.covered = static_cast<double>((young > 0.0).count()) / static_cast<double>(young.size());
    if (patch.covered < COVERED_MIN || !(young(nodes / 2, nodes / 2) > 0.0)) {
        throw NoPatch("the skin covers " + std::to_string(std::lround(100.0 * patch.covered)) +
                      " % of a patch of " + millimetres(side_m) + "; at least half is needed");
    }
    if (material.shell) {
        patch.gauss_per_m2 = gaussian_curvature(around, patch.frame, FIT_SUPPORT * side_m);
        patch.saddle = patch.gauss_per_m2 * side_m * side_m < -SADDLE_MIN;
    }
    const double h = material.thickness_m, nu = material.poisson;
    const Eigen::ArrayXXd rigidity = young * (h * h * h / (12.0 * (1.0 - nu * nu)));
    const double shell = h * std::max(patch.gauss_per_m2, 0.0);
    patch.problem.size_m = {side_m, side_m};
    patch.problem.rigidity_n_m = rigidity.max(FREE_EDGE * rigidity.maxCoeff());
    patch.problem.foundation_n_per_m3 =
        (young > 0.0).select(young * shell + material.foundation_n_per_m3, 0.0);
    patch.problem.poisson = nu;
    return patch;
}

Stiffness point_stiffness(const contact::Surface& surface, const contact::Foot& foot,
                          const Material& material, Eigen::Index nodes) {
    const Patch patch = cut_patch(surface, foot, material, nodes);
    try {
        const plate::Estimate c = plate::extrapolated_centre_compliance(patch.problem);
        return {1.0 / c.m_per_n, c.relative_error, patch.covered, patch.saddle};
    } catch (const plate::Guard& guard) {
        throw NoPatch(guard.what());
    }
}

Stiffness point_stiffness(const contact::Surface& surface, const contact::Foot& foot,
                          const Material& material) {
    Stiffness k = point_stiffness(surface, foot, material, NODES_MIN);
    for (Eigen::Index nodes = 2 * NODES_MIN - 1; k.relative_error > material.tolerance && nodes <= NODES_MAX;
         nodes = 2 * nodes - 1) {
        k = point_stiffness(surface, foot, material, nodes);
    }
    return k;
}

std::vector<Displaced> dip(const contact::Surface& surface, const contact::Foot& foot,
                           const Material& material, double force_n, Eigen::Index nodes) {
    const Patch patch = cut_patch(surface, foot, material, nodes);
    const Eigen::ArrayXXd w = unit_dip_m(patch) * force_n;
    const double step_m = material.patch_size_m / static_cast<double>(nodes - 1);
    std::vector<Displaced> moved;
    for (const PlatePoint& p : patch.points) {
        const double x = p.at_m.x() / step_m + 0.5 * static_cast<double>(nodes - 1);
        const double z = p.at_m.y() / step_m + 0.5 * static_cast<double>(nodes - 1);
        const auto limit = static_cast<double>(nodes - 1);
        if (!(x >= 0.0 && x < limit && z >= 0.0 && z < limit)) continue;
        const auto i = static_cast<Eigen::Index>(x), j = static_cast<Eigen::Index>(z);
        const double a = x - static_cast<double>(i), b = z - static_cast<double>(j);
        const double here = (1 - a) * (1 - b) * w(i, j) + a * (1 - b) * w(i + 1, j) +
                            (1 - a) * b * w(i, j + 1) + a * b * w(i + 1, j + 1);
        moved.push_back({p.point, -here * foot.normal});
    }
    return moved;
}

}  // namespace palpate::chart
