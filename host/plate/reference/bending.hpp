/// Bending of a clamped plate as residuals.
#pragma once
#include <cstddef>

#include "host/plate/reference/least_squares.hpp"
#include "host/plate/reference/linear.hpp"

namespace palpate::reference {

/// The plate's grid in lengths over size_x, with D over its largest value.
struct Grid {
    explicit Grid(const Plate& plate);

    [[nodiscard]] std::size_t nodes() const { return plate.nx * plate.nz; }
    [[nodiscard]] std::size_t node(std::size_t ix, std::size_t iz) const { return ix * plate.nz + iz; }
    [[nodiscard]] bool on_edge(std::size_t ix, std::size_t iz) const {
        return ix == 0 || iz == 0 || ix + 1 == plate.nx || iz + 1 == plate.nz;
    }
    /// The deflections are the first nodes() unknowns.
    [[nodiscard]] Unknown deflection(std::size_t ix, std::size_t iz) const {
        return on_edge(ix, iz) ? ZERO : node(ix, iz);
    }
    [[nodiscard]] double rigidity(std::size_t ix, std::size_t iz) const {
        return plate.rigidity_n_m[node(ix, iz)] / rigidity_max_n_m;
    }
    /// Mean of the corners of the cell whose lowest is (ix, iz).
    [[nodiscard]] double cell_rigidity(std::size_t ix, std::size_t iz) const;

    const Plate& plate;
    double hx;
    double hz;
    double rigidity_max_n_m;
};

/// Curvature at the nodes, on the edges and in the cells, and the foundation: J'J = K of MATH.md eq. 2-4.
void add_bending(LeastSquares& energy, const Grid& grid);

}  // namespace palpate::reference
