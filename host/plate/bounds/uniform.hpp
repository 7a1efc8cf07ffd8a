/// The uniform plate in extended precision: what the members and their modes are made with.
#pragma once
#include <cmath>
#include <cstddef>
#include <vector>

#include "host/plate/bounds/member.hpp"

namespace palpate::plate::bounds {

using Real = long double;
using Vector = std::vector<Real>;

constexpr double UP = 1.0 + 0x1p-50;  ///< to be above what a few operations in double make

[[nodiscard]] Real inner(const Vector& a, const Vector& b);

/// D = 1, k_f = k0. Deflections and forces padded; strains and stresses in rows of B.
struct Uniform {
    const Setting* setting;
    const Plate* plate;
    Real k0;

    [[nodiscard]] std::size_t n() const { return setting->strains.grid().size(); }
    [[nodiscard]] Vector strain(const Vector& w) const;
    [[nodiscard]] Vector force(const Vector& stress) const;
    /// A strain becomes a stress.
    void weigh(Vector& rows) const;
    /// a' diag(d)^-1 b of stresses. Without a foundation it carries none.
    [[nodiscard]] Real stress_product(const Vector& a, const Vector& b) const;
    /// K^-1 f, rounded to double: what is stored.
    [[nodiscard]] Vector solve(const Vector& f) const;
    /// Brings a stress into balance with the load to the last bits of double, which it is rounded to.
    void balance(Vector& stress, const Vector& load) const;
    /// (r'K^-1 r)^1/2 of r = B's - load, at most: twice what the factor gives, and what rounding may hide
    /// from r.
    [[nodiscard]] double imbalance(const Vector& stress, const Vector& load) const;
    /// The most that rounding may have done to each strain of w.
    [[nodiscard]] Vector slips(const Vector& w) const;

private:
    [[nodiscard]] Vector residual(const Vector& stress, const Vector& load) const;
};

/// a_i b_i of rows of B summed to the nodes: a cell's quarter goes to each of its corners (MATH.md section
/// 17). Padded.
[[nodiscard]] Vector bending_at_nodes(const Padded& grid, const Vector& a, const Vector& b);
[[nodiscard]] Vector foundation_at_nodes(const Padded& grid, const Vector& a, const Vector& b);
[[nodiscard]] std::vector<double> nodes_of(const Padded& grid, const Vector& padded);

}  // namespace palpate::plate::bounds
