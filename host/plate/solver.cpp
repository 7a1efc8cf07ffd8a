#include "host/plate/solver.hpp"

#include <array>
#include <vector>

#include "host/plate/eigen_ldlt.hpp"
#include "host/plate/iterative/eq7.hpp"
#include "host/plate/iterative/exchange.hpp"
#include "host/plate/iterative/jacobi.hpp"
#include "host/plate/iterative/multigrid.hpp"
#include "host/plate/plate.hpp"
#include "host/plate/stencil.hpp"

namespace palpate::plate {
namespace {

struct Named {
    Method method;
    const char* name;
};
constexpr std::array METHODS{Named{Method::automatic, "auto"},
                             Named{Method::cholesky, "cholesky"},
                             Named{Method::multigrid, "multigrid"},
                             Named{Method::closed_form, "closed-form"},
                             Named{Method::bounds, "bounds"},
                             Named{Method::eigen, "eigen"},
                             Named{Method::jacobi, "jacobi"},
                             Named{Method::damped_jacobi, "damped-jacobi"},
                             Named{Method::eq7, "eq7"}};

/// Plate, which is the direct method, as a Solver.
class Cholesky final : public Solver {
public:
    Cholesky(const Problem& problem, Kernel kernel)
        : solid_(problem.solid), plate_(problem, kernel), stencil_(problem) {}

    void set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) override {
        require_rigidity(rigidity_n_m, stencil_.layout(), solid_);
        plate_.set_rigidity(rigidity_n_m);
        stencil_.set_rigidity(rigidity_n_m);
    }

    Report solve(std::span<const double> force_n, std::span<double> deflection_m) const override {
        std::vector<double> f(stencil_.layout().size(), 0.0), x(f), room(f);
        const double f_max = put_force(stencil_, force_n, f.data());
        plate_.solve(force_n, deflection_m);
        const Layout& layout = stencil_.layout();
        for (Eigen::Index iz = 0; iz < layout.nz; ++iz) {
            for (Eigen::Index ix = 0; ix < layout.nx; ++ix) {
                x[layout.at(ix, iz)] = deflection_m[static_cast<std::size_t>(ix + layout.nx * iz)] /
                                       stencil_.compliance_m_per_n();
            }
        }
        const Report report{Status::solved, 0, true_residual(stencil_, x.data(), f.data(), f_max, room)};
        if (!(report.residual <= RESIDUAL_MAX))
            throw Guard("cholesky: the solution leaves a residual above 1e-7");
        require_work(stencil_, x.data(), f.data(), name_of(Method::cholesky));
        return report;
    }

    [[nodiscard]] std::string kernel() const override { return plate_.kernel(); }

private:
    Mask solid_;
    Plate plate_;
    Stencil stencil_;  ///< for the true residual
};

}  // namespace

const char* name_of(Method method) {
    for (const Named& known : METHODS) {
        if (known.method == method) return known.name;
    }
    return "unknown";
}

std::optional<Method> method_named(std::string_view name) {
    for (const Named& known : METHODS) {
        if (name == known.name) return known.method;
    }
    return std::nullopt;
}

const char* name_of(Status status) {
    switch (status) {
        case Status::solved:
            return "solved";
        case Status::not_converged:
            return "not-converged";
        case Status::diverged:
            return "diverged";
    }
    return "unknown";
}

std::unique_ptr<Solver> make_solver(Method method, const Problem& problem, const Options& options) {
    switch (method) {
        case Method::cholesky:
            return std::make_unique<Cholesky>(problem, options.kernel);
        case Method::multigrid:
            return std::make_unique<Multigrid>(problem, options);
        case Method::eigen:
            return std::make_unique<EigenLdlt>(problem);
        case Method::jacobi:
            return std::make_unique<Jacobi>(problem, options, Jacobi::PLAIN);
        case Method::damped_jacobi:
            return std::make_unique<Jacobi>(problem, options, Jacobi::DAMPED);
        case Method::eq7:
            return std::make_unique<Eq7>(problem);
        case Method::automatic:
        case Method::closed_form:
        case Method::bounds:
            break;
    }
    throw std::invalid_argument(std::string(name_of(method)) + " is no method that solves for any forces");
}

}  // namespace palpate::plate
