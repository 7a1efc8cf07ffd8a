#include "host/study/extended.hpp"

#include <algorithm>
#include <array>
#include <cfloat>
#include <limits>
#include <span>
#include <vector>

namespace palpate::study {
namespace {

using Eigen::Index;

#if LDBL_MANT_DIG >= 113
using Wide = long double;
#else
__extension__ typedef __float128 Wide;
#endif

constexpr double NO_PLATE = 1e-6;  ///< of the largest D (MATH.md section 9)
constexpr std::size_t NOWHERE = std::numeric_limits<std::size_t>::max();

struct Term {
    std::size_t unknown;
    Wide factor;
};

/// Lower half of a banded symmetric matrix, row by row.
class Band {
public:
    Band(std::size_t n, std::size_t width) : n_(n), width_(width), entries_(n * (width + 1), Wide(0)) {}

    /// weight (sum of terms)^2.
    void add_square(Wide weight, std::span<const Term> terms) {
        for (const Term& a : terms) {
            for (const Term& b : terms) {
                if (a.unknown == NOWHERE || b.unknown == NOWHERE || b.unknown > a.unknown) continue;
                at(a.unknown, b.unknown) += weight * a.factor * b.factor;
            }
        }
    }
    /// K = L D L' in place, then e'K^-1 e of one unknown.
    Wide compliance(std::size_t unknown) {
        factor();
        std::vector<Wide> x(n_, Wide(0));
        x[unknown] = Wide(1);
        Wide sum(0);
        for (std::size_t i = unknown; i < n_; ++i) {  // e'K^-1 e = sum y_i^2/d_i, L y = e
            for (std::size_t j = std::max(first_of(i), unknown); j < i; ++j) x[i] -= at(i, j) * x[j];
            sum += x[i] * x[i] / at(i, i);
        }
        return sum;
    }

private:
    [[nodiscard]] std::size_t first_of(std::size_t row) const { return row > width_ ? row - width_ : 0; }
    Wide& at(std::size_t row, std::size_t column) {
        return entries_[row * (width_ + 1) + (column + width_ - row)];
    }
    void factor() {
        std::vector<Wide> scaled(width_ + 1);
        for (std::size_t i = 0; i < n_; ++i) {
            const std::size_t first = first_of(i);
            for (std::size_t j = first; j < i; ++j) {
                Wide value = at(i, j);
                for (std::size_t k = std::max(first, first_of(j)); k < j; ++k)
                    value -= scaled[k - first] * at(j, k);
                scaled[j - first] = value;
                at(i, j) = value / at(j, j);
            }
            for (std::size_t k = first; k < i; ++k) at(i, i) -= scaled[k - first] * at(i, k);
        }
    }

    std::size_t n_, width_;
    std::vector<Wide> entries_;
};

/// The squares of a problem's energy, lengths in m, D in N m.
class Energy {
public:
    explicit Energy(const plate::Problem& problem)
        : p_(problem),
          nx_(problem.rigidity_n_m.rows()),
          nz_(problem.rigidity_n_m.cols()),
          hx_(Wide(problem.size_m.x()) / Wide(nx_ - 1)),
          hz_(Wide(problem.size_m.y()) / Wide(nz_ - 1)) {
        for (Index iz = 0; iz < nz_; ++iz) {
            for (Index ix = 0; ix < nx_; ++ix) {
                if (solid(ix, iz)) largest_ = std::max(largest_, p_.rigidity_n_m(ix, iz));
            }
        }
    }

    Wide centre_compliance() {
        Band band(static_cast<std::size_t>((nx_ - 2) * (nz_ - 2)),
                  static_cast<std::size_t>(2 * (std::min(nx_, nz_) - 2)));
        for (Index iz = 0; iz < nz_; ++iz) {
            for (Index ix = 0; ix < nx_; ++ix) add_node(band, ix, iz);
        }
        for (Index iz = 0; iz + 1 < nz_; ++iz) {
            for (Index ix = 0; ix + 1 < nx_; ++ix) add_cell(band, ix, iz);
        }
        return band.compliance(unknown(nx_ / 2, nz_ / 2));
    }

private:
    [[nodiscard]] bool solid(Index ix, Index iz) const { return p_.solid.size() == 0 || p_.solid(ix, iz); }
    [[nodiscard]] Wide rigidity(Index ix, Index iz) const {
        return solid(ix, iz) ? Wide(p_.rigidity_n_m(ix, iz)) : Wide(NO_PLATE) * Wide(largest_);
    }
    [[nodiscard]] Wide poisson(Index ix, Index iz) const {
        return Wide(p_.poisson_at_nodes.size() == 0 ? p_.poisson : p_.poisson_at_nodes(ix, iz));
    }
    [[nodiscard]] std::size_t unknown(Index ix, Index iz) const {
        const bool inside = ix > 0 && iz > 0 && ix + 1 < nx_ && iz + 1 < nz_;
        if (!inside) return NOWHERE;
        return static_cast<std::size_t>(nz_ <= nx_ ? (ix - 1) * (nz_ - 2) + (iz - 1)
                                                   : (iz - 1) * (nx_ - 2) + (ix - 1));
    }
    /// d_xx (1, 0) or d_zz (0, 1) at a node; at an edge the ghost beyond it mirrors.
    [[nodiscard]] std::array<Term, 3> curvature(Index ix, Index iz, Index dx, Index dz) const {
        const Wide f = Wide(1) / (dx != 0 ? hx_ * hx_ : hz_ * hz_);
        const Index at = dx != 0 ? ix : iz, last = (dx != 0 ? nx_ : nz_) - 1;
        const Wide low = at == last ? Wide(2) * f : f, high = at == 0 ? Wide(2) * f : f;
        return {{{unknown(ix - dx, iz - dz), low},
                 {unknown(ix, iz), Wide(-2) * f},
                 {unknown(ix + dx, iz + dz), high}}};
    }

    /// D [(d_xx + nu d_zz)^2 + (1 - nu^2) d_zz^2], and the foundation.
    void add_node(Band& band, Index ix, Index iz) const {
        const bool edge_x = ix == 0 || ix + 1 == nx_, edge_z = iz == 0 || iz + 1 == nz_;
        if (edge_x && edge_z) return;
        Wide area = hx_ * hz_;
        if (edge_x || edge_z) area = area / Wide(2);
        const Wide weight = area * rigidity(ix, iz), nu = poisson(ix, iz);
        const auto x = curvature(ix, iz, 1, 0), z = curvature(ix, iz, 0, 1);
        if (edge_x) return band.add_square(weight, x);  // w = 0 along the edge: d_zz is 0 there
        if (edge_z) return band.add_square(weight, z);
        const std::array<Term, 5> both{{x[0],
                                        {x[1].unknown, x[1].factor + nu * z[1].factor},
                                        x[2],
                                        {z[0].unknown, nu * z[0].factor},
                                        {z[2].unknown, nu * z[2].factor}}};
        band.add_square(weight, both);
        band.add_square(weight * (Wide(1) - nu * nu), z);
        if (p_.foundation_n_per_m3.size() == 0 || !solid(ix, iz)) return;
        const std::array<Term, 1> own{{{unknown(ix, iz), Wide(1)}}};
        band.add_square(area * Wide(p_.foundation_n_per_m3(ix, iz)), own);
    }

    /// 2 (1 - nu) D d_xz^2, the mean of its corners.
    void add_cell(Band& band, Index ix, Index iz) const {
        Wide sum(0);
        for (const Index jx : {ix, ix + 1}) {
            for (const Index jz : {iz, iz + 1}) sum += (Wide(1) - poisson(jx, jz)) * rigidity(jx, jz);
        }
        const std::array<Term, 4> corners{{{unknown(ix, iz), Wide(1)},
                                           {unknown(ix + 1, iz), Wide(-1)},
                                           {unknown(ix, iz + 1), Wide(-1)},
                                           {unknown(ix + 1, iz + 1), Wide(1)}}};
        band.add_square(sum / Wide(2) / (hx_ * hz_), corners);
    }

    const plate::Problem& p_;
    Index nx_, nz_;
    Wide hx_, hz_;
    double largest_ = 0.0;
};

}  // namespace

double extended_centre_compliance_m_per_n(const plate::Problem& problem) {
    if (const auto words = plate::problem_with(problem)) throw std::invalid_argument(*words);
    const bool plain = problem.lines_x_m.size() == 0 && problem.lines_z_m.size() == 0 &&
                       problem.harmonic_x_n_m.size() == 0 && problem.edges == std::array<plate::Edge, 4>{};
    if (!plain || problem.rigidity_n_m.rows() % 2 == 0 || problem.rigidity_n_m.cols() % 2 == 0)
        throw std::invalid_argument("extended precision needs clamped edges, an even grid and a centre node");
    return static_cast<double>(Energy(problem).centre_compliance());
}

}  // namespace palpate::study
