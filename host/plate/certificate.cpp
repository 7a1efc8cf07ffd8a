#include "host/plate/certificate.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "host/plate/bounds/continuum.hpp"
#include "host/plate/grid_answer.hpp"
#include "host/plate/grid_family.hpp"
#include "host/plate/uniform/closed_form.hpp"

namespace palpate::plate {
namespace {

constexpr Eigen::Index NODES_MAX = 65;  ///< more cost seconds and narrow nothing

/// 1 N, no node pulled: the bounds want that, and take the grid's own disc out again.
std::vector<double> pushes(const OnGrid& on, const Load& load) {
    return load.radius_m > 0.0 ? unit_pressure(on.lines, load.at_m, load.radius_m, Spread::linear)
                               : on.unit_force;
}

}  // namespace

std::optional<Bracket> certificate(const Sheet& sheet, const Nodes& nodes, const Load& load,
                                   double wanted_relative_error, std::string& why) {
    if (load.shape == Load::Shape::punch) {
        why = "a rigid punch has no certificate here";
        return std::nullopt;
    }
    if (std::find(sheet.edges.begin(), sheet.edges.end(), Edge::free) != sheet.edges.end()) {
        why = "with a free edge the uniform plate has no closed form to start from";
        return std::nullopt;
    }
    Nodes grid = nodes;
    while (std::max(grid.nx, grid.nz) > NODES_MAX && halves(grid) && halves(half(grid))) grid = half(grid);
    if (!sees_all(sheet, grid)) {
        why = "D is given at " + std::to_string(sheet.n_values[0]) + " x " +
              std::to_string(sheet.n_values[1]) + " places, of which the certificate's " +
              std::to_string(grid.nx) + " x " + std::to_string(grid.nz) + " nodes do not see all";
        return std::nullopt;
    }
    const OnGrid on(sheet, grid, std::array{load}, 1);
    if (const auto words = ContinuumBounds::none_because(on.problem)) {
        why = *words;
        return std::nullopt;
    }
    const UniformCompliance exact = [&](double foundation_n_per_m3) {
        const UniformPlate plate{.size_m = sheet.size_m,
                                 .rigidity_n_m = 1.0,
                                 .foundation_n_per_m3 = foundation_n_per_m3,
                                 .edges = sheet.edges};
        return UniformSolution(plate, {.at_m = load.at_m, .radius_m = load.radius_m}).compliance().m_per_n;
    };
    try {
        return continuum_bracket(on.problem, pushes(on, load), exact,
                                 {.relative_error = wanted_relative_error}, &why);
    } catch (const std::invalid_argument& error) {  // out of the series' reach
        why = error.what();
        return std::nullopt;
    }
}

}  // namespace palpate::plate
