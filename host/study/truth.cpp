#include "host/study/truth.hpp"

#include <algorithm>
#include <cmath>

#include "host/plate/plate.hpp"
#include "host/plate/uniform/closed_form.hpp"
#include "host/study/extended.hpp"

namespace palpate::study {
namespace {

using Eigen::Index;

constexpr Index CERES_NODES_MAX = 65, EXTENDED_NODES_MAX = 33;
constexpr Index COARSEST = 33;
constexpr double CERES_ERROR = 1e-10;  ///< as tested; more at high contrast
constexpr double EXTENDED_ERROR = 1e-15;

plate::Estimate on_nodes(const plate::Sheet& sheet, Index nodes) {
    return plate::extrapolated_centre_compliance(plate::on_grid(sheet, nodes, nodes));
}

}  // namespace

Truth extrapolated_truth(const RigidityField& field, const plate::Sheet& sheet, Index nodes_max) {
    Index nodes = field.reference_nodes;
    while (nodes > nodes_max && nodes % 8 == 1) nodes = (nodes + 1) / 2;
    std::optional<plate::Estimate> found;
    while (!found) {
        try {
            found = on_nodes(sheet, nodes);
        } catch (const plate::Guard&) {  // a stiff island is worse conditioned the finer the grid
            if (nodes % 8 != 1 || nodes <= COARSEST) throw;
            nodes = (nodes + 1) / 2;
        }
    }
    const plate::Estimate& fine = *found;
    double error = fine.relative_error;
    if (nodes % 8 == 1) {
        const double coarse_m_per_n = on_nodes(sheet, (nodes + 1) / 2).m_per_n;
        error = std::max(error, std::fabs(coarse_m_per_n / fine.m_per_n - 1.0) / 4.0);
    }
    return {
        fine.m_per_n, error,
        "extrapolated from " + std::to_string(nodes) + " and " + std::to_string((nodes + 1) / 2) + " nodes"};
}

Truth continuum_truth(const RigidityField& field, const plate::Sheet& sheet, Index nodes_max) {
    if (!field.uniform) return extrapolated_truth(field, sheet, nodes_max);
    const Eigen::Vector2d centre = 0.5 * sheet.size_m;
    const plate::UniformPlate uniform{
        .size_m = sheet.size_m,
        .rigidity_n_m = sheet.rigidity_n_m(centre.x(), centre.y()),
        .foundation_n_per_m3 =
            sheet.foundation_n_per_m3 ? sheet.foundation_n_per_m3(centre.x(), centre.y()) : 0.0,
        .edges = sheet.edges};
    const plate::ClosedForm form = plate::UniformSolution(uniform, {.at_m = centre}).compliance();
    return {form.m_per_n, form.relative_error, "closed form"};
}

std::optional<Truth> discrete_truth(const plate::Problem& problem, const Oracle& oracle) {
    const Index nodes = std::max(problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols());
    if (!can_ask_oracle(problem)) return std::nullopt;
    if (oracle && nodes <= CERES_NODES_MAX) {
        try {
            const Json answer = oracle("plate", oracle_request(problem));
            return Truth{answer.at("compliance_m_per_n").get<double>(), CERES_ERROR, "ceres"};
        } catch (const OracleError&) {  // it says so where it finds no minimum, as on stiff islands
        }
    }
    if (nodes > EXTENDED_NODES_MAX) return std::nullopt;
    return Truth{extended_centre_compliance_m_per_n(problem), EXTENDED_ERROR, "113 bits"};
}

}  // namespace palpate::study
