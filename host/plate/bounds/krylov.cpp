#include "host/plate/bounds/krylov.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::plate::bounds {
namespace {

constexpr double STRAIN_OPERATIONS = 32;  ///< roundings in B and between w and a strain, at most

}  // namespace

double Krylov::dot(const Vector& a, const Vector& b) const {
    return sums_->dot(a.data(), b.data(), a.size());
}

double Krylov::weighted_square(const Vector& a, const Vector& weight) const {
    return sums_->weighted_square(a.data(), weight.data(), a.size());
}

Krylov::Krylov(const Setting& setting)
    : setting_(&setting), strains_(setting.unit), row_sums_(strains_.row_sums()) {
    const Padded& grid = strains_.grid();
    force_.assign(setting.force.begin(), setting.force.end());
    for (auto* v : {&deflection_, &deflection_step_, &residual_, &product_}) v->assign(grid.size(), 0.0);
    for (auto* v : {&d_, &inverse_d_, &stress_, &stress_step_, &stress_slope_, &strain_, &rows_})
        v->assign(strains_.n_rows(), 0.0);
    for (auto* v : {&nodes_force_, &nodes_deflection_}) v->assign(grid.nx * grid.nz, 0.0);
}

void Krylov::set_weights(const Weights& weights) {
    const Padded& grid = strains_.grid();
    const std::size_t n = grid.size(), s = grid.stride();
    pad(grid, weights.d.data(), &d_[ALONG_X * n]);
    pad(grid, weights.d.data(), &d_[ALONG_Z * n]);
    pad(grid, weights.inverse_d.data(), &inverse_d_[ALONG_X * n]);
    pad(grid, weights.inverse_d.data(), &inverse_d_[ALONG_Z * n]);
    for (std::size_t iz = 0; iz + 1 < grid.nz; ++iz) {
        for (std::size_t ix = 0; ix + 1 < grid.nx; ++ix) {
            const std::size_t c = grid.at(ix, iz);
            const double mean = 0.25 * ((d_[c] + d_[c + 1]) + (d_[c + s] + d_[c + s + 1]));
            d_[TWIST * n + c] = mean;
            inverse_d_[TWIST * n + c] = 1.0 / mean;
        }
    }
    if (weights.k.empty()) return;
    pad(grid, weights.k.data(), &d_[FOUNDATION * n]);
    if (above_->k0 > 0.0) {
        pad(grid, weights.inverse_k.data(), &inverse_d_[FOUNDATION * n]);
    } else {
        std::fill(inverse_d_.begin() + static_cast<std::ptrdiff_t>(FOUNDATION * n), inverse_d_.end(), 0.0);
    }
}

void Krylov::start(const Member& below, const Member& above, const Weights& weights) {
    below_ = &below;
    above_ = &above;
    sums_ = weights.sums;
    set_weights(weights);
    least_ratio_ = above.k0 > 0.0 ? std::min(weights.d_least, weights.k_least / above.k0) : weights.d_least;
    std::fill(deflection_.begin(), deflection_.end(), 0.0);
    std::copy(below.deflection.begin(), below.deflection.end(), deflection_step_.begin());
    std::copy(force_.begin(), force_.end(), residual_.begin());
    below_energy_ = dot(residual_, deflection_step_);
    move_below();
    std::copy(above.stress.begin(), above.stress.end(), stress_.begin());
    above_begun_ = false;
}

void Krylov::step() {
    step_below();
    step_above();
}

void Krylov::solve(const Plate& plate, const Vector& force, Vector& deflection) {
    unpad(strains_.grid(), force.data(), nodes_force_.data());
    plate.solve(nodes_force_, nodes_deflection_);
    pad(strains_.grid(), nodes_deflection_.data(), deflection.data());
}

/// As far along the step as the energy falls.
void Krylov::move_below() {
    strains_.strain(deflection_step_.data(), strain_.data());
    for (std::size_t i = 0; i < strain_.size(); ++i) strain_[i] *= d_[i];
    strains_.force(strain_.data(), product_.data());
    const double curvature = dot(deflection_step_, product_);
    const double length = curvature > 0.0 ? below_energy_ / curvature : 0.0;
    for (std::size_t i = 0; i < deflection_.size(); ++i) {
        deflection_[i] += length * deflection_step_[i];
        residual_[i] -= length * product_[i];
    }
}

void Krylov::step_below() {
    solve(*below_->plate, residual_, product_);
    const double energy = dot(residual_, product_);
    const double keep = below_energy_ > 0.0 ? energy / below_energy_ : 0.0;
    below_energy_ = energy;
    for (std::size_t i = 0; i < product_.size(); ++i)
        deflection_step_[i] = product_[i] + keep * deflection_step_[i];
    move_below();
}

/// The slope of the energy is the strain s/d; its part that no deflection can make, as a stress, is
/// d0 (s/d - B K0^-1 B' d0 s/d), which B' takes to 0.
void Krylov::step_above() {
    const std::size_t n = strains_.grid().size();
    const auto weigh = [&](Vector& rows) {
        for (std::size_t i = FOUNDATION * n; i < rows.size(); ++i) rows[i] *= above_->k0;
    };
    for (std::size_t i = 0; i < stress_.size(); ++i) strain_[i] = stress_[i] * inverse_d_[i];
    std::copy(strain_.begin(), strain_.end(), stress_slope_.begin());
    weigh(stress_slope_);
    strains_.force(stress_slope_.data(), product_.data());
    solve(*above_->plate, product_, product_);
    strains_.strain(product_.data(), rows_.data());
    weigh(rows_);
    for (std::size_t i = 0; i < rows_.size(); ++i) stress_slope_[i] -= rows_[i];

    const double energy = dot(strain_, stress_slope_);
    const double keep = above_begun_ && above_energy_ > 0.0 ? energy / above_energy_ : 0.0;
    above_begun_ = true;
    above_energy_ = energy;
    for (std::size_t i = 0; i < rows_.size(); ++i)
        stress_step_[i] = stress_slope_[i] + (keep != 0.0 ? keep * stress_step_[i] : 0.0);
    const double curvature = weighted_square(stress_step_, inverse_d_);
    const double length = curvature > 0.0 ? energy / curvature : 0.0;
    for (std::size_t i = 0; i < rows_.size(); ++i) stress_[i] -= length * stress_step_[i];
}

double Krylov::lower() {
    strains_.strain(deflection_.data(), strain_.data());
    const double margin = static_cast<double>(strain_.size() + 16) * EPSILON;
    double work = 0.0, magnitude = 0.0, most = 0.0;
    for (std::size_t i = 0; i < deflection_.size(); ++i) {
        work += force_[i] * deflection_[i];
        magnitude += std::fabs(force_[i] * deflection_[i]);
        most = std::max(most, std::fabs(deflection_[i]));
    }
    const double slip = STRAIN_OPERATIONS * EPSILON * most * std::sqrt(weighted_square(row_sums_, d_));
    const double norm = (std::sqrt(weighted_square(strain_, d_)) + slip) * (1.0 + margin);
    const double certain = work - margin * magnitude;
    return certain > 0.0 ? (certain / norm) * (certain / norm) * (1.0 - 4.0 * EPSILON) : 0.0;
}

double Krylov::upper() {
    strains_.force(stress_.data(), product_.data());
    const double margin = static_cast<double>(stress_.size() + 16) * EPSILON;
    double seen = 0.0;
    for (std::size_t i = 0; i < product_.size(); ++i)
        seen += (product_[i] - force_[i]) * (product_[i] - force_[i]);
    const double hidden = sums_->weighted_magnitude(stress_.data(), row_sums_.data(), stress_.size());
    // |r|/sqrt(lambda_1 d_least) is at least (r'K^-1 r)^1/2, by which r can lengthen the load.
    const double imbalance = (std::sqrt(seen) + STRAIN_OPERATIONS * EPSILON * hidden) /
                             std::sqrt(setting_->least_eigenvalue * least_ratio_);
    const double norm = (std::sqrt(weighted_square(stress_, inverse_d_)) + imbalance) * (1.0 + margin);
    return norm * norm * (1.0 + 4.0 * EPSILON);
}

void Krylov::energy_shares(std::span<double> rigidity, std::span<double> foundation) {
    const Padded& grid = strains_.grid();
    const std::size_t n = grid.size(), s = grid.stride();
    strains_.strain(deflection_.data(), strain_.data());
    for (std::size_t i = 0; i < strain_.size(); ++i) rows_[i] = d_[i] * (strain_[i] * strain_[i]);
    double total = 0.0;
    for (const double energy : rows_) total += energy;
    const double* const twist = &rows_[TWIST * n];
    for (std::size_t iz = 0; iz < grid.nz; ++iz) {
        for (std::size_t ix = 0; ix < grid.nx; ++ix) {
            const std::size_t c = grid.at(ix, iz), node = ix + grid.nx * iz;
            const double cells = 0.25 * ((twist[c] + twist[c - 1]) + (twist[c - s] + twist[c - s - 1]));
            rigidity[node] = (rows_[ALONG_X * n + c] + rows_[ALONG_Z * n + c] + cells) / total;
            if (!foundation.empty()) foundation[node] = rows_[FOUNDATION * n + c] / total;
        }
    }
}

}  // namespace palpate::plate::bounds
