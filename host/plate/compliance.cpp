#include "host/plate/compliance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "host/plate/grid_answer.hpp"
#include "host/plate/uniform/closed_form.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;

constexpr double TABLE_ERROR = 1e-6;                         ///< of the twin's values, with a margin
constexpr double UNIFORM = 1e-12;                            ///< fields that vary less are uniform
constexpr double SMOOTH_CONTRAST = 10.0, SMOOTH_STEP = 1.5;  ///< what multigrid is quick on
constexpr Index MULTIGRID_NODES = 129;
constexpr Index FIRST_NODES = 17;  ///< automatic: the finest of the first grids

std::string text(double value, int digits = 3) {
    std::array<char, 32> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%.*g", digits, value);
    return buffer.data();
}

std::string grid_text(const Nodes& nodes) {
    return std::to_string(nodes.nx) + " x " + std::to_string(nodes.nz) + " nodes";
}

/// Largest over smallest value, and the largest ratio between neighbours.
struct Variation {
    double contrast = 1.0, step = 1.0;

    explicit Variation(const Eigen::ArrayXXd& field) {
        if (field.size() == 0) return;
        const double least = field.minCoeff(), most = field.maxCoeff();
        contrast = most == least ? 1.0 : most / least;
        for (Index iz = 0; iz < field.cols(); ++iz) {
            for (Index ix = 0; ix < field.rows(); ++ix) {
                if (ix > 0) step = std::max(step, ratio(field(ix, iz), field(ix - 1, iz)));
                if (iz > 0) step = std::max(step, ratio(field(ix, iz), field(ix, iz - 1)));
            }
        }
    }
    [[nodiscard]] bool uniform() const { return contrast <= 1.0 + UNIFORM; }

private:
    static double ratio(double a, double b) { return a == b ? 1.0 : std::max(a / b, b / a); }
};

std::optional<std::string> load_problem(const Sheet& sheet, const Load& load) {
    const auto inside = [&](double x_m, double z_m) {
        return x_m > 0.0 && x_m < sheet.size_m.x() && z_m > 0.0 && z_m < sheet.size_m.y();
    };
    const double r_m = load.radius_m;
    const std::string place = "load at (" + text(load.at_m.x()) + ", " + text(load.at_m.y()) + ") m";
    if (!std::isfinite(load.force_n) || load.force_n == 0.0)
        return "force " + text(load.force_n) + " N; must be finite and not zero";
    if (!(r_m >= 0.0)) return "load radius " + text(r_m) + " m; must not be negative";
    if (load.shape == Load::Shape::punch && r_m == 0.0) return std::string("a punch needs a radius");
    if (!inside(load.at_m.x() - r_m, load.at_m.y() - r_m) ||
        !inside(load.at_m.x() + r_m, load.at_m.y() + r_m))
        return place + (r_m > 0.0 ? " and its disc" : "") + " must lie inside the plate of " +
               text(sheet.size_m.x()) + " x " + text(sheet.size_m.y()) + " m";
    if (sheet.solid && !(sheet.solid(load.at_m.x(), load.at_m.y()) > 0.0))
        return place + " lies in a hole of the plate";
    return std::nullopt;
}

void require(const Sheet& sheet, const Nodes& nodes, std::span<const Load> loads, const Accuracy& accuracy,
             const Wanted& wanted) {
    if (loads.empty()) throw std::invalid_argument("no load");
    if (nodes.nx < 5 || nodes.nz < 5)
        throw std::invalid_argument("grid of " + grid_text(nodes) + "; needs at least 5 x 5");
    if (!(accuracy.tolerance > 0.0)) throw std::invalid_argument("the tolerance must be positive");
    for (const Load& load : loads) {
        if (const auto words = load_problem(sheet, load)) throw std::invalid_argument(*words);
    }
    for (const Eigen::Vector2d& p : wanted.points_m) {
        if (p.x() >= 0.0 && p.x() <= sheet.size_m.x() && p.y() >= 0.0 && p.y() <= sheet.size_m.y()) continue;
        throw std::invalid_argument("point (" + text(p.x()) + ", " + text(p.y()) +
                                    ") m lies outside the plate");
    }
    const bool iterative = accuracy.method == Method::multigrid || accuracy.method == Method::jacobi ||
                           accuracy.method == Method::damped_jacobi;
    for (const Load& load : loads) {
        if (load.shape == Load::Shape::punch && iterative)
            throw std::invalid_argument("a rigid punch needs many columns: use cholesky or eigen");
    }
}

/// A grid that halves: 4 m + 1 nodes, at least 9.
bool halves(const Nodes& nodes) {
    return nodes.nx >= 9 && nodes.nz >= 9 && nodes.nx % 4 == 1 && nodes.nz % 4 == 1;
}
Nodes half(const Nodes& nodes) {
    return {(nodes.nx + 1) / 2, (nodes.nz + 1) / 2};
}

/// One question on as many grids as it takes.
class Ask {
public:
    Ask(const Sheet& sheet, std::span<const Load> loads, const Accuracy& accuracy, const Wanted& wanted)
        : sheet_(sheet),
          loads_(loads),
          accuracy_(accuracy),
          wanted_(wanted),
          twin_(Twin::of(sheet, loads.front())) {}

    /// By a method that works on a grid.
    [[nodiscard]] Compliance on(const Nodes& nodes, Method method) const {
        std::vector<Nodes> grids{nodes};
        while (grids.size() < 3 && halves(grids.back())) grids.push_back(half(grids.back()));
        std::vector<Level> levels;
        for (std::size_t k = 0; k < grids.size(); ++k) {
            levels.push_back(level(grids[k], method, static_cast<int>(grids.size() - 1 - k)));
            if (levels.back().answer.report.status != Status::solved) break;
        }
        return joined(levels, nodes, method);
    }

    [[nodiscard]] const std::optional<Twin>& twin() const { return twin_; }

private:
    struct Level {
        GridAnswer answer;
        double corrected;  ///< compliance less the twin's grid error
        double step;       ///< largest ratio of D between neighbours
    };

    [[nodiscard]] Level level(const Nodes& nodes, Method method, int halvings) const {
        const OnGrid grid(sheet_, nodes, loads_, halvings);
        if (const auto words = problem_with(grid.problem)) throw std::invalid_argument(*words);
        Options options = accuracy_.options;
        // |w'r| <= max(w) |r|_1, and w is largest at the load: a tenth of the tolerance is left to the
        // iteration.
        if (options.stop == StopRule::residual)
            options.tolerance = 0.1 * accuracy_.tolerance / static_cast<double>(nodes.nx * nodes.nz);
        Level level{answer_on(grid, loads_, wanted_.points_m, method, options), 0.0,
                    Variation(grid.problem.rigidity_n_m).step};
        level.corrected = level.answer.m_per_n;
        if (level.answer.report.status == Status::solved && twin_)
            level.corrected -= twin_->grid_error_m_per_n(grid);
        return level;
    }

    [[nodiscard]] Compliance joined(const std::vector<Level>& levels, const Nodes& nodes,
                                    Method method) const {
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
        const bool extrapolate = accuracy_.extrapolate && levels.size() > 1;
        for (std::size_t p = 0; p < wanted_.points_m.size(); ++p) {
            const double fine = levels[0].answer.points_m[p];
            result.deflection_m.push_back(extrapolate ? (4.0 * fine - levels[1].answer.points_m[p]) / 3.0
                                                      : fine);
            const bool at_load =
                loads_.size() == 1 && loads_[0].radius_m == 0.0 &&
                (wanted_.points_m[p] - loads_[0].at_m).norm() <= 1e-12 * sheet_.size_m.norm();
            if (at_load) result.deflection_m.back() = result.m_per_n * loads_[0].force_n;
        }
        if (wanted_.field) {
            const std::vector<double>& w = levels[0].answer.field_m;
            result.field_m = Eigen::Map<const Eigen::ArrayXXd>(w.data(), nodes.nx, nodes.nz);
        }
        return result;
    }

    /// Value and error from up to three grids (MATH.md eq. 8-10, 33).
    void estimate(const std::vector<Level>& levels, Compliance& result) const {
        const double raw = levels[0].answer.m_per_n;
        if (levels.size() == 1) {
            result.m_per_n = raw;
            result.relative_error = twin_ ? 2.0 * std::fabs(raw - levels[0].corrected) / raw
                                          : std::numeric_limits<double>::infinity();
            return;
        }
        const auto richardson = [](double fine, double coarse) { return (4.0 * fine - coarse) / 3.0; };
        const double limit = richardson(levels[0].corrected, levels[1].corrected);
        const double step = std::fabs(limit - levels[0].corrected);
        double error = 2.0 * step;
        if (levels.size() == 3 && levels[0].step <= 2.0) {
            const double coarser = richardson(levels[1].corrected, levels[2].corrected);
            error = std::max(std::fabs(limit - coarser) / 2.0, step / 8.0);
        }
        error = std::max(error, punch_error(result.nodes) * limit);
        if (!(limit > 0.0))
            throw Guard("extrapolated compliance is not positive; the grid is too coarse for the plate");
        result.m_per_n = accuracy_.extrapolate ? limit : raw;
        result.relative_error = (error + std::fabs(result.m_per_n - limit)) / limit + TABLE_ERROR;
        if (result.iterations > 0 && accuracy_.options.stop == StopRule::residual)
            result.relative_error += 0.1 * accuracy_.tolerance;
    }

    /// The nodes under a punch are a ragged disc: first order in spacing over radius, 0.35 of it at most.
    [[nodiscard]] double punch_error(const Nodes& nodes) const {
        const Load& load = loads_.front();
        if (load.shape != Load::Shape::punch) return 0.0;
        const double h_m = std::max(sheet_.size_m.x() / static_cast<double>(nodes.nx - 1),
                                    sheet_.size_m.y() / static_cast<double>(nodes.nz - 1));
        return 0.5 * h_m / load.radius_m;
    }

    const Sheet& sheet_;
    std::span<const Load> loads_;
    const Accuracy& accuracy_;
    const Wanted& wanted_;
    std::optional<Twin> twin_;
};

/// What stands against a closed form; nullopt when there is one.
std::optional<std::string> no_closed_form(const Sheet& sheet, const Nodes& nodes,
                                          std::span<const Load> loads) {
    const Problem problem = on_grid(sheet, nodes.nx, nodes.nz);
    if (!Variation(problem.rigidity_n_m).uniform()) return "D is not uniform";
    if (!Variation(problem.foundation_n_per_m3).uniform()) return "the foundation is not uniform";
    if (sheet.solid) return "the plate has holes or an outline";
    for (const Edge edge : sheet.edges) {
        if (edge == Edge::free) return "an edge is free";
    }
    for (const Load& load : loads) {
        if (load.shape == Load::Shape::punch) return "a rigid punch has no closed form here";
    }
    return std::nullopt;
}

Compliance by_closed_form(const Sheet& sheet, const Nodes& nodes, std::span<const Load> loads,
                          const Wanted& wanted) {
    Compliance result;
    result.method = Method::closed_form;
    result.kernel = "plain";
    result.nodes = wanted.field ? nodes : Nodes{0, 0};
    result.deflection_m.assign(wanted.points_m.size(), 0.0);
    if (wanted.field) result.field_m = Eigen::ArrayXXd::Zero(nodes.nx, nodes.nz);
    for (const Load& load : loads) {
        const Eigen::Vector2d& at = load.at_m;
        const UniformPlate plate{.size_m = sheet.size_m,
                                 .rigidity_n_m = sheet.rigidity_n_m(at.x(), at.y()),
                                 .foundation_n_per_m3 = sheet.foundation_n_per_m3
                                                            ? sheet.foundation_n_per_m3(at.x(), at.y())
                                                            : 0.0,
                                 .edges = sheet.edges};
        const UniformSolution solution(plate, {.at_m = at, .radius_m = load.radius_m});
        if (&load == loads.data()) {
            result.m_per_n = solution.compliance().m_per_n;
            result.relative_error = solution.compliance().relative_error;
        }
        for (std::size_t p = 0; p < wanted.points_m.size(); ++p)
            result.deflection_m[p] += load.force_n * solution.deflection_m_per_n(wanted.points_m[p]);
        for (Index ix = 0; ix < result.field_m.rows(); ++ix) {
            for (Index iz = 0; iz < result.field_m.cols(); ++iz) {
                const Eigen::Vector2d share(static_cast<double>(ix) / static_cast<double>(nodes.nx - 1),
                                            static_cast<double>(iz) / static_cast<double>(nodes.nz - 1));
                result.field_m(ix, iz) +=
                    load.force_n * solution.deflection_m_per_n(share.cwiseProduct(sheet.size_m));
            }
        }
    }
    return result;
}

/// Coarse grids first, until the estimated error meets the tolerance or the asked grid is reached.
Compliance automatic(const Sheet& sheet, const Nodes& nodes, std::span<const Load> loads,
                     const Accuracy& accuracy, const Wanted& wanted) {
    if (const auto against = no_closed_form(sheet, nodes, loads); !against) {
        Compliance result = by_closed_form(sheet, nodes, loads, wanted);
        result.why = "D, foundation and edges have a closed form; it is exact";
        return result;
    }
    const Ask ask(sheet, loads, accuracy, wanted);
    std::vector<Nodes> grids{nodes};
    while (accuracy.extrapolate && !wanted.field && halves(grids.back()) && halves(half(grids.back())) &&
           std::min(grids.back().nx, grids.back().nz) > FIRST_NODES) {
        grids.push_back(half(grids.back()));
    }
    Compliance result;
    for (auto grid = grids.rbegin(); grid != grids.rend(); ++grid) {
        const Variation rigidity(on_grid(sheet, grid->nx, grid->nz).rigidity_n_m);
        const bool smooth = rigidity.contrast <= SMOOTH_CONTRAST && rigidity.step <= SMOOTH_STEP;
        const bool multigrid = smooth && loads.size() == 1 && loads.front().shape != Load::Shape::punch &&
                               std::min(grid->nx, grid->nz) >= MULTIGRID_NODES && !sheet.solid;
        result = ask.on(*grid, multigrid ? Method::multigrid : Method::cholesky);
        result.why = multigrid ? "smooth D, one load, many nodes: multigrid is quicker than a factor there"
                               : "a factor holds at any contrast and serves every load";
        if (result.status != Status::solved || result.relative_error <= accuracy.tolerance) break;
    }
    result.why += result.relative_error <= accuracy.tolerance
                      ? "; the estimated error on " + grid_text(result.nodes) + " meets the tolerance"
                      : "; the estimated error " + text(result.relative_error, 2) +
                            " is above the tolerance " + text(accuracy.tolerance, 2) +
                            " on the finest grid allowed";
    return result;
}

}  // namespace

Compliance compliance(const Sheet& sheet, const Nodes& nodes, std::span<const Load> loads,
                      const Accuracy& accuracy, const Wanted& wanted) {
    require(sheet, nodes, loads, accuracy, wanted);
    if (const auto words = problem_with(on_grid(sheet, nodes.nx, nodes.nz)))
        throw std::invalid_argument(*words);
    if (accuracy.method == Method::automatic) return automatic(sheet, nodes, loads, accuracy, wanted);
    if (accuracy.method == Method::closed_form) {
        if (const auto against = no_closed_form(sheet, nodes, loads))
            throw std::invalid_argument("no closed form: " + *against);
        Compliance result = by_closed_form(sheet, nodes, loads, wanted);
        result.why = "asked for";
        return result;
    }
    if (accuracy.method == Method::bounds) throw std::invalid_argument("bounds alone do not solve");
    if (accuracy.extrapolate && !halves(nodes)) {
        throw std::invalid_argument("grid of " + grid_text(nodes) +
                                    "; to extrapolate each count must be 4 m + 1 and at least 9");
    }
    Compliance result = Ask(sheet, loads, accuracy, wanted).on(nodes, accuracy.method);
    result.why = "asked for";
    return result;
}

}  // namespace palpate::plate
