#include "host/plate/plate.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "host/plate/direct/factor.hpp"
#include "host/plate/stencil.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;

// Against extended precision the compliance is wrong by less than 2e-14 / pivot ratio (stiff islands up to
// 1e9), so this leaves 2e-6 at worst. An island 1e6 times stiffer, the contrast of a free edge, has 2e-7 and
// more.
constexpr double PIVOT_RATIO_MIN = 1e-8;
constexpr double RESIDUAL_MAX = 1e-7;  ///< of the unit load
constexpr double ENERGY_ERROR_MAX = 1e-6;

std::string node_text(Index ix, Index iz) {
    return "node (" + std::to_string(ix) + ", " + std::to_string(iz) + ")";
}

/// Entries of K by elimination number.
std::vector<double> entries(const Analysis& analysis, const Stencil& stencil) {
    std::vector<double> values(analysis.row.size());
    for (std::size_t e = 0; e < values.size(); ++e) {
        const Analysis::Source& source = analysis.source[e];
        values[e] = stencil.coupling(source.coupling)[source.at];
    }
    return values;
}

std::vector<double> multiply(const Analysis& analysis, const std::vector<double>& values,
                             const std::vector<double>& x) {
    std::vector<double> product(x.size(), 0.0);
    for (std::size_t c = 0; c < analysis.n_unknowns; ++c) {
        product[c] += values[analysis.column[c]] * x[c];
        for (std::size_t e = analysis.column[c] + 1; e < analysis.column[c + 1]; ++e) {
            product[analysis.row[e]] += values[e] * x[c];
            product[c] += values[e] * x[analysis.row[e]];
        }
    }
    return product;
}

}  // namespace

struct Plate::Impl {
    Stencil stencil;
    std::shared_ptr<const Analysis> analysis;
    std::vector<double> values;
    Factor factor;

    explicit Impl(const Problem& problem)
        : stencil(problem),
          analysis(analysis_for(stencil.layout(), stencil.moving())),
          values(entries(*analysis, stencil)),
          factor(analysis, values) {}

    /// Dimensionless deflection under a unit load, by elimination number.
    [[nodiscard]] std::vector<double> solve(std::size_t loaded) const {
        std::vector<double> x(analysis->n_unknowns, 0.0);
        x[loaded] = 1.0;
        factor.solve(x);
        return x;
    }

    /// Throws Guard unless the factor, and the solution under a load at the centre, can be trusted.
    void check() const {
        if (!(factor.smallest_pivot_ratio() > PIVOT_RATIO_MIN)) {
            throw Guard("plate too badly conditioned: smallest pivot ratio " +
                        std::to_string(factor.smallest_pivot_ratio() / PIVOT_RATIO_MIN) +
                        "e-8, needs 1e-8 (a stiff island in soft surroundings, or "
                        "a region with nothing to hold it)");
        }
        const std::size_t centre = analysis->n_unknowns - 1;
        const std::vector<double> x = solve(centre);
        const std::vector<double> force = multiply(*analysis, values, x);
        double energy = 0.0;
        for (std::size_t k = 0; k < force.size(); ++k) {
            const double load = k == centre ? 1.0 : 0.0;
            if (!(std::fabs(force[k] - load) <= RESIDUAL_MAX))
                throw Guard("plate solution leaves a residual above 1e-7");
            energy += x[k] * force[k];
        }
        if (!(x[centre] > 0.0)) throw Guard("plate compliance is not positive");
        if (!(std::fabs(energy / x[centre] - 1.0) <= ENERGY_ERROR_MAX) ||
            !(std::fabs(factor.last_compliance() / x[centre] - 1.0) <= ENERGY_ERROR_MAX)) {
            throw Guard("plate energy differs from the work of its load by more than 1e-6");
        }
    }
};

Plate::Plate(const Problem& problem) {
    if (const auto problem_text = problem_with(problem)) throw std::invalid_argument(*problem_text);
    impl_ = std::make_unique<Impl>(problem);
    impl_->check();
}

Plate::~Plate() = default;
Plate::Plate(Plate&&) noexcept = default;

double Plate::centre_compliance_m_per_n() const {
    if (impl_->analysis->layout.nx % 2 == 0 || impl_->analysis->layout.nz % 2 == 0) {
        throw std::invalid_argument("the centre of the plate is no node; the node counts must be odd");
    }
    return impl_->factor.last_compliance() * impl_->stencil.compliance_m_per_n();
}

double Plate::compliance_m_per_n(const Node& node) const {
    const Layout& grid = impl_->analysis->layout;
    if (node.ix == grid.nx / 2 && node.iz == grid.nz / 2)
        return impl_->factor.last_compliance() * impl_->stencil.compliance_m_per_n();
    return deflection_m(node.ix, node.iz)(node.ix, node.iz);
}

Eigen::ArrayXXd Plate::deflection_m(Index ix, Index iz) const {
    const Analysis& analysis = *impl_->analysis;
    if (ix < 0 || ix >= analysis.layout.nx || iz < 0 || iz >= analysis.layout.nz) {
        throw std::invalid_argument("load at " + node_text(ix, iz) + ", outside the grid");
    }
    Eigen::ArrayXXd deflection = Eigen::ArrayXXd::Zero(analysis.layout.nx, analysis.layout.nz);
    const std::size_t loaded = analysis.number[analysis.layout.at(ix, iz)];
    if (loaded == Analysis::EDGE) return deflection;
    const std::vector<double> x = impl_->solve(loaded);
    const Moving& moving = analysis.moving;
    for (Index i = moving.x0; i < moving.x1; ++i) {
        for (Index j = moving.z0; j < moving.z1; ++j) {
            deflection(i, j) =
                x[analysis.number[analysis.layout.at(i, j)]] * impl_->stencil.compliance_m_per_n();
        }
    }
    return deflection;
}

void Plate::solve(std::span<const double> force_n, std::span<double> deflection_m) const {
    const Analysis& analysis = *impl_->analysis;
    const Layout& grid = analysis.layout;
    const auto n = static_cast<std::size_t>(grid.nx * grid.nz);
    if (force_n.size() != n || deflection_m.size() != n)
        throw std::invalid_argument("forces and deflections need one value per node");
    std::vector<double> x(analysis.n_unknowns);
    const auto for_moving = [&](auto&& visit) {
        for (Index iz = analysis.moving.z0; iz < analysis.moving.z1; ++iz) {
            for (Index ix = analysis.moving.x0; ix < analysis.moving.x1; ++ix)
                visit(static_cast<std::size_t>(ix + grid.nx * iz), analysis.number[grid.at(ix, iz)]);
        }
    };
    for_moving([&](std::size_t node, std::size_t number) { x[number] = force_n[node]; });
    impl_->factor.solve(x);
    std::fill(deflection_m.begin(), deflection_m.end(), 0.0);
    for_moving([&](std::size_t node, std::size_t number) {
        deflection_m[node] = x[number] * impl_->stencil.compliance_m_per_n();
    });
}

Eigen::MatrixXd Plate::dense_stiffness_n_per_m() const {
    const Analysis& analysis = *impl_->analysis;
    const auto n = static_cast<Index>(analysis.n_unknowns);
    std::vector<Index> place(analysis.n_unknowns);
    const Moving& moving = analysis.moving;
    for (Index i = moving.x0; i < moving.x1; ++i) {
        for (Index j = moving.z0; j < moving.z1; ++j) {
            place[analysis.number[analysis.layout.at(i, j)]] =
                (i - moving.x0) * (moving.z1 - moving.z0) + (j - moving.z0);
        }
    }
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
    for (std::size_t c = 0; c < analysis.n_unknowns; ++c) {
        for (std::size_t e = analysis.column[c]; e < analysis.column[c + 1]; ++e) {
            const double value = impl_->values[e] / impl_->stencil.compliance_m_per_n();
            dense(place[analysis.row[e]], place[c]) = value;
            dense(place[c], place[analysis.row[e]]) = value;
        }
    }
    return dense;
}

}  // namespace palpate::plate
