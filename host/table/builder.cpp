#include "host/table/builder.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/chart/chart.hpp"
#include "host/contact/weights.hpp"
#include "host/table/bspline.hpp"

namespace palpate::table {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double DEPTH_MIN_M =
    0.5e-3;  // K is matched at least this deep, so that it is defined without contact
constexpr double DEPTH_MAX_M = 4.0e-3;

/// Contact frame on the skin raised by the tool's radius, its sphere fitted to the points within a radius;
/// nullopt where they are too few.
std::optional<chart::Frame> table_frame(const contact::Surface& surface, const contact::Foot& foot,
                                        double radius_m, double raise_m) {
    std::vector<Vector3d> points;
    std::vector<double> weights;
    for (const cloud::Reached& r : surface.graph().grow(foot.nearest, 1.35 * radius_m, true)) {
        const Vector3d& p = surface.cloud().points_m[r.point];
        points.push_back(p);
        weights.push_back(contact::wendland((p - foot.point_m).norm() / radius_m));
    }
    const Vector3d origin = foot.point_m + raise_m * foot.normal;
    try {
        const contact::Sphere sphere = contact::fit_sphere(points, weights, foot.normal);
        const double kappa = sphere.kappa_per_m() / (1.0 + sphere.kappa_per_m() * sphere.distance_m(origin));
        return chart::frame_at(origin, sphere.normal(origin), kappa);
    } catch (const contact::NoFit&) {
        return std::nullopt;
    }
}

struct Node {
    bool good = false;
    double s_m = 0.0, k_n_per_m = 0.0, relative_error = 0.0;
    cloud::Index nearest = 0;
};

class Sampler {
public:
    Sampler(const contact::Surface& surface, const StiffnessField& field, const BuildOptions& options,
            const chart::Frame& frame, double depth_m)
        : surface_(surface), field_(field), options_(options), frame_(frame), depth_m_(depth_m) {}

    /// Node at (u, v), starting from what a neighbouring node found.
    [[nodiscard]] Node at(double u_m, double v_m, const Node& from) const {
        const Vector3d start = frame_.world_m(chart::from_gnomonic(frame_, u_m, v_m, from.s_m));
        const Vector3d above = frame_.world_m(chart::from_gnomonic(frame_, u_m, v_m, from.s_m + 1e-3));
        const Vector3d ray = (above - start).normalized();
        const auto t = surface_.along(start, ray, options_.tool_radius_m, 3e-3, from.nearest);
        if (!t) return {};
        const double s = from.s_m + *t;
        const auto deep = surface_.foot(start + (*t - depth_m_) * ray, from.nearest);
        if (!deep) return {};
        const double depth = options_.tool_radius_m - deep->distance_m;
        const FieldValue k = field_.at(*deep);
        if (!std::isfinite(k.n_per_m) || !(depth > 0.0)) return {};
        return {true, s, k.n_per_m * (depth * depth) / (depth_m_ * depth_m_), k.relative_error,
                deep->nearest};
    }

private:
    const contact::Surface& surface_;
    const StiffnessField& field_;
    const BuildOptions& options_;
    const chart::Frame& frame_;
    double depth_m_;
};

/// Nodes in rings from the middle outwards, each started from its neighbour towards the middle.
std::vector<Node> sample_nodes(const Sampler& sampler, Index m, double spacing_m, const Node& middle) {
    std::vector<Node> nodes(static_cast<std::size_t>(m * m));
    const Index c = m / 2;
    const auto node = [&](Index i, Index j) -> Node& { return nodes[static_cast<std::size_t>(i * m + j)]; };
    for (Index ring = 0; ring <= c; ++ring) {
        for (Index i = c - ring; i <= c + ring; ++i) {
            for (Index j = c - ring; j <= c + ring; ++j) {
                if (std::max(std::abs(i - c), std::abs(j - c)) != ring) continue;
                const auto inwards = [&](Index a) { return a > c ? a - 1 : (a < c ? a + 1 : a); };
                const bool diagonal = std::abs(i - c) == std::abs(j - c);
                const Index a = std::abs(i - c) == ring ? inwards(i) : i;
                const Index b = std::abs(j - c) == ring || diagonal ? inwards(j) : j;
                const Node& from = ring == 0 ? middle : node(a, b);
                const double u = static_cast<double>(i - c) * spacing_m,
                             v = static_cast<double>(j - c) * spacing_m;
                Node found = sampler.at(u, v, from);
                if (!found
                         .good) {  // carried on from the inside; the valid radius keeps the tool away from it
                    found = from;
                    found.good = false;
                }
                node(i, j) = found;
            }
        }
    }
    return nodes;
}

double valid_radius(const std::vector<Node>& nodes, Index m, double spacing_m) {
    const Index c = m / 2;
    double radius_m = (static_cast<double>(c) - 0.5) * spacing_m;
    for (Index i = 0; i < m; ++i) {
        for (Index j = 0; j < m; ++j) {
            if (nodes[static_cast<std::size_t>(i * m + j)].good) continue;
            const double du = static_cast<double>(i - c), dv = static_cast<double>(j - c);
            radius_m = std::min(radius_m, (std::sqrt(du * du + dv * dv) - 1.5) * spacing_m);
        }
    }
    return radius_m;
}

void store(pal_table& table, int plane, const MatrixXd& coefficients) {
    const Index side = coefficients.rows();
    for (Index i = 0; i < side; ++i) {
        for (Index j = 0; j < side; ++j) {
            table.coef[static_cast<std::size_t>((plane * side + i) * side + j)] =
                static_cast<float>(coefficients(i, j));
        }
    }
}

void store_fields(pal_table& table, const std::vector<Node>& nodes, Index m, double thickness_m) {
    MatrixXd s(m, m), k(m, m);
    double k_min = nodes.front().k_n_per_m, k_max = k_min, error = 0.0;
    for (Index i = 0; i < m; ++i) {
        for (Index j = 0; j < m; ++j) {
            const Node& node = nodes[static_cast<std::size_t>(i * m + j)];
            s(i, j) = node.s_m;
            k(i, j) = node.k_n_per_m;
            k_min = std::min(k_min, node.k_n_per_m);
            k_max = std::max(k_max, node.k_n_per_m);
            error = std::max(error, node.relative_error);
        }
    }
    store(table, 0, spline_coefficients(s));
    // Splines overshoot at jumps; clamped coefficients keep K positive and bounded everywhere.
    store(table, 1, spline_coefficients(k).cwiseMax(0.5 * k_min).cwiseMin(1.5 * k_max));
    store(table, 2, MatrixXd::Constant(m + 2, m + 2, 1.0 / thickness_m));
    table.error_k_relative = static_cast<float>(error);
}

/// From object metres and newtons to the hand's: lengths shrink by the position scale p, curvature and 1/h
/// grow by it, K f^2/2 becomes force_scale/p times what it was.
void to_hand(pal_table& table, double position_scale, double force_scale) {
    const auto p = static_cast<float>(position_scale);
    const auto stiffer = static_cast<float>(position_scale * force_scale);
    for (float* length : {&table.spacing_m, &table.valid_radius_m, &table.depth_scale_m}) *length /= p;
    for (int axis = 0; axis < 3; ++axis) {
        table.p0_m[axis] /= p;
        table.made_for_m[axis] /= p;
    }
    table.kappa_per_m *= p;
    const std::size_t plane = static_cast<std::size_t>(table.n_nodes + 2) * (table.n_nodes + 2);
    for (std::size_t i = 0; i < plane; ++i) {
        table.coef[i] /= p;
        table.coef[plane + i] *= stiffer;
        table.coef[2 * plane + i] *= p;
    }
}

}  // namespace

std::unique_ptr<pal_table> build(const contact::Surface& surface, const StiffnessField& field,
                                 const BuildOptions& options, const Eigen::Vector3d& tool_m,
                                 const contact::Foot& foot, std::uint32_t made_for_tick) {
    const auto m = static_cast<Index>(options.n_nodes);
    const auto frame = table_frame(surface, foot, options.fit_radius_m, options.tool_radius_m);
    if (!frame) return nullptr;
    const double depth_m = std::clamp(options.tool_radius_m - foot.distance_m, DEPTH_MIN_M, DEPTH_MAX_M);
    const Sampler sampler(surface, field, options, *frame, depth_m);
    const std::vector<Node> nodes = sample_nodes(sampler, m, options.spacing_m, {.nearest = foot.nearest});
    const double radius_m = valid_radius(nodes, m, options.spacing_m);
    if (!nodes[static_cast<std::size_t>((m / 2) * m + m / 2)].good || !(radius_m > options.spacing_m))
        return nullptr;

    auto table = std::make_unique<pal_table>();
    table->source_hash = options.source_hash;
    table->tick = made_for_tick;
    table->law = static_cast<std::uint32_t>(options.law);
    table->n_nodes = options.n_nodes;
    table->spacing_m = static_cast<float>(options.spacing_m);
    table->valid_radius_m = static_cast<float>(radius_m);
    table->kappa_per_m = static_cast<float>(frame->kappa_per_m);
    table->depth_scale_m = static_cast<float>(options.thickness_m);
    for (int axis = 0; axis < 3; ++axis) {
        table->p0_m[axis] = static_cast<float>(frame->origin_m[axis]);
        table->made_for_m[axis] = static_cast<float>(tool_m[axis]);
        for (int row = 0; row < 3; ++row)
            table->axes[3 * row + axis] = static_cast<float>(frame->axes(row, axis));
    }
    store_fields(*table, nodes, m, options.thickness_m);
    to_hand(*table, options.position_scale, options.force_scale);
    return table;
}

}  // namespace palpate::table
