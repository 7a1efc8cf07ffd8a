#include "host/plate/stencil.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::plate {
namespace {

using Eigen::Index;

constexpr auto PAD = static_cast<std::size_t>(Layout::PADDING);
constexpr double FREE_EDGE = 1e-6;  ///< of the largest D, where there is no plate (MATH.md section 9)

std::size_t size(Index n) {
    return static_cast<std::size_t>(n);
}

std::vector<double> lines_over_side(const Eigen::ArrayXd& lines_m, Index n, double length_m, double side_m) {
    std::vector<double> at(size(n));
    for (Index i = 0; i < n; ++i) {
        const double even_m = length_m * (static_cast<double>(i) / static_cast<double>(n - 1));
        at[size(i)] = (lines_m.size() == 0 ? even_m : lines_m(i)) / side_m;
    }
    return at;
}

/// The curvature at an end: mirrored ghost, odd ghost, or whatever costs least (MATH.md eq. 2, 31).
double end_curvature(Edge edge, double h) {
    return edge == Edge::clamped ? 2.0 / (h * h) : 0.0;
}

Lines make_lines(const std::vector<double>& at, Edge low, Edge high) {
    const std::size_t n = at.size();
    const auto zeros = [&] { return std::vector<double>(n + 2 * PAD, 0.0); };
    Lines lines{zeros(), zeros(), zeros(), zeros(), zeros(), zeros()};
    for (std::size_t i = 0; i + 1 < n; ++i) {
        const double h = at[i + 1] - at[i];
        lines.cell[i + PAD] = h;
        lines.share[i + PAD] += 0.5 * h;
        lines.share[i + 1 + PAD] += 0.5 * h;
    }
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const double h0 = at[i] - at[i - 1], h1 = at[i + 1] - at[i];
        lines.before[i + PAD] = 2.0 / (h0 * (h0 + h1));
        lines.centre[i + PAD] = -2.0 / (h0 * h1);
        lines.after[i + PAD] = 2.0 / (h1 * (h0 + h1));
    }
    lines.after[PAD] = end_curvature(low, at[1] - at[0]);
    lines.before[n - 1 + PAD] = end_curvature(high, at[n - 1] - at[n - 2]);
    lines.free[PAD] = low == Edge::free ? 1.0 : 0.0;
    lines.free[n - 1 + PAD] = high == Edge::free ? 1.0 : 0.0;
    return lines;
}

}  // namespace

Moving::Moving(Index nx, Index nz, const std::array<Edge, 4>& edges)
    : x0(edges[0] == Edge::free ? 0 : 1),
      x1(edges[1] == Edge::free ? nx : nx - 1),
      z0(edges[2] == Edge::free ? 0 : 1),
      z1(edges[3] == Edge::free ? nz : nz - 1) {}

Stencil::Stencil(const Problem& problem)
    : layout_{problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols()},
      moving_(layout_.nx, layout_.nz, problem.edges),
      side_m_(problem.size_m.x()),
      solid_(problem.solid),
      poisson_(layout_.size(), problem.poisson),
      foundation_(layout_.size(), 0.0),
      xx_(layout_.size(), 0.0),
      zz_(xx_),
      xz_(xx_),
      twist_(xx_) {
    x_ = make_lines(lines_over_side(problem.lines_x_m, layout_.nx, problem.size_m.x(), side_m_),
                    problem.edges[0], problem.edges[1]);
    z_ = make_lines(lines_over_side(problem.lines_z_m, layout_.nz, problem.size_m.y(), side_m_),
                    problem.edges[2], problem.edges[3]);
    for (auto& k : k_) k.assign(layout_.size(), 0.0);
    for (Index iz = 0; iz < layout_.nz; ++iz) {
        for (Index ix = 0; ix < layout_.nx; ++ix) {
            const std::size_t c = layout_.at(ix, iz);
            const bool solid = solid_.size() == 0 || solid_(ix, iz);
            if (problem.poisson_at_nodes.size() != 0) poisson_[c] = problem.poisson_at_nodes(ix, iz);
            if (problem.foundation_n_per_m3.size() == 0 || !solid) continue;
            foundation_[c] = x_.share[size(ix) + PAD] * z_.share[size(iz) + PAD] * side_m_ * side_m_ *
                             problem.foundation_n_per_m3(ix, iz);
        }
    }
    weigh(&problem, problem.rigidity_n_m);
    couple();
}

void Stencil::set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) {
    weigh(nullptr, rigidity_n_m);
    couple();
}

void Stencil::weigh(const Problem* problem, const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) {
    scale_n_m_ = 0.0;
    for (Index iz = 0; iz < layout_.nz; ++iz) {
        for (Index ix = 0; ix < layout_.nx; ++ix) {
            if (solid_.size() == 0 || solid_(ix, iz)) scale_n_m_ = std::max(scale_n_m_, rigidity_n_m(ix, iz));
        }
    }
    const bool jumps = problem != nullptr && problem->harmonic_x_n_m.size() != 0;
    for (Index iz = 0; iz < layout_.nz; ++iz) {
        const std::size_t j = size(iz) + PAD;
        for (Index ix = 0; ix < layout_.nx; ++ix) {
            const std::size_t c = layout_.at(ix, iz), i = size(ix) + PAD;
            const bool solid = solid_.size() == 0 || solid_(ix, iz);
            const double d = solid ? rigidity_n_m(ix, iz) / scale_n_m_ : FREE_EDGE;
            const double dx = jumps && solid ? problem->harmonic_x_n_m(ix, iz) / scale_n_m_ : d;
            const double dz = jumps && solid ? problem->harmonic_z_n_m(ix, iz) / scale_n_m_ : d;
            const double nu = poisson_[c], rest = 1.0 - nu * nu;
            const double area = x_.share[i] * z_.share[j];
            const double across = std::min(dx, dz);  // the laminate's stiffness across the jump
            // At a free end the other curvature takes the value that costs least: (1 - nu^2) is left.
            const double xx = dx <= dz ? dx : nu * nu * dz + rest * dx;
            const double zz = dz < dx ? dz : nu * nu * dx + rest * dz;
            xx_[c] = area * (z_.free[j] > 0.0 ? rest * d : xx);
            zz_[c] = area * (x_.free[i] > 0.0 ? rest * d : zz);
            xz_[c] = area * nu * across;
            twist_[c] = 2.0 * (1.0 - nu) * d;  // of the node, until the cells are made
        }
    }
    const auto s = size(layout_.stride());
    for (Index iz = 0; iz + 1 < layout_.nz; ++iz) {
        for (Index ix = 0; ix + 1 < layout_.nx; ++ix) {
            const std::size_t c = layout_.at(ix, iz);
            const double mean = 0.25 * ((twist_[c] + twist_[c + 1]) + (twist_[c + s] + twist_[c + s + 1]));
            twist_[c] = mean / (x_.cell[size(ix) + PAD] * z_.cell[size(iz) + PAD]);
        }
        twist_[layout_.at(layout_.nx - 1, iz)] = 0.0;
    }
    for (Index ix = 0; ix < layout_.nx; ++ix) twist_[layout_.at(ix, layout_.nz - 1)] = 0.0;
}

void Stencil::couple() {
    const auto s = size(layout_.stride());
    const double per_scale = 1.0 / scale_n_m_;
    for (Index iz = moving_.z0; iz < moving_.z1; ++iz) {
        const std::size_t j = size(iz) + PAD;
        for (Index ix = moving_.x0; ix < moving_.x1; ++ix) {
            const std::size_t c = layout_.at(ix, iz), i = size(ix) + PAD;
            const double xb = x_.before[i], xc = x_.centre[i], xa = x_.after[i];
            const double zc = z_.centre[j], za = z_.after[j];
            const double own = (xx_[c] * xc * xc + zz_[c] * zc * zc) + 2.0 * xz_[c] * xc * zc;
            const double from_x = xx_[c - 1] * x_.after[i - 1] * x_.after[i - 1] +
                                  xx_[c + 1] * x_.before[i + 1] * x_.before[i + 1];
            const double from_z = zz_[c - s] * z_.after[j - 1] * z_.after[j - 1] +
                                  zz_[c + s] * z_.before[j + 1] * z_.before[j + 1];
            const double ne = twist_[c], nw = twist_[c - 1], se = twist_[c - s], sw = twist_[c - s - 1];
            k_[CENTRE][c] = ((own + from_x) + (from_z + ((ne + nw) + (se + sw)))) +
                            foundation_[c] * per_scale * side_m_ * side_m_;
            k_[X1][c] = ((xx_[c] * xc + xz_[c] * zc) * xa +
                         (xx_[c + 1] * x_.centre[i + 1] + xz_[c + 1] * zc) * x_.before[i + 1]) -
                        (ne + se);
            k_[Z1][c] = ((zz_[c] * zc + xz_[c] * xc) * za +
                         (zz_[c + s] * z_.centre[j + 1] + xz_[c + s] * xc) * z_.before[j + 1]) -
                        (ne + nw);
            k_[X2][c] = xx_[c + 1] * x_.before[i + 1] * x_.after[i + 1];
            k_[Z2][c] = zz_[c + s] * z_.before[j + 1] * z_.after[j + 1];
            k_[ZP1][c] = (xz_[c + 1] * x_.before[i + 1] * za + xz_[c + s] * xa * z_.before[j + 1]) + ne;
            k_[ZM1][c] = (xz_[c - 1] * x_.after[i - 1] * za + xz_[c + s] * xb * z_.before[j + 1]) + nw;
        }
    }
    for (std::size_t k = X1; k < N_COUPLINGS; ++k) {  // an end that cannot move
        const Offset& o = OFFSETS[k];
        for (Index iz = moving_.z0; iz < moving_.z1; ++iz) {
            for (Index ix = moving_.x0; ix < moving_.x1; ++ix) {
                if (!moving_.holds(ix + o.dx, iz + o.dz)) k_[k][layout_.at(ix, iz)] = 0.0;
            }
        }
    }
}

void Stencil::apply(const double* x, double* y) const {
    std::array<std::ptrdiff_t, N_COUPLINGS> offset{};
    for (std::size_t k = 0; k < N_COUPLINGS; ++k)
        offset[k] = OFFSETS[k].dx + OFFSETS[k].dz * layout_.stride();
    for (Index iz = moving_.z0; iz < moving_.z1; ++iz) {
        const auto row = static_cast<std::ptrdiff_t>(layout_.at(0, iz));
        for (std::ptrdiff_t c = row + moving_.x0; c < row + moving_.x1; ++c) {
            double sum = k_[CENTRE][static_cast<std::size_t>(c)] * x[c];
            for (std::size_t k = X1; k < N_COUPLINGS; ++k) {
                const double* const coupling = k_[k].data();
                sum += coupling[c] * x[c + offset[k]] + coupling[c - offset[k]] * x[c - offset[k]];
            }
            y[c] = sum;
        }
    }
}

}  // namespace palpate::plate
