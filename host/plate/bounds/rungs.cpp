#include "host/plate/bounds/rungs.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/plate/bounds/kernels.hpp"
#include "host/plate/bounds/quadratic.hpp"

namespace palpate::plate::bounds {
namespace {

using Coefficients = std::array<double, N_MODES_MAX>;

double squared(double x) {
    return x * x;
}

/// What n terms and a handful of operations on their sum may round (MATH.md section 17).
double margin_of(std::size_t n) {
    return static_cast<double>(n + 32) * EPSILON;
}

/// The dual value, and by how much the stress's own load may be longer than p (MATH.md section 17).
double with_imbalance(double energy, double imbalance, double least_ratio) {
    return squared(std::sqrt(energy) + imbalance / std::sqrt(least_ratio)) * (1.0 + 16.0 * EPSILON);
}

/// K >= this times the member's K.
double least_ratio(const Member& member, const Weights& w) {
    return member.k0 > 0.0 ? std::min(w.d_least, w.k_least / member.k0) : w.d_least;
}

Quadratic form(const SumKernels& sums, std::size_t n_modes, const std::vector<double>& of_d,
               std::span<const double> d, const std::vector<double>& of_k, std::span<const double> k,
               bool foundation) {
    Quadratic form{n_modes, {}};
    sums.dot_rows(of_d.data(), n_pairs(n_modes), d.data(), d.size(), form.pairs.data());
    if (!foundation) return form;
    std::array<double, n_pairs(N_MODES_MAX)> reactions{};
    sums.dot_rows(of_k.data(), n_pairs(n_modes), k.data(), k.size(), reactions.data());
    for (std::size_t i = 0; i < n_pairs(n_modes); ++i) form.pairs[i] += reactions[i];
    return form;
}

}  // namespace

Energies energies(const Member& member, const Weights& w) {
    const std::size_t n = w.d.size();
    const Pair bending = w.sums->dot_both(member.bending.data(), w.d.data(), w.inverse_d.data(), n);
    Pair foundation{0.0, 0.0};
    if (member.k0 > 0.0 && w.k_least > 0.0) {
        foundation = w.sums->dot_both(member.foundation.data(), w.k.data(), w.inverse_k.data(), n);
    } else if (!w.k.empty()) {
        foundation.first = w.sums->dot(member.foundation.data(), w.k.data(), n);
    }
    return {bending.first, foundation.first, bending.second, foundation.second};
}

bool can_bound_above(const Member& member, const Weights& w) {
    return member.k0 == 0.0 || w.k_least > 0.0;
}

void uniform_rung(const Member& member, const Weights& w, const Energies& energy, Range& range) {
    const double margin = margin_of(2 * w.d.size());
    const double most = (energy.bending + energy.foundation) * (1.0 + margin);
    const double lower = member.work * (member.work / most) * (1.0 - 4.0 * EPSILON);
    double upper = std::numeric_limits<double>::infinity();
    if (can_bound_above(member, w)) {
        upper = energy.stress_bending;
        if (member.k0 > 0.0) upper += squared(member.k0) * energy.stress_foundation;
        upper = with_imbalance(upper * (1.0 + margin), member.imbalance, least_ratio(member, w));
    }
    range.meet(lower, upper);
}

void extremes_rung(const Member& member, const Weights& w, Range& range) {
    double lower = 0.0, upper = std::numeric_limits<double>::infinity();
    if (member.k0 > 0.0) {
        lower = member.compliance_low / std::max(w.d_most, w.k_most / member.k0);
    } else if (!(w.k_most > 0.0)) {
        lower = member.compliance_low / w.d_most;
    }
    if (can_bound_above(member, w)) upper = member.compliance_high / least_ratio(member, w);
    range.meet(lower * (1.0 - 4.0 * EPSILON), upper * (1.0 + 4.0 * EPSILON));
}

void modes_lower_rung(const Member& member, const Weights& w, Range& range) {
    const Modes& modes = member.modes;
    const auto energy = form(*w.sums, modes.n, modes.strain_d, w.d, modes.strain_k, w.k, !w.k.empty());
    const Coefficients y = energy.solve(modes.work, 0);
    double work = 0.0, magnitude = 0.0, slip = 0.0;
    for (std::size_t i = 0; i < modes.n; ++i) {
        work += y[i] * modes.work[i];
        magnitude += std::fabs(y[i] * modes.work[i]);
        slip += std::fabs(y[i]) * modes.slip[i];
    }
    const double margin = margin_of(2 * w.d.size());
    const double norm = (std::sqrt(energy.most(y, margin)) + slip * std::sqrt(std::max(w.d_most, w.k_most))) *
                        (1.0 + 16.0 * EPSILON);
    const double certain = work - 64.0 * EPSILON * magnitude;
    const double lower = certain > 0.0 ? squared(certain / norm) * (1.0 - 8.0 * EPSILON) : 0.0;
    range.meet(lower, std::numeric_limits<double>::infinity());
}

void modes_upper_rung(const Member& member, const Weights& w, Range& range) {
    if (!can_bound_above(member, w)) return;
    const Modes& modes = member.modes;
    const auto energy =
        form(*w.sums, modes.n, modes.stress_d, w.inverse_d, modes.stress_k, w.inverse_k, member.k0 > 0.0);
    Coefficients slope{};
    for (std::size_t i = 1; i < modes.n; ++i) slope[i] = -energy.at(0, i);
    Coefficients y = energy.solve(slope, 1);
    y[0] = 1.0;
    double imbalance = 0.0;
    for (std::size_t i = 0; i < modes.n; ++i) imbalance += std::fabs(y[i]) * modes.imbalance[i];
    const double most = energy.most(y, margin_of(2 * w.d.size())) * (1.0 + 16.0 * EPSILON);
    range.meet(0.0, with_imbalance(most, imbalance * (1.0 + 16.0 * EPSILON), least_ratio(member, w)));
}

}  // namespace palpate::plate::bounds
