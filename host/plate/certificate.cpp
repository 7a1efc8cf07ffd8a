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
        return continuum_bracket(on.problem, on.unit_force, exact, {.relative_error = wanted_relative_error},
                                 &why);
    } catch (const std::invalid_argument& error) {  // a disc out of the series' reach
        why = error.what();
        return std::nullopt;
    }
}

}  // namespace palpate::plate
