#include "host/plate/bounds/uniform.hpp"

#include <algorithm>

namespace palpate::plate::bounds {
namespace {

constexpr Real ULP = 0x1p-63L;  ///< of a long double, twice its rounding error
constexpr Real SERIES_OPERATIONS =
    16;  ///< roundings between w and a strain, or a stress and a force, at most

}  // namespace

Real inner(const Vector& a, const Vector& b) {
    Real sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}

Vector Uniform::strain(const Vector& w) const {
    Vector strain(N_KINDS * n());
    setting->strains.strain(w.data(), strain.data());
    return strain;
}

Vector Uniform::force(const Vector& stress) const {
    Vector force(n());
    setting->strains.force(stress.data(), force.data());
    return force;
}

void Uniform::weigh(Vector& rows) const {
    for (std::size_t i = FOUNDATION * n(); i < rows.size(); ++i) rows[i] *= k0;
}

Real Uniform::stress_product(const Vector& a, const Vector& b) const {
    Real sum = 0;
    for (std::size_t i = 0; i < FOUNDATION * n(); ++i) sum += a[i] * b[i];
    if (!(k0 > 0)) return sum;
    Real reactions = 0;
    for (std::size_t i = FOUNDATION * n(); i < a.size(); ++i) reactions += a[i] * b[i];
    return sum + reactions / k0;
}

Vector Uniform::solve(const Vector& f) const {
    const Padded& grid = setting->strains.grid();
    std::vector<double> nodes(grid.nx * grid.nz), w(nodes.size());
    unpad(grid, f.data(), nodes.data());
    plate->solve(nodes, w);
    Vector padded(grid.size(), Real(0));
    pad(grid, w.data(), padded.data());
    return padded;
}

Vector Uniform::residual(const Vector& stress, const Vector& load) const {
    Vector r = force(stress);
    for (std::size_t i = 0; i < r.size(); ++i) r[i] -= load[i];
    return r;
}

void Uniform::balance(Vector& stress, const Vector& load) const {
    constexpr int N_SWEEPS = 2;
    for (int sweep = 0; sweep < N_SWEEPS; ++sweep) {
        Vector correction = strain(solve(residual(stress, load)));
        weigh(correction);
        for (std::size_t i = 0; i < stress.size(); ++i) stress[i] -= correction[i];
    }
    for (Real& s : stress) s = Real(static_cast<double>(s));
}

double Uniform::imbalance(const Vector& stress, const Vector& load) const {
    const Vector r = residual(stress, load);
    const std::vector<Real> sums = setting->strains.row_sums();
    Real hidden = 0;
    for (std::size_t i = 0; i < stress.size(); ++i) hidden += sums[i] * std::fabs(stress[i]);
    hidden *= SERIES_OPERATIONS * ULP;
    const Real seen = std::sqrt(std::fabs(inner(r, solve(r))));
    return UP * static_cast<double>(2 * seen + hidden / std::sqrt(Real(setting->least_eigenvalue)));
}

Vector Uniform::slips(const Vector& w) const {
    Real most = 0;
    for (const Real v : w) most = std::max(most, std::fabs(v));
    Vector slips = setting->strains.row_sums();
    for (Real& slip : slips) slip *= SERIES_OPERATIONS * ULP * most;
    return slips;
}

Vector bending_at_nodes(const Padded& grid, const Vector& a, const Vector& b) {
    const std::size_t n = grid.size(), s = grid.stride();
    Vector density(n, Real(0));
    for (std::size_t iz = 0; iz < grid.nz; ++iz) {
        for (std::size_t ix = 0; ix < grid.nx; ++ix) {
            const std::size_t c = grid.at(ix, iz);
            density[c] += a[ALONG_X * n + c] * b[ALONG_X * n + c] + a[ALONG_Z * n + c] * b[ALONG_Z * n + c];
            if (ix + 1 == grid.nx || iz + 1 == grid.nz) continue;
            const Real quarter = a[TWIST * n + c] * b[TWIST * n + c] / 4;
            for (const std::size_t corner : {c, c + 1, c + s, c + s + 1}) density[corner] += quarter;
        }
    }
    return density;
}

Vector foundation_at_nodes(const Padded& grid, const Vector& a, const Vector& b) {
    const std::size_t n = grid.size();
    Vector density(n);
    for (std::size_t c = 0; c < n; ++c) density[c] = a[FOUNDATION * n + c] * b[FOUNDATION * n + c];
    return density;
}

std::vector<double> nodes_of(const Padded& grid, const Vector& padded) {
    std::vector<double> nodes(grid.nx * grid.nz);
    unpad(grid, padded.data(), nodes.data());
    return nodes;
}

}  // namespace palpate::plate::bounds
