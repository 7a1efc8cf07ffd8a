#include "host/study/oracle.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace palpate::study {
namespace {

/// z fastest, as palpate-reference has it.
std::vector<double> z_fastest(const Eigen::ArrayXXd& field) {
    std::vector<double> values;
    values.reserve(static_cast<std::size_t>(field.size()));
    for (Eigen::Index ix = 0; ix < field.rows(); ++ix) {
        for (Eigen::Index iz = 0; iz < field.cols(); ++iz) values.push_back(field(ix, iz));
    }
    return values;
}

}  // namespace

bool can_ask_oracle(const plate::Problem& problem) {
    return problem.edges == std::array<plate::Edge, 4>{} && problem.solid.size() == 0 &&
           problem.lines_x_m.size() == 0 && problem.lines_z_m.size() == 0 &&
           problem.poisson_at_nodes.size() == 0 && problem.harmonic_x_n_m.size() == 0;
}

Json oracle_request(const plate::Problem& problem) {
    Json request = {{"size_m", {problem.size_m.x(), problem.size_m.y()}},
                    {"nodes", {problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols()}},
                    {"poisson", problem.poisson},
                    {"rigidity_n_m", z_fastest(problem.rigidity_n_m)}};
    if (problem.foundation_n_per_m3.size() != 0)
        request["foundation_n_per_m3"] = z_fastest(problem.foundation_n_per_m3);
    // Held at a depth of the size of the deflection under 1 N.
    request["depth_m"] = 0.005 * problem.size_m.x() * problem.size_m.x() / problem.rigidity_n_m.maxCoeff();
    return request;
}

}  // namespace palpate::study
