#include "host/plate/iterative/exchange.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

namespace palpate::plate {
namespace {

using Eigen::Index;

constexpr double RIGIDITY_SPAN_MAX = 1e15;  ///< as problem_with has it
constexpr double INFINITE = std::numeric_limits<double>::infinity();

void require_size(const Layout& layout, std::size_t n) {
    if (n != static_cast<std::size_t>(layout.nx * layout.nz))
        throw std::invalid_argument("forces and deflections need one value per node");
}

/// visit(node of the grid, place in the layout) for all nodes that move.
template <typename Visit>
void for_moving(const Stencil& stencil, Visit&& visit) {
    const Moving& moving = stencil.moving();
    const Layout& layout = stencil.layout();
    for (Index iz = moving.z0; iz < moving.z1; ++iz) {
        for (Index ix = moving.x0; ix < moving.x1; ++ix)
            visit(static_cast<std::size_t>(ix + layout.nx * iz), layout.at(ix, iz));
    }
}

}  // namespace

void require_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m, const Layout& layout,
                      const Mask& solid) {
    if (rigidity_n_m.rows() != layout.nx || rigidity_n_m.cols() != layout.nz)
        throw std::invalid_argument("rigidity of another size than the grid");
    double least = std::numeric_limits<double>::max(), most = 0.0;
    for (Index iz = 0; iz < layout.nz; ++iz) {
        for (Index ix = 0; ix < layout.nx; ++ix) {
            if (solid.size() != 0 && !solid(ix, iz)) continue;
            const double d = rigidity_n_m(ix, iz);
            if (!(d > 0.0 && d < INFINITE)) {
                throw Guard("rigidity " + std::to_string(d) + " at node (" + std::to_string(ix) + ", " +
                            std::to_string(iz) + "); must be positive and finite");
            }
            least = std::min(least, d);
            most = std::max(most, d);
        }
    }
    if (most / least > RIGIDITY_SPAN_MAX)
        throw Guard("rigidity spans more than 15 decades; clamp the softest nodes");
}

double put_force(const Stencil& stencil, std::span<const double> force_n, double* f) {
    require_size(stencil.layout(), force_n.size());
    double most = 0.0;
    for_moving(stencil, [&](std::size_t node, std::size_t at) {
        if (!std::isfinite(force_n[node])) throw Guard("plate force is not finite");
        f[at] = force_n[node];
        most = std::max(most, std::fabs(f[at]));
    });
    return most;
}

void take_deflection(const Stencil& stencil, const double* x, std::span<double> deflection_m) {
    require_size(stencil.layout(), deflection_m.size());
    std::fill(deflection_m.begin(), deflection_m.end(), 0.0);
    const double unit_m = stencil.compliance_m_per_n();
    for_moving(stencil, [&](std::size_t node, std::size_t at) { deflection_m[node] = x[at] * unit_m; });
}

double largest(std::span<const double> r) {
    double most = 0.0;
    for (const double value : r) {
        if (!(std::fabs(value) <= most)) most = std::fabs(value);
        if (!std::isfinite(most)) return INFINITE;
    }
    return most;
}

double true_residual(const Stencil& stencil, const double* x, const double* f, double f_max,
                     std::span<double> r) {
    if (f_max == 0.0) return 0.0;
    stencil.apply(x, r.data());
    double most = 0.0;
    for_moving(stencil, [&](std::size_t, std::size_t at) {
        const double off = std::fabs(r[at] - f[at]);
        if (!(off <= most) && most < INFINITE) most = std::isfinite(off) ? off : INFINITE;
    });
    return most / f_max;
}

void require_work(const Stencil& stencil, const double* x, const double* f, const char* method) {
    double work = 0.0;
    bool loaded = false;
    for_moving(stencil, [&](std::size_t, std::size_t at) {
        work += f[at] * x[at];
        loaded = loaded || f[at] != 0.0;
    });
    if (loaded && !(work > 0.0 && work < INFINITE)) {
        std::array<char, 32> work_n_m{};
        std::snprintf(work_n_m.data(), work_n_m.size(), "%g", work * stencil.compliance_m_per_n());
        throw Guard(std::string(method) + " gives a negative compliance: the work of the forces is " +
                    work_n_m.data() + " N m, not positive");
    }
}

}  // namespace palpate::plate
