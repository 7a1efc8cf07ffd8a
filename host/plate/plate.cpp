#include "host/plate/plate.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "host/plate/direct/factor.hpp"
#include "host/plate/stencil.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;

constexpr double ENERGY_ERROR_MAX = 1e-6;

/// Memory of one question.
struct Workspace {
    FactorWorkspace fronts;
    std::vector<double> unknowns;  ///< by elimination number

    explicit Workspace(const Analysis& analysis) : fronts(analysis), unknowns(analysis.n_unknowns) {}
};

/// One workspace for whoever comes first; others make their own.
class SharedWorkspace {
public:
    explicit SharedWorkspace(const Analysis& analysis) : analysis_(analysis), kept_(analysis) {}

    /// Calls use(workspace).
    template <typename Use>
    auto with(Use&& use) {
        if (taken_.test_and_set(std::memory_order_acquire)) {
            Workspace own(analysis_);
            return use(own);
        }
        const struct Return {
            std::atomic_flag& taken;
            ~Return() { taken.clear(std::memory_order_release); }
        } back{taken_};
        return use(kept_);
    }

private:
    const Analysis& analysis_;
    Workspace kept_;
    std::atomic_flag taken_ = ATOMIC_FLAG_INIT;
};

}  // namespace

struct Plate::Impl {
    Stencil stencil;
    std::shared_ptr<const Analysis> analysis;
    Factor factor;
    mutable SharedWorkspace workspace;
    std::vector<double> deflection, force;  ///< of the guards' question, in the layout
    bool trusted = false;

    Impl(const Problem& problem, const Kernels& kernels)
        : stencil(problem),
          analysis(analysis_for(stencil.layout(), stencil.moving())),
          factor(analysis, kernels),
          workspace(*analysis),
          deflection(stencil.layout().size(), 0.0),
          force(deflection) {}

    void factorise() {
        trusted = false;
        factor.factorise(stencil);
        check();
        trusted = true;
    }
    /// Throws Guard unless the factor, and the solution under a load at the centre, can be trusted.
    void check() {
        if (!(factor.smallest_pivot_ratio() > PIVOT_RATIO_MIN)) {
            throw Guard("plate too badly conditioned: smallest pivot ratio " +
                        std::to_string(factor.smallest_pivot_ratio() / PIVOT_RATIO_MIN) +
                        "e-8, needs 1e-8 (a stiff island in soft surroundings, or "
                        "a region with nothing to hold it)");
        }
        workspace.with([&](Workspace& work) {
            factor.solve_last(work.unknowns, work.fronts);
            for (std::size_t k = 0; k < work.unknowns.size(); ++k)
                deflection[analysis->node[k]] = work.unknowns[k];
        });
        stencil.apply(deflection.data(), force.data());
        const std::size_t centre = analysis->node.back();
        double energy = 0.0;
        for (const std::uint32_t at : analysis->node) {
            const double load = at == centre ? 1.0 : 0.0;
            if (!(std::fabs(force[at] - load) <= RESIDUAL_MAX))
                throw Guard("plate solution leaves a residual above 1e-7");
            energy += deflection[at] * force[at];
        }
        if (!(deflection[centre] > 0.0)) throw Guard("plate compliance is not positive");
        if (!(std::fabs(energy / deflection[centre] - 1.0) <= ENERGY_ERROR_MAX) ||
            !(std::fabs(factor.last_compliance() / deflection[centre] - 1.0) <= ENERGY_ERROR_MAX)) {
            throw Guard("plate energy differs from the work of its load by more than 1e-6");
        }
    }
    void require_trusted() const {
        if (!trusted) throw Guard("the plate has no rigidity that it could be solved with");
    }
    /// Elimination number of a node of the grid, EDGE if it cannot move.
    [[nodiscard]] std::size_t number(const Node& node) const {
        const Layout& grid = analysis->layout;
        if (node.ix < 0 || node.ix >= grid.nx || node.iz < 0 || node.iz >= grid.nz)
            throw std::invalid_argument("load at " + node_text(node.ix, node.iz) + ", outside the grid");
        return analysis->number[grid.at(node.ix, node.iz)];
    }
    [[nodiscard]] double compliance_m_per_n(const Node& node) const {
        const std::size_t loaded = number(node);
        if (loaded == Analysis::EDGE) return 0.0;
        if (loaded + 1 == analysis->n_unknowns)
            return factor.last_compliance() * stencil.compliance_m_per_n();
        return stencil.compliance_m_per_n() *
               workspace.with([&](Workspace& work) { return factor.compliance(loaded, work.fronts); });
    }
    /// Calls visit(place in an array of the nodes, elimination number) for each node that can move.
    template <typename Visit>
    void for_moving(Visit&& visit) const {
        const Layout& grid = analysis->layout;
        for (Index iz = analysis->moving.z0; iz < analysis->moving.z1; ++iz) {
            for (Index ix = analysis->moving.x0; ix < analysis->moving.x1; ++ix)
                visit(static_cast<std::size_t>(ix + grid.nx * iz), analysis->number[grid.at(ix, iz)]);
        }
    }
    [[nodiscard]] std::size_t n_nodes() const {
        return static_cast<std::size_t>(analysis->layout.nx * analysis->layout.nz);
    }
    /// Scales the solution, and puts it on the nodes.
    void spread(const std::vector<double>& x, std::span<double> deflection_m) const {
        const double scale_m_per_n = stencil.compliance_m_per_n();
        std::fill(deflection_m.begin(), deflection_m.end(), 0.0);
        for_moving(
            [&](std::size_t node, std::size_t number) { deflection_m[node] = x[number] * scale_m_per_n; });
    }
};

Plate::Plate(const Problem& problem, Kernel kernel) {
    require_problem(problem);
    impl_ = std::make_unique<Impl>(problem, kernels_for(kernel));
    impl_->factorise();
}

Plate::~Plate() = default;
Plate::Plate(Plate&&) noexcept = default;

void Plate::set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) {
    const Layout& grid = impl_->analysis->layout;
    if (rigidity_n_m.rows() != grid.nx || rigidity_n_m.cols() != grid.nz)
        throw std::invalid_argument("another rigidity needs the same nodes");
    impl_->trusted = false;
    for (Index iz = 0; iz < grid.nz; ++iz) {
        for (Index ix = 0; ix < grid.nx; ++ix) {
            const double d = rigidity_n_m(ix, iz);
            if (!(d > 0.0 && d <= std::numeric_limits<double>::max()))
                throw Guard("rigidity at " + node_text(ix, iz) + " must be positive and finite");
        }
    }
    impl_->stencil.set_rigidity(rigidity_n_m);
    impl_->factorise();
}

double Plate::centre_compliance_m_per_n() const {
    if (impl_->analysis->layout.nx % 2 == 0 || impl_->analysis->layout.nz % 2 == 0)
        throw std::invalid_argument("the centre of the plate is no node; the node counts must be odd");
    impl_->require_trusted();
    return impl_->factor.last_compliance() * impl_->stencil.compliance_m_per_n();
}

double Plate::compliance_m_per_n(const Node& node) const {
    impl_->require_trusted();
    return impl_->compliance_m_per_n(node);
}

void Plate::compliances_m_per_n(std::span<const Node> nodes, std::span<double> m_per_n) const {
    impl_->require_trusted();
    if (nodes.size() != m_per_n.size()) throw std::invalid_argument("nodes and compliances differ in number");
    for (std::size_t k = 0; k < nodes.size(); ++k) m_per_n[k] = impl_->compliance_m_per_n(nodes[k]);
}

Eigen::ArrayXXd Plate::deflection_m(Index ix, Index iz) const {
    Eigen::ArrayXXd field_m(impl_->analysis->layout.nx, impl_->analysis->layout.nz);
    deflection_m({ix, iz}, {field_m.data(), static_cast<std::size_t>(field_m.size())});
    return field_m;
}

void Plate::deflection_m(const Node& loaded, std::span<double> deflection_m) const {
    impl_->require_trusted();
    if (deflection_m.size() != impl_->n_nodes())
        throw std::invalid_argument("deflections need one value per node");
    const std::size_t number = impl_->number(loaded);
    if (number == Analysis::EDGE) {
        std::fill(deflection_m.begin(), deflection_m.end(), 0.0);
        return;
    }
    impl_->workspace.with([&](Workspace& work) {
        if (number + 1 == work.unknowns.size()) {
            impl_->factor.solve_last(work.unknowns, work.fronts);
        } else {
            std::fill(work.unknowns.begin(), work.unknowns.end(), 0.0);
            work.unknowns[number] = 1.0;
            impl_->factor.solve(work.unknowns, work.fronts);
        }
        impl_->spread(work.unknowns, deflection_m);
    });
}

void Plate::solve(std::span<const double> force_n, std::span<double> deflection_m) const {
    impl_->require_trusted();
    if (force_n.size() != impl_->n_nodes() || deflection_m.size() != impl_->n_nodes())
        throw std::invalid_argument("forces and deflections need one value per node");
    impl_->workspace.with([&](Workspace& work) {
        impl_->for_moving(
            [&](std::size_t node, std::size_t number) { work.unknowns[number] = force_n[node]; });
        impl_->factor.solve(work.unknowns, work.fronts);
        impl_->spread(work.unknowns, deflection_m);
    });
}

Eigen::MatrixXd Plate::dense_stiffness_n_per_m() const {
    const Stencil& stencil = impl_->stencil;
    const Moving& moving = stencil.moving();
    const auto place = [&](Index ix, Index iz) {
        return (ix - moving.x0) * (moving.z1 - moving.z0) + (iz - moving.z0);
    };
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(moving.count(), moving.count());
    for (Index ix = moving.x0; ix < moving.x1; ++ix) {
        for (Index iz = moving.z0; iz < moving.z1; ++iz) {
            for (std::size_t c = CENTRE; c < N_COUPLINGS; ++c) {
                const Index x = ix + OFFSETS[c].dx, z = iz + OFFSETS[c].dz;
                if (!moving.holds(x, z)) continue;
                const double value = stencil.coupling(static_cast<Coupling>(c))[stencil.layout().at(ix, iz)] /
                                     stencil.compliance_m_per_n();
                dense(place(ix, iz), place(x, z)) = value;
                dense(place(x, z), place(ix, iz)) = value;
            }
        }
    }
    return dense;
}

const char* Plate::kernel() const {
    return impl_->factor.kernels().name;
}

}  // namespace palpate::plate
