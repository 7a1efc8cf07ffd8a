#include "host/plate/grid_family.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "host/plate/variation.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;

constexpr double TABLE_ERROR = 1e-6;  ///< of the twin's values, with a margin

double richardson(double fine, double coarse) {
    return (4.0 * fine - coarse) / 3.0;
}

/// The grid and up to two coarser ones.
std::vector<Nodes> with_coarser(const Nodes& nodes) {
    std::vector<Nodes> grids{nodes};
    while (grids.size() < 3 && halves(grids.back())) grids.push_back(half(grids.back()));
    return grids;
}

}  // namespace

bool halves(const Nodes& nodes) {
    return nodes.nx >= 9 && nodes.nz >= 9 && nodes.nx % 4 == 1 && nodes.nz % 4 == 1;
}

Nodes half(const Nodes& nodes) {
    return {(nodes.nx + 1) / 2, (nodes.nz + 1) / 2};
}

GridFamily::GridFamily(const Sheet& sheet, std::span<const Load> loads, const Accuracy& accuracy,
                       const Wanted& wanted)
    : sheet_(sheet),
      loads_(loads),
      accuracy_(accuracy),
      wanted_(wanted),
      twin_(Twin::of(sheet, loads.front())) {}

bool sees_all(const Sheet& sheet, const Nodes& nodes) {
    return sheet.n_values[0] <= nodes.nx && sheet.n_values[1] <= nodes.nz;
}

bool GridFamily::has(const Nodes& nodes) const {
    const int halvings = static_cast<int>(with_coarser(nodes).size()) - 1;
    return !problem_with(OnGrid(sheet_, nodes, loads_, halvings).problem);
}

Compliance GridFamily::on(const Nodes& nodes, Method method) const {
    const std::vector<Nodes> grids = with_coarser(nodes);
    std::vector<Level> levels;
    for (std::size_t k = 0; k < grids.size(); ++k) {
        levels.push_back(level(grids[k], method, static_cast<int>(grids.size() - 1 - k)));
        if (levels.back().answer.report.status != Status::solved) break;
    }
    return joined(levels, nodes, method);
}

GridFamily::Level GridFamily::level(const Nodes& nodes, Method method, int halvings) const {
    const OnGrid grid(sheet_, nodes, loads_, halvings);
    // The sheet itself is right, on even lines.
    if (problem_with(grid.problem)) {
        const Eigen::Vector2d& at_m = loads_.front().at_m;
        throw std::invalid_argument(
            "the load is " + number_text(std::min(at_m.minCoeff(), (sheet_.size_m - at_m).minCoeff()), 3) +
            " m from an edge, too close to be a node of a grid of " + std::to_string(nodes.nx) + " x " +
            std::to_string(nodes.nz) + " nodes; it needs more nodes");
    }
    Options options = accuracy_.options;
    // |w'r| <= max(w) |r|_1, and w is largest at the load: a tenth of the tolerance is left to the iteration.
    if (options.stop == StopRule::residual)
        options.tolerance = 0.1 * accuracy_.tolerance / static_cast<double>(nodes.nx * nodes.nz);
    Level level{answer_on(grid, loads_, wanted_.points_m, method, options), 0.0,
                Variation(grid.problem.rigidity_n_m).step};
    level.corrected = level.answer.m_per_n;
    if (level.answer.report.status == Status::solved && twin_)
        level.corrected -= twin_->grid_error_m_per_n(grid);
    return level;
}

Compliance GridFamily::joined(const std::vector<Level>& levels, const Nodes& nodes, Method method) const {
    Compliance result;
    result.method = method;
    result.nodes = nodes;
    result.kernel = levels.front().answer.kernel;
    for (const Level& level : levels) {
        result.iterations += level.answer.report.iterations;
        if (result.status == Status::solved) result.status = level.answer.report.status;
    }
    result.residual = levels.front().answer.report.residual;
    if (result.status != Status::solved) return result;
    if (!(levels.front().answer.m_per_n > 0.0))
        throw Guard(std::string(name_of(method)) + " gives a compliance that is not positive");
    estimate(levels, result);
    result.relative_error += unseen_error(nodes);
    read_deflections(levels, result);
    return result;
}

void GridFamily::read_deflections(const std::vector<Level>& levels, Compliance& result) const {
    const bool extrapolate = accuracy_.extrapolate && levels.size() > 1;
    for (std::size_t p = 0; p < wanted_.points_m.size(); ++p) {
        const double fine = levels[0].answer.points_m[p];
        result.deflection_m.push_back(extrapolate ? richardson(fine, levels[1].answer.points_m[p]) : fine);
        const bool at_load = loads_.size() == 1 && loads_[0].radius_m == 0.0 &&
                             (wanted_.points_m[p] - loads_[0].at_m).norm() <= 1e-12 * sheet_.size_m.norm();
        if (at_load) result.deflection_m.back() = result.m_per_n * loads_[0].force_n;
    }
    if (!wanted_.field) return;
    const std::vector<double>& w = levels[0].answer.field_m;
    result.field_m = Eigen::Map<const Eigen::ArrayXXd>(w.data(), result.nodes.nx, result.nodes.nz);
}

void GridFamily::estimate(const std::vector<Level>& levels, Compliance& result) const {
    const double raw = levels[0].answer.m_per_n;
    if (levels.size() == 1) {
        const double steepness = std::min(1.0, std::log(levels[0].step));
        result.m_per_n = raw;
        result.relative_error = twin_ ? 2.0 * std::fabs(raw - levels[0].corrected) / raw + 0.25 * steepness
                                      : std::numeric_limits<double>::infinity();
        return;
    }
    const double limit = richardson(levels[0].corrected, levels[1].corrected);
    if (!(limit > 0.0))
        throw Guard("extrapolated compliance is not positive; the grid is too coarse for the plate");
    const double error = std::max(error_of(levels, limit, result.nodes), punch_error(result.nodes) * limit);
    result.m_per_n = accuracy_.extrapolate ? limit : raw;
    result.relative_error = (error + std::fabs(result.m_per_n - limit)) / limit + TABLE_ERROR;
    if (result.iterations > 0 && accuracy_.options.stop == StopRule::residual)
        result.relative_error += 0.1 * accuracy_.tolerance;
}

double GridFamily::error_of(const std::vector<Level>& levels, double limit, const Nodes& nodes) const {
    const double step = std::fabs(limit - levels[0].corrected);
    const double defect = std::fabs(levels[0].answer.m_per_n - levels[0].corrected);
    const bool steep = levels[0].step > SMOOTH_STEP;
    const double sampling = steep ? sampling_error(nodes) * limit : 0.0;
    if (levels.size() == 2) {
        const double steepness = std::min(1.0, std::log(levels[0].step));
        return std::max({15.0 * step, 1.5 * defect, 0.25 * steepness * limit}) + sampling;
    }
    const double change = std::fabs(limit - richardson(levels[1].corrected, levels[2].corrected));
    if (!steep) return std::max({1.5 * change, 0.5 * step, 0.03 * defect});
    if (sampling == 0.0) return std::max({2.0 * change, 4.0 * step, 0.1 * defect});
    return std::max({3.0 * change, 12.0 * step, 0.5 * defect}) + sampling;
}

/// How far the compliance moves when every node beside a jump takes the softer, or the stiffer, D: where the
/// jump lies is not known to the grid. Stiffening anywhere never makes it larger, so this brackets what
/// sampling can do. 0 when jumps lie on grid lines.
double GridFamily::sampling_error(const Nodes& nodes) const {
    OnGrid grid(sheet_, nodes, loads_.first(1), 0);
    const Problem own = grid.problem;
    const auto compliance = [&] {
        return answer_on(grid, loads_.first(1), {}, Method::cholesky, {}).m_per_n;
    };
    const double here = compliance();
    double worst = 0.0;
    for (const Extreme which : {Extreme::softest, Extreme::stiffest}) {
        grid.problem.rigidity_n_m = beyond_jumps(sheet_, own, which);
        const Mask same = grid.problem.rigidity_n_m == own.rigidity_n_m;
        if (same.all()) continue;
        if (own.harmonic_x_n_m.size() != 0) {
            grid.problem.harmonic_x_n_m = same.select(own.harmonic_x_n_m, grid.problem.rigidity_n_m);
            grid.problem.harmonic_z_n_m = same.select(own.harmonic_z_n_m, grid.problem.rigidity_n_m);
        }
        worst = std::max(worst, std::fabs(compliance() / here - 1.0));
    }
    return worst;
}

/// How far the compliance may be off for values of D between the nodes: one that lies within a factor of what
/// the grid takes it for moves it by that factor at most. 0 where the nodes see all.
double GridFamily::unseen_error(const Nodes& nodes) const {
    if (sees_all(sheet_, nodes)) return 0.0;
    const Field seen = sampled(on_grid(sheet_, nodes.nx, nodes.nz).rigidity_n_m, sheet_.size_m);
    const auto place = [](Index i, Index n, double length_m) {
        return n == 1 ? 0.0 : length_m * (static_cast<double>(i) / static_cast<double>(n - 1));
    };
    double worst = 0.0;
    for (Index i = 0; i < sheet_.n_values[0]; ++i) {
        for (Index j = 0; j < sheet_.n_values[1]; ++j) {
            const double x_m = place(i, sheet_.n_values[0], sheet_.size_m.x()),
                         z_m = place(j, sheet_.n_values[1], sheet_.size_m.y());
            worst = std::max(worst, std::fabs(std::log(sheet_.rigidity_n_m(x_m, z_m) / seen(x_m, z_m))));
        }
    }
    return std::expm1(worst);
}

/// The nodes under a punch are a ragged disc: first order in spacing over radius, 0.35 of it at most.
double GridFamily::punch_error(const Nodes& nodes) const {
    const Load& load = loads_.front();
    if (load.shape != Load::Shape::punch) return 0.0;
    const double h_m = std::max(sheet_.size_m.x() / static_cast<double>(nodes.nx - 1),
                                sheet_.size_m.y() / static_cast<double>(nodes.nz - 1));
    return 0.5 * h_m / load.radius_m;
}

}  // namespace palpate::plate
