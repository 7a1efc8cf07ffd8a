#include "host/plate/bounds/strains.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::plate::bounds {

using Eigen::Index;

template <typename Real>
Strains<Real>::Axis::Axis(const Eigen::ArrayXd& lines_m, Index n, double length_m, double side_m, Edge low,
                          Edge high)
    : low_free(low == Edge::free), high_free(high == Edge::free) {
    const auto count = static_cast<std::size_t>(n);
    std::vector<Real> at(count);
    for (Index i = 0; i < n; ++i) {
        const Real even = Real(length_m) * Real(i) / Real(n - 1);
        at[static_cast<std::size_t>(i)] = (lines_m.size() == 0 ? even : Real(lines_m(i))) / Real(side_m);
    }
    for (auto* line : {&before, &centre, &after, &root, &cell}) line->assign(count + 2, Real(0));
    std::vector<Real> share(count + 2, Real(0));
    for (std::size_t i = 0; i + 1 < count; ++i) {
        cell[i + 1] = at[i + 1] - at[i];
        share[i + 1] += cell[i + 1] / 2;
        share[i + 2] += cell[i + 1] / 2;
    }
    for (std::size_t i = 0; i < share.size(); ++i) root[i] = std::sqrt(share[i]);
    for (std::size_t i = 1; i + 1 < count; ++i) {
        const Real h0 = cell[i], h1 = cell[i + 1];
        before[i + 1] = 2 / (h0 * (h0 + h1));
        centre[i + 1] = -2 / (h0 * h1);
        after[i + 1] = 2 / (h1 * (h0 + h1));
    }
    if (low == Edge::clamped) after[1] = 2 / (cell[1] * cell[1]);
    if (high == Edge::clamped) before[count] = 2 / (cell[count - 1] * cell[count - 1]);
}

template <typename Real>
Strains<Real>::Strains(const Problem& problem)
    : grid_{static_cast<std::size_t>(problem.rigidity_n_m.rows()),
            static_cast<std::size_t>(problem.rigidity_n_m.cols())},
      x0_(problem.edges[0] == Edge::free ? 0 : 1),
      x1_(problem.edges[1] == Edge::free ? grid_.nx : grid_.nx - 1),
      z0_(problem.edges[2] == Edge::free ? 0 : 1),
      z1_(problem.edges[3] == Edge::free ? grid_.nz : grid_.nz - 1),
      x_(problem.lines_x_m, problem.rigidity_n_m.rows(), problem.size_m.x(), problem.size_m.x(),
         problem.edges[0], problem.edges[1]),
      z_(problem.lines_z_m, problem.rigidity_n_m.cols(), problem.size_m.y(), problem.size_m.x(),
         problem.edges[2], problem.edges[3]) {
    for (auto* field : {&xx_, &xz_, &zz_, &twist_, &area_}) field->assign(grid_.size(), Real(0));
    const Real nu =
        Real(problem.poisson_at_nodes.size() != 0 ? problem.poisson_at_nodes(0, 0) : problem.poisson);
    const Real rest = std::sqrt((1 - nu) * (1 + nu));
    for (std::size_t iz = 0; iz < grid_.nz; ++iz) {
        for (std::size_t ix = 0; ix < grid_.nx; ++ix) {
            const std::size_t c = grid_.at(ix, iz);
            const bool x_free = x_.free_at(ix + 1), z_free = z_.free_at(iz + 1);
            const Real root = x_.root[ix + 1] * z_.root[iz + 1];
            // Across a free end the curvature takes the value that costs least; 1 - nu^2 is left of the
            // other.
            xx_[c] = z_free ? rest * root : root;
            xz_[c] = x_free || z_free ? Real(0) : nu * root;
            zz_[c] = rest * root;
            area_[c] = root;
            if (ix + 1 == grid_.nx || iz + 1 == grid_.nz) continue;
            twist_[c] = std::sqrt(2 * (1 - nu) / (x_.cell[ix + 1] * z_.cell[iz + 1]));
        }
    }
}

template <typename Real>
void Strains<Real>::strain(const Real* w, Real* strain) const {
    const std::size_t s = grid_.stride(), n = grid_.size();
    std::fill(strain, strain + N_KINDS * n, Real(0));
    Real* const __restrict along_x = strain + ALONG_X * n;
    Real* const __restrict along_z = strain + ALONG_Z * n;
    Real* const __restrict twist = strain + TWIST * n;
    Real* const __restrict foundation = strain + FOUNDATION * n;
    for (std::size_t iz = 1; iz <= grid_.nz; ++iz) {
        for (std::size_t ix = 1; ix <= grid_.nx; ++ix) {
            const std::size_t c = ix + iz * s;
            const Real xx = x_.before[ix] * w[c - 1] + x_.centre[ix] * w[c] + x_.after[ix] * w[c + 1];
            const Real zz = z_.before[iz] * w[c - s] + z_.centre[iz] * w[c] + z_.after[iz] * w[c + s];
            along_x[c] = xx_[c] * xx + xz_[c] * zz;
            along_z[c] = zz_[c] * zz;
            twist[c] = twist_[c] * ((w[c + s + 1] - w[c + s]) - (w[c + 1] - w[c]));
            foundation[c] = area_[c] * w[c];
        }
    }
}

template <typename Real>
void Strains<Real>::force(const Real* stress, Real* force) const {
    const std::size_t s = grid_.stride(), n = grid_.size();
    std::fill(force, force + n, Real(0));
    const Real* const along_x = stress + ALONG_X * n;
    const Real* const along_z = stress + ALONG_Z * n;
    const Real* const twist = stress + TWIST * n;
    const Real* const foundation = stress + FOUNDATION * n;
    const auto xx = [&](std::size_t c) { return xx_[c] * along_x[c]; };
    const auto zz = [&](std::size_t c) { return xz_[c] * along_x[c] + zz_[c] * along_z[c]; };
    const auto corner = [&](std::size_t c) { return twist_[c] * twist[c]; };
    for (std::size_t iz = z0_ + 1; iz <= z1_; ++iz) {
        for (std::size_t ix = x0_ + 1; ix <= x1_; ++ix) {
            const std::size_t c = ix + iz * s;
            const Real from_x =
                x_.after[ix - 1] * xx(c - 1) + x_.centre[ix] * xx(c) + x_.before[ix + 1] * xx(c + 1);
            const Real from_z =
                z_.after[iz - 1] * zz(c - s) + z_.centre[iz] * zz(c) + z_.before[iz + 1] * zz(c + s);
            const Real from_cells = (corner(c) - corner(c - 1)) - (corner(c - s) - corner(c - s - 1));
            force[c] = (from_x + from_z) + (from_cells + area_[c] * foundation[c]);
        }
    }
}

template <typename Real>
std::vector<Real> Strains<Real>::row_sums() const {
    const std::size_t n = grid_.size();
    std::vector<Real> sums(N_KINDS * n, Real(0));
    for (std::size_t iz = 1; iz <= grid_.nz; ++iz) {
        for (std::size_t ix = 1; ix <= grid_.nx; ++ix) {
            const std::size_t c = ix + iz * grid_.stride();
            const Real xx = x_.before[ix] + std::fabs(x_.centre[ix]) + x_.after[ix];
            const Real zz = z_.before[iz] + std::fabs(z_.centre[iz]) + z_.after[iz];
            sums[ALONG_X * n + c] = xx_[c] * xx + std::fabs(xz_[c]) * zz;
            sums[ALONG_Z * n + c] = zz_[c] * zz;
            sums[TWIST * n + c] = 4 * twist_[c];
            sums[FOUNDATION * n + c] = area_[c];
        }
    }
    return sums;
}

template class Strains<double>;
template class Strains<long double>;

}  // namespace palpate::plate::bounds
