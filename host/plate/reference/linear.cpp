#include "host/plate/reference/linear.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace palpate::reference {
namespace {

/// Residuals that are fixed linear combinations of scalar unknowns.
class LinearResiduals final : public ceres::CostFunction {
public:
    /// `rows`: one list of coefficients per residual, all as long as the list of unknowns.
    explicit LinearResiduals(std::vector<std::vector<double>> rows) : rows_(std::move(rows)) {
        set_num_residuals(static_cast<int>(rows_.size()));
        mutable_parameter_block_sizes()->assign(rows_.front().size(), 1);
    }

    bool Evaluate(double const* const* unknowns, double* residuals, double** jacobians) const override {
        for (std::size_t r = 0; r < rows_.size(); ++r) {
            residuals[r] = 0.0;
            for (std::size_t k = 0; k < rows_[r].size(); ++k) {
                residuals[r] += rows_[r][k] * unknowns[k][0];
                if (jacobians != nullptr && jacobians[k] != nullptr) jacobians[k][r] = rows_[r][k];
            }
        }
        return true;
    }

private:
    std::vector<std::vector<double>> rows_;
};

/// A value at one node: a curvature is a short list of these.
struct Term {
    std::size_t ix;
    std::size_t iz;
    double factor;
};
using Terms = std::vector<Term>;

/// Lengths over size_x, D over its largest value.
class Energy {
public:
    explicit Energy(const Plate& plate)
        : plate_(plate),
          hx_(1.0 / static_cast<double>(plate.nx - 1)),
          hz_(plate.size_z_m / plate.size_x_m / static_cast<double>(plate.nz - 1)),
          rigidity_max_(*std::max_element(plate.rigidity_n_m.begin(), plate.rigidity_n_m.end())),
          deflection_(plate.nx * plate.nz, 0.0) {}

    Answer minimise() {
        add_nodes();
        add_edges();
        add_cells();
        add_foundation();
        double& contact = deflection_[index(plate_.contact_ix, plate_.contact_iz)];
        contact = 1.0;
        problem_.SetParameterBlockConstant(&contact);
        ceres::Solver::Options options;
        options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
        options.initial_trust_region_radius = 1e16;  // the problem is linear: no damping wanted
        options.max_num_iterations = 20;
        options.function_tolerance = 1e-15;
        options.gradient_tolerance = 1e-15;
        options.parameter_tolerance = 1e-15;
        options.logging_type = ceres::SILENT;
        ceres::Solver::Summary summary;
        ceres::Solve(options, &problem_, &summary);
        if (!summary.IsSolutionUsable()) throw std::runtime_error("no solution: " + summary.message);
        const double stiffness = 2.0 * summary.final_cost * rigidity_max_ / plate_.size_x_m / plate_.size_x_m;
        return {stiffness * plate_.depth_m, 1.0 / stiffness, static_cast<int>(summary.iterations.size())};
    }

private:
    [[nodiscard]] std::size_t index(std::size_t ix, std::size_t iz) const { return ix * plate_.nz + iz; }
    [[nodiscard]] bool clamped(std::size_t ix, std::size_t iz) const {
        return ix == 0 || iz == 0 || ix + 1 == plate_.nx || iz + 1 == plate_.nz;
    }
    [[nodiscard]] double rigidity(std::size_t ix, std::size_t iz) const {
        return plate_.rigidity_n_m[index(ix, iz)] / rigidity_max_;
    }

    /// One residual per entry of `combinations`, each a list of values at nodes; clamped nodes drop out.
    void add(const std::vector<Terms>& combinations) {
        std::vector<double*> unknowns;
        std::vector<std::vector<double>> rows(combinations.size());
        for (std::size_t r = 0; r < combinations.size(); ++r) {
            for (const Term& term : combinations[r]) {
                if (clamped(term.ix, term.iz) || term.factor == 0.0) continue;
                double* const unknown = &deflection_[index(term.ix, term.iz)];
                auto found = std::find(unknowns.begin(), unknowns.end(), unknown);
                if (found == unknowns.end()) {
                    found = unknowns.insert(found, unknown);
                    for (std::vector<double>& row : rows) row.push_back(0.0);
                }
                rows[r][static_cast<std::size_t>(found - unknowns.begin())] += term.factor;
            }
        }
        if (unknowns.empty()) return;
        problem_.AddResidualBlock(new LinearResiduals(std::move(rows)), nullptr,
                                  unknowns);  // the problem owns it
    }

    /// w_xx + nu w_zz and sqrt(1 - nu^2) w_zz, weighted.
    void add_nodes() {
        for (std::size_t ix = 1; ix + 1 < plate_.nx; ++ix) {
            for (std::size_t iz = 1; iz + 1 < plate_.nz; ++iz) {
                const double weight = std::sqrt(rigidity(ix, iz) * hx_ * hz_);
                const auto along_x = [&](double f) {
                    return Terms{{ix - 1, iz, f / hx_ / hx_},
                                 {ix, iz, -2.0 * f / hx_ / hx_},
                                 {ix + 1, iz, f / hx_ / hx_}};
                };
                const auto along_z = [&](double f) {
                    return Terms{{ix, iz - 1, f / hz_ / hz_},
                                 {ix, iz, -2.0 * f / hz_ / hz_},
                                 {ix, iz + 1, f / hz_ / hz_}};
                };
                Terms sum = along_x(weight);
                for (const Term& term : along_z(weight * plate_.poisson)) sum.push_back(term);
                add({sum, along_z(weight * std::sqrt(1.0 - plate_.poisson * plate_.poisson))});
            }
        }
    }

    /// On a clamped edge the curvature is 2 w_1/h^2 (mirrored ghost) over half a cell.
    void add_edges() {
        const std::size_t last_x = plate_.nx - 1;
        const std::size_t last_z = plate_.nz - 1;
        const auto weight = [&](double d) { return std::sqrt(0.5 * d * hx_ * hz_) * 2.0; };
        for (std::size_t iz = 1; iz < last_z; ++iz) {
            add({{{1, iz, weight(rigidity(0, iz)) / hx_ / hx_}}});
            add({{{last_x - 1, iz, weight(rigidity(last_x, iz)) / hx_ / hx_}}});
        }
        for (std::size_t ix = 1; ix < last_x; ++ix) {
            add({{{ix, 1, weight(rigidity(ix, 0)) / hz_ / hz_}}});
            add({{{ix, last_z - 1, weight(rigidity(ix, last_z)) / hz_ / hz_}}});
        }
    }

    /// Twist, with D the mean of the corners.
    void add_cells() {
        for (std::size_t ix = 0; ix + 1 < plate_.nx; ++ix) {
            for (std::size_t iz = 0; iz + 1 < plate_.nz; ++iz) {
                const double mean = (rigidity(ix, iz) + rigidity(ix + 1, iz) + rigidity(ix, iz + 1) +
                                     rigidity(ix + 1, iz + 1)) /
                                    4.0;
                const double f = std::sqrt(2.0 * (1.0 - plate_.poisson) * mean * hx_ * hz_) / hx_ / hz_;
                add({{{ix + 1, iz + 1, f}, {ix + 1, iz, -f}, {ix, iz + 1, -f}, {ix, iz, f}}});
            }
        }
    }

    void add_foundation() {
        if (plate_.foundation_n_per_m3.empty()) return;
        const double side2 = plate_.size_x_m * plate_.size_x_m;
        for (std::size_t ix = 1; ix + 1 < plate_.nx; ++ix) {
            for (std::size_t iz = 1; iz + 1 < plate_.nz; ++iz) {
                const double pressure =
                    plate_.foundation_n_per_m3[index(ix, iz)] * side2 * side2 / rigidity_max_;
                add({{{ix, iz, std::sqrt(pressure * hx_ * hz_)}}});
            }
        }
    }

    const Plate& plate_;
    double hx_;
    double hz_;
    double rigidity_max_;
    std::vector<double> deflection_;
    ceres::Problem problem_;
};

}  // namespace

Answer solve(const Plate& plate) {
    return Energy(plate).minimise();
}

}  // namespace palpate::reference
