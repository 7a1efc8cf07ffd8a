#include "host/plate/stencil.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::plate {
namespace {

using Eigen::Index;

constexpr auto PAD = static_cast<std::size_t>(Layout::PADDING);

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

/// The curvature at an end: mirrored ghost, odd ghost, or whatever costs least (MATH.md eq. 30).
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

// Rows are worked on in plain loops over pointers that do not overlap, which every compiler makes vectors of.

double largest(const double* values, const bool* solid, std::size_t n) {
    constexpr std::size_t LANES = 8;
    std::array<double, LANES> most{};
    std::size_t i = 0;
    if (solid == nullptr) {
        for (; i + LANES <= n; i += LANES) {
            for (std::size_t k = 0; k < LANES; ++k)
                most[k] = most[k] < values[i + k] ? values[i + k] : most[k];
        }
    }
    double all = 0.0;
    for (; i < n; ++i) {
        if (solid == nullptr || solid[i]) all = std::max(all, values[i]);
    }
    for (const double value : most) all = std::max(all, value);
    return all;
}

void scale_row(const double* __restrict from, const bool* solid, std::size_t n, double scale,
               double* __restrict to) {
    for (std::size_t i = 0; i < n; ++i) to[i] = from[i] / scale;
    if (solid == nullptr) return;
    for (std::size_t i = 0; i < n; ++i) {
        if (!solid[i]) to[i] = FREE_EDGE;
    }
}

/// What multiplies the squares of a row of nodes, or of cells.
struct RowWeights {
    double *xx, *zz, *xz, *twist;
};

/// twist: of the nodes, until the cells are made.
void weigh_row(const RowWeights& to, const double* __restrict d, const double* __restrict poisson,
               const double* __restrict share_x, double share_z, std::size_t n) {
    double* const __restrict xx = to.xx;
    double* const __restrict zz = to.zz;
    double* const __restrict xz = to.xz;
    double* const __restrict twist = to.twist;
    for (std::size_t i = 0; i < n; ++i) {
        const double weight = share_x[i] * share_z * d[i];
        xx[i] = weight;
        zz[i] = weight;
        xz[i] = weight * poisson[i];
        twist[i] = 2.0 * (1.0 - poisson[i]) * d[i];
    }
}

/// Mean of four nodes over the cell's area; `row` becomes that of the cells.
void twist_of_cells(double* __restrict row, const double* __restrict next, const double* __restrict cell_x,
                    double cell_z, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
        const double mean = 0.25 * ((row[i] + row[i + 1]) + (next[i] + next[i + 1]));
        row[i] = mean / (cell_x[i] * cell_z);
    }
}

// What one row of couplings is made of (MATH.md eq. 30): all begin at the row's first node.
struct LineView {
    const double *before, *centre, *after;
};
struct WeightView {
    const double *xx, *zz, *xz, *twist;
};
/// Second differences across the row: `_up` of the next row, `_down` of the one before.
struct RowView {
    double before_up, centre, centre_up, after_down, after, after_up;
};

void couple_centre(double* __restrict k, const WeightView& w, std::ptrdiff_t s, const LineView& x,
                   const RowView& z, std::size_t n) {
    const double *const xx = w.xx, *const zz = w.zz, *const xz = w.xz, *const twist = w.twist;
    const double *const xb = x.before + 1, *const xc = x.centre, *const xa = x.after - 1;
    const double *const xx_left = xx - 1, *const twist_left = twist - 1;
    for (std::size_t i = 0; i < n; ++i) {
        const double own =
            (xx[i] * xc[i] * xc[i] + zz[i] * z.centre * z.centre) + 2.0 * xz[i] * xc[i] * z.centre;
        const double from_x = xx_left[i] * xa[i] * xa[i] + xx[i + 1] * xb[i] * xb[i];
        const double from_z =
            (zz - s)[i] * z.after_down * z.after_down + (zz + s)[i] * z.before_up * z.before_up;
        k[i] =
            (own + from_x) + (from_z + ((twist[i] + twist_left[i]) + ((twist - s)[i] + (twist_left - s)[i])));
    }
}

void couple_along_x(double* __restrict k1, double* __restrict k2, const WeightView& w, std::ptrdiff_t s,
                    const LineView& x, const RowView& z, std::size_t n) {
    const double *const xx = w.xx, *const xz = w.xz, *const twist = w.twist, *const twist_down = twist - s;
    for (std::size_t i = 0; i < n; ++i) {
        k1[i] = ((xx[i] * x.centre[i] + xz[i] * z.centre) * x.after[i] +
                 (xx[i + 1] * x.centre[i + 1] + xz[i + 1] * z.centre) * x.before[i + 1]) -
                (twist[i] + twist_down[i]);
        k2[i] = xx[i + 1] * x.before[i + 1] * x.after[i + 1];
    }
}

void couple_to_next(const std::array<double*, N_COUPLINGS>& k, const WeightView& w, std::ptrdiff_t s,
                    const LineView& x, const RowView& z, std::size_t n) {
    double* const __restrict z1 = k[Z1];
    double* const __restrict z2 = k[Z2];
    double* const __restrict zp1 = k[ZP1];
    double* const __restrict zm1 = k[ZM1];
    const double *const zz = w.zz, *const zz_up = zz + s, *const xz = w.xz, *const xz_up = xz + s;
    const double *const twist = w.twist, *const twist_left = twist - 1;
    const double *const xz_left = xz - 1, *const xa_left = x.after - 1;
    for (std::size_t i = 0; i < n; ++i) {
        z1[i] = ((zz[i] * z.centre + xz[i] * x.centre[i]) * z.after +
                 (zz_up[i] * z.centre_up + xz_up[i] * x.centre[i]) * z.before_up) -
                (twist[i] + twist_left[i]);
        z2[i] = zz_up[i] * z.before_up * z.after_up;
        zp1[i] = (xz[i + 1] * x.before[i + 1] * z.after + xz_up[i] * x.after[i] * z.before_up) + twist[i];
        zm1[i] = (xz_left[i] * xa_left[i] * z.after + xz_up[i] * x.before[i] * z.before_up) + twist_left[i];
    }
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
      twist_(xx_),
      node_(size(layout_.nx), 0.0) {
    x_ = make_lines(lines_over_side(problem.lines_x_m, layout_.nx, problem.size_m.x(), side_m_),
                    problem.edges[0], problem.edges[1]);
    z_ = make_lines(lines_over_side(problem.lines_z_m, layout_.nz, problem.size_m.y(), side_m_),
                    problem.edges[2], problem.edges[3]);
    k_.assign(N_COUPLINGS * layout_.size(), 0.0);
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
    weigh(problem.rigidity_n_m);
    if (problem.harmonic_x_n_m.size() != 0) laminate(problem);
    couple();
}

void Stencil::set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) {
    weigh(rigidity_n_m);
    couple();
}

void Stencil::weigh(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) {
    const auto nx = size(layout_.nx), nz = size(layout_.nz);
    const auto solid_row = [&](std::size_t iz) {
        return solid_.size() == 0 ? nullptr : &solid_(0, Index(iz));
    };
    scale_n_m_ = 0.0;
    for (std::size_t iz = 0; iz < nz; ++iz)
        scale_n_m_ = std::max(
            scale_n_m_,
            largest(rigidity_n_m.data() + Index(iz) * rigidity_n_m.outerStride(), solid_row(iz), nx));
    for (std::size_t iz = 0; iz < nz; ++iz) {
        const std::size_t row = layout_.at(0, Index(iz));
        const double share = z_.share[iz + PAD];
        double* const __restrict d = node_.data();
        scale_row(rigidity_n_m.data() + Index(iz) * rigidity_n_m.outerStride(), solid_row(iz), nx, scale_n_m_,
                  d);
        weigh_row({xx_.data() + row, zz_.data() + row, xz_.data() + row, twist_.data() + row}, d,
                  poisson_.data() + row, x_.share.data() + PAD, share, nx);
        // At a free end the other curvature takes the value that costs least: (1 - nu^2) is left.
        const auto rest = [&](std::size_t c) { return 1.0 - poisson_[c] * poisson_[c]; };
        for (const std::size_t ix : {std::size_t{0}, nx - 1})
            if (x_.free[ix + PAD] > 0.0) zz_[row + ix] *= rest(row + ix);
        if (!(z_.free[iz + PAD] > 0.0)) continue;
        for (std::size_t ix = 0; ix < nx; ++ix) xx_[row + ix] *= rest(row + ix);
    }
    for (std::size_t iz = 0; iz + 1 < nz; ++iz) {
        double* const row = twist_.data() + layout_.at(0, Index(iz));
        twist_of_cells(row, row + layout_.stride(), x_.cell.data() + PAD, z_.cell[iz + PAD], nx - 1);
        row[nx - 1] = 0.0;
    }
    std::fill_n(twist_.data() + layout_.at(0, layout_.nz - 1), nx, 0.0);
}

void Stencil::laminate(const Problem& problem) {
    for (Index iz = 0; iz < layout_.nz; ++iz) {
        const std::size_t j = size(iz) + PAD;
        for (Index ix = 0; ix < layout_.nx; ++ix) {
            if (solid_.size() != 0 && !solid_(ix, iz)) continue;
            const std::size_t c = layout_.at(ix, iz), i = size(ix) + PAD;
            const double d = problem.rigidity_n_m(ix, iz) / scale_n_m_;
            const double dx = problem.harmonic_x_n_m(ix, iz) / scale_n_m_;
            const double dz = problem.harmonic_z_n_m(ix, iz) / scale_n_m_;
            const double nu = poisson_[c], rest = 1.0 - nu * nu;
            const double area = x_.share[i] * z_.share[j];
            const double across = std::min(dx, dz);  // the laminate's stiffness across the jump
            const double xx = dx <= dz ? dx : nu * nu * dz + rest * dx;
            const double zz = dz <= dx ? dz : nu * nu * dx + rest * dz;
            xx_[c] = area * (z_.free[j] > 0.0 ? rest * d : xx);
            zz_[c] = area * (x_.free[i] > 0.0 ? rest * d : zz);
            xz_[c] = area * nu * across;
        }
    }
}

void Stencil::couple() {
    const auto s = layout_.stride();
    const auto n = size(moving_.x1 - moving_.x0);
    const double foundation = 1.0 / scale_n_m_ * side_m_ * side_m_;
    const auto i = size(moving_.x0) + PAD;
    const LineView x{x_.before.data() + i, x_.centre.data() + i, x_.after.data() + i};
    for (Index iz = moving_.z0; iz < moving_.z1; ++iz) {
        const auto c = static_cast<std::ptrdiff_t>(layout_.at(moving_.x0, iz));
        const auto j = size(iz) + PAD;
        const WeightView weight{xx_.data() + c, zz_.data() + c, xz_.data() + c, twist_.data() + c};
        const RowView row{z_.before[j + 1], z_.centre[j], z_.centre[j + 1],
                          z_.after[j - 1],  z_.after[j],  z_.after[j + 1]};
        std::array<double*, N_COUPLINGS> k{};
        for (std::size_t m = 0; m < N_COUPLINGS; ++m) k[m] = k_.data() + m * layout_.size() + c;
        couple_centre(k[CENTRE], weight, s, x, row, n);
        for (std::size_t m = 0; m < n; ++m) k[CENTRE][m] += foundation_[size(c) + m] * foundation;
        couple_along_x(k[X1], k[X2], weight, s, x, row, n);
        couple_to_next(k, weight, s, x, row, n);
    }
    cut_ends();
}

/// Couplings to an end that cannot move.
void Stencil::cut_ends() {
    for (std::size_t m = X1; m < N_COUPLINGS; ++m) {
        const Offset& o = OFFSETS[m];
        double* const k = k_.data() + m * layout_.size();
        for (Index iz = moving_.z0; iz < moving_.z1; ++iz) {
            const bool all = iz + o.dz >= moving_.z1;
            const Index low = all ? moving_.x1 : moving_.x0 - std::min<Index>(o.dx, 0);
            const Index high = all ? moving_.x1 : moving_.x1 - std::max<Index>(o.dx, 0);
            std::fill(k + layout_.at(moving_.x0, iz), k + layout_.at(low, iz), 0.0);
            std::fill(k + layout_.at(high, iz), k + layout_.at(moving_.x1, iz), 0.0);
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
            double sum = k_[static_cast<std::size_t>(c)] * x[c];
            for (std::size_t k = X1; k < N_COUPLINGS; ++k) {
                const double* const coupling = k_.data() + k * layout_.size();
                sum += coupling[c] * x[c + offset[k]] + coupling[c - offset[k]] * x[c - offset[k]];
            }
            y[c] = sum;
        }
    }
}

}  // namespace palpate::plate
