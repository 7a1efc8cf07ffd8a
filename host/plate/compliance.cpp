#include "host/plate/compliance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "host/plate/bounds/bounds.hpp"
#include "host/plate/certificate.hpp"
#include "host/plate/grid_family.hpp"
#include "host/plate/uniform/closed_form.hpp"
#include "host/plate/variation.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;

constexpr double SMOOTH_CONTRAST = 10.0;  ///< what multigrid is quick on
constexpr double ROUNDING = 1e-12;        ///< of a closed form
constexpr Index MULTIGRID_NODES = 129;
constexpr Index FIRST_NODES = 17;  ///< automatic: the finest of the first grids

std::string text(double value, int digits = 3) {
    return number_text(value, digits);
}

std::string grid_text(const Nodes& nodes) {
    return std::to_string(nodes.nx) + " x " + std::to_string(nodes.nz) + " nodes";
}

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

/// Why fields on these nodes are not uniform; nullopt when they are.
std::optional<std::string> not_uniform(const Sheet& sheet, const Nodes& nodes) {
    const Problem problem = on_grid(sheet, nodes.nx, nodes.nz);
    if (!Variation(problem.rigidity_n_m).uniform()) return "D is not uniform";
    if (!Variation(problem.foundation_n_per_m3).uniform()) return "the foundation is not uniform";
    return std::nullopt;
}

/// What stands against a closed form; nullopt when there is one.
std::optional<std::string> no_closed_form(const Sheet& sheet, const Nodes& nodes,
                                          std::span<const Load> loads) {
    if (auto words = not_uniform(sheet, nodes)) return words;
    const Nodes all{std::max<Index>(sheet.n_values[0], 2), std::max<Index>(sheet.n_values[1], 2)};
    if (auto words = not_uniform(sheet, all)) return words;
    if (sheet.solid) return "the plate has holes or an outline";
    for (const Edge edge : sheet.edges) {
        if (edge == Edge::free) return "an edge is free";
    }
    for (const Load& load : loads) {
        if (load.shape == Load::Shape::punch) return "a rigid punch has no closed form here";
        const Eigen::Vector2d& at = load.at_m;
        const double foundation_n_per_m3 =
            sheet.foundation_n_per_m3 ? sheet.foundation_n_per_m3(at.x(), at.y()) : 0.0;
        if (load.radius_m > disc_radius_max_m(sheet.rigidity_n_m(at.x(), at.y()), foundation_n_per_m3))
            return "the disc is wider than its series holds, 6 (D/foundation)^(1/4)";
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

Compliance by_bounds(const Bracket& bracket, const std::string& why) {
    Compliance result;
    result.method = Method::bounds;
    result.kernel = "plain";
    result.nodes = {0, 0};
    result.m_per_n = bracket.middle_m_per_n();
    result.relative_error = bracket.relative_error();
    result.why = why + "the middle of bounds that differ by " +
                 text(bracket.upper_m_per_n / bracket.lower_m_per_n - 1.0, 2) + " (" + name_of(bracket.rung) +
                 ")";
    return result;
}

/// Coarse grids first, until the estimated error meets the tolerance or the asked grid is reached.
Compliance automatic(const Sheet& sheet, const Nodes& nodes, std::span<const Load> loads,
                     const Accuracy& accuracy, const Wanted& wanted, const std::optional<Bracket>& bracket) {
    if (!no_closed_form(sheet, nodes, loads)) {
        try {
            Compliance result = by_closed_form(sheet, nodes, loads, wanted);
            result.why = "D, foundation and edges have a closed form; it is exact";
            if (result.relative_error <= accuracy.tolerance) return result;
        } catch (const std::invalid_argument&) {
        }  // so close to an edge that its series leave no digit
    }
    if (bracket && bracket->relative_error() <= accuracy.tolerance && loads.size() == 1 &&
        wanted.points_m.empty() && !wanted.field) {
        return by_bounds(*bracket, "nothing needs solving: ");
    }
    const GridFamily family(sheet, loads, accuracy, wanted);
    std::vector<Nodes> grids{nodes};
    while (accuracy.extrapolate && !wanted.field && halves(grids.back()) && halves(half(grids.back())) &&
           std::min(grids.back().nx, grids.back().nz) > FIRST_NODES && sees_all(sheet, half(grids.back())) &&
           family.has(half(grids.back()))) {
        grids.push_back(half(grids.back()));
    }
    Compliance result;
    for (auto grid = grids.rbegin(); grid != grids.rend(); ++grid) {
        const Variation rigidity(on_grid(sheet, grid->nx, grid->nz).rigidity_n_m);
        const bool smooth = rigidity.contrast <= SMOOTH_CONTRAST && rigidity.step <= SMOOTH_STEP;
        const bool multigrid = smooth && loads.size() == 1 && loads.front().shape != Load::Shape::punch &&
                               std::min(grid->nx, grid->nz) >= MULTIGRID_NODES && !sheet.solid;
        result = family.on(*grid, multigrid ? Method::multigrid : Method::cholesky);
        result.why = multigrid ? "smooth D, one load, many nodes: multigrid is quicker than a factor there"
                               : "a factor holds at any contrast and serves every load";
        if (multigrid && result.status != Status::solved) {
            result = family.on(*grid, Method::cholesky);
            result.why = "multigrid does not reach the tolerance there, a factor does";
        }
        if (result.status != Status::solved || result.relative_error <= accuracy.tolerance) break;
    }
    result.why += result.relative_error <= accuracy.tolerance
                      ? "; the estimated error on " + grid_text(result.nodes) + " meets the tolerance"
                      : "; the estimated error " + text(result.relative_error, 2) +
                            " is above the tolerance " + text(accuracy.tolerance, 2) +
                            " on the finest grid allowed";
    return result;
}

Compliance chosen(const Sheet& sheet, const Nodes& nodes, std::span<const Load> loads,
                  const Accuracy& accuracy, const Wanted& wanted, const std::optional<Bracket>& bracket,
                  const std::string& no_bracket_why) {
    if (accuracy.method == Method::automatic)
        return automatic(sheet, nodes, loads, accuracy, wanted, bracket);
    if (accuracy.method == Method::closed_form) {
        if (const auto against = no_closed_form(sheet, nodes, loads))
            throw std::invalid_argument("no closed form: " + *against);
        Compliance result = by_closed_form(sheet, nodes, loads, wanted);
        result.why = "asked for";
        return result;
    }
    if (accuracy.method == Method::bounds) {
        if (!bracket) throw std::invalid_argument("no bounds: " + no_bracket_why);
        if (!wanted.points_m.empty() || wanted.field)
            throw std::invalid_argument("bounds tell the compliance alone, no deflections elsewhere");
        return by_bounds(*bracket, "asked for: ");
    }
    if (accuracy.extrapolate && !halves(nodes)) {
        throw std::invalid_argument("grid of " + grid_text(nodes) +
                                    "; to extrapolate each count must be 4 m + 1 and at least 9");
    }
    Compliance result = GridFamily(sheet, loads, accuracy, wanted).on(nodes, accuracy.method);
    result.why = "asked for";
    return result;
}

/// A value outside a bracket says that one of the two is wrong.
void put_bracket(const std::optional<Bracket>& bracket, const std::string& why, Compliance& result) {
    if (result.method == Method::closed_form) {
        const double error = result.relative_error + ROUNDING;
        if (!(error < 1.0)) {
            result.no_bracket_why = "the closed form's own error is " + text(100.0 * error, 2) + " % there";
            return;
        }
        result.bracket_m_per_n = {result.m_per_n * (1.0 - error), result.m_per_n * (1.0 + error)};
        return;
    }
    if (!bracket) {
        result.no_bracket_why = why;
        return;
    }
    result.bracket_m_per_n = {bracket->lower_m_per_n, bracket->upper_m_per_n};
    if (result.status != Status::solved) return;
    const double error = std::min(result.relative_error, 1.0);
    if (result.m_per_n * (1.0 + error) >= bracket->lower_m_per_n &&
        result.m_per_n * (1.0 - error) <= bracket->upper_m_per_n)
        return;
    throw Guard(std::string(name_of(result.method)) + " gives " + text(result.m_per_n, 6) +
                " m/N, outside the certified bounds " + text(bracket->lower_m_per_n, 6) + " to " +
                text(bracket->upper_m_per_n, 6));
}

}  // namespace

Compliance compliance(const Sheet& sheet, const Nodes& nodes, std::span<const Load> loads,
                      const Accuracy& accuracy, const Wanted& wanted) {
    require(sheet, nodes, loads, accuracy, wanted);
    require_problem(on_grid(sheet, nodes.nx, nodes.nz));
    std::string why = "not asked for";
    std::optional<Bracket> bracket;
    if (accuracy.bracket || accuracy.method == Method::bounds)
        bracket = certificate(sheet, nodes, loads.front(), accuracy.tolerance, why);
    Compliance result = chosen(sheet, nodes, loads, accuracy, wanted, bracket, why);
    put_bracket(bracket, why, result);
    return result;
}

}  // namespace palpate::plate
