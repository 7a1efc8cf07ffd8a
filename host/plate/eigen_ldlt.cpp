#include "host/plate/eigen_ldlt.hpp"

#include <vector>

#include "host/plate/iterative/exchange.hpp"

namespace palpate::plate {

using Eigen::Index;

Eigen::SparseMatrix<double> sparse_stiffness(const Stencil& stencil) {
    const Moving& moving = stencil.moving();
    const auto number = [&](Index ix, Index iz) {
        return static_cast<int>(ix - moving.x0 + (iz - moving.z0) * (moving.x1 - moving.x0));
    };
    std::vector<Eigen::Triplet<double>> entries;
    for (Index iz = moving.z0; iz < moving.z1; ++iz) {
        for (Index ix = moving.x0; ix < moving.x1; ++ix) {
            for (std::size_t k = 0; k < N_COUPLINGS; ++k) {
                const Index jx = ix + OFFSETS[k].dx, jz = iz + OFFSETS[k].dz;
                if (!moving.holds(jx, jz)) continue;
                entries.emplace_back(number(jx, jz), number(ix, iz),
                                     stencil.coupling(static_cast<Coupling>(k))[stencil.layout().at(ix, iz)]);
            }
        }
    }
    Eigen::SparseMatrix<double> lower(moving.count(), moving.count());
    lower.setFromTriplets(entries.begin(), entries.end());
    return lower;
}

EigenLdlt::EigenLdlt(const Problem& problem) : solid_(require_problem(problem).solid), stencil_(problem) {
    ldlt_.analyzePattern(sparse_stiffness(stencil_));
    factorise();
}

void EigenLdlt::set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) {
    require_rigidity(rigidity_n_m, stencil_.layout(), solid_);
    stencil_.set_rigidity(rigidity_n_m);
    factorise();
}

void EigenLdlt::factorise() {
    ldlt_.factorize(sparse_stiffness(stencil_));
    factorised_ = ldlt_.info() == Eigen::Success && (ldlt_.vectorD().array() > 0.0).all();
    require_factor();
}

void EigenLdlt::require_factor() const {
    if (!factorised_) throw Guard("eigen: a pivot of the plate's stiffness is not positive");
}

Report EigenLdlt::solve(std::span<const double> force_n, std::span<double> deflection_m) const {
    require_factor();
    const Layout& layout = stencil_.layout();
    const Moving& moving = stencil_.moving();
    std::vector<double> f(layout.size(), 0.0), x(f), room(f);
    const double f_max = put_force(stencil_, force_n, f.data());
    const Index n = moving.x1 - moving.x0;
    Eigen::VectorXd packed(moving.count());
    for (Index iz = moving.z0; iz < moving.z1; ++iz) {
        packed.segment((iz - moving.z0) * n, n) =
            Eigen::Map<const Eigen::VectorXd>(f.data() + layout.at(moving.x0, iz), n);
    }
    packed = ldlt_.solve(packed).eval();
    for (Index iz = moving.z0; iz < moving.z1; ++iz) {
        Eigen::Map<Eigen::VectorXd>(x.data() + layout.at(moving.x0, iz), n) =
            packed.segment((iz - moving.z0) * n, n);
    }
    const Report report{Status::solved, 0, true_residual(stencil_, x.data(), f.data(), f_max, room)};
    if (!(report.residual <= RESIDUAL_MAX)) throw Guard("eigen: the solution leaves a residual above 1e-7");
    require_work(stencil_, x.data(), f.data(), name_of(Method::eigen));
    take_deflection(stencil_, x.data(), deflection_m);
    return report;
}

}  // namespace palpate::plate
