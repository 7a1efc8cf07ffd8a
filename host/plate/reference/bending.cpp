#include "host/plate/reference/bending.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::reference {
namespace {

/// w_xx + nu w_zz and sqrt(1 - nu^2) w_zz, weighted.
void add_node(LeastSquares& energy, const Grid& grid, std::size_t ix, std::size_t iz) {
    const double poisson = grid.plate.poisson;
    const double weight = std::sqrt(grid.rigidity(ix, iz) * grid.hx * grid.hz);
    const auto second = [&](Unknown low, Unknown high, double f) {
        return Terms{{low, f}, {grid.deflection(ix, iz), -2.0 * f}, {high, f}};
    };
    const auto along_z = [&](double f) {
        return second(grid.deflection(ix, iz - 1), grid.deflection(ix, iz + 1), f / grid.hz / grid.hz);
    };
    Terms sum = second(grid.deflection(ix - 1, iz), grid.deflection(ix + 1, iz), weight / grid.hx / grid.hx);
    for (const Term& term : along_z(weight * poisson)) sum.push_back(term);
    energy.add({{.linear = sum, .products = {}},
                {.linear = along_z(weight * std::sqrt(1.0 - poisson * poisson)), .products = {}}});
}

/// On a clamped edge the curvature is 2 w_1/h^2 (mirrored ghost) over half a cell.
void add_edge_node(LeastSquares& energy, const Grid& grid, double rigidity, Unknown inner, double spacing) {
    const double factor = 2.0 * std::sqrt(0.5 * rigidity * grid.hx * grid.hz) / spacing / spacing;
    energy.add({{.linear = {{inner, factor}}, .products = {}}});
}

void add_edges(LeastSquares& energy, const Grid& grid) {
    const std::size_t last_x = grid.plate.nx - 1;
    const std::size_t last_z = grid.plate.nz - 1;
    for (std::size_t iz = 1; iz < last_z; ++iz) {
        add_edge_node(energy, grid, grid.rigidity(0, iz), grid.deflection(1, iz), grid.hx);
        add_edge_node(energy, grid, grid.rigidity(last_x, iz), grid.deflection(last_x - 1, iz), grid.hx);
    }
    for (std::size_t ix = 1; ix < last_x; ++ix) {
        add_edge_node(energy, grid, grid.rigidity(ix, 0), grid.deflection(ix, 1), grid.hz);
        add_edge_node(energy, grid, grid.rigidity(ix, last_z), grid.deflection(ix, last_z - 1), grid.hz);
    }
}

/// Twist.
void add_cell(LeastSquares& energy, const Grid& grid, std::size_t ix, std::size_t iz) {
    const double area = grid.hx * grid.hz;
    const double stiffness = 2.0 * (1.0 - grid.plate.poisson) * grid.cell_rigidity(ix, iz);
    const double f = std::sqrt(stiffness * area) / area;
    energy.add({{.linear = {{grid.deflection(ix + 1, iz + 1), f},
                            {grid.deflection(ix + 1, iz), -f},
                            {grid.deflection(ix, iz + 1), -f},
                            {grid.deflection(ix, iz), f}},
                 .products = {}}});
}

void add_foundation(LeastSquares& energy, const Grid& grid, std::size_t ix, std::size_t iz) {
    if (grid.plate.foundation_n_per_m3.empty()) return;
    const double side2 = grid.plate.size_x_m * grid.plate.size_x_m;
    const double pressure =
        grid.plate.foundation_n_per_m3[grid.node(ix, iz)] * side2 * side2 / grid.rigidity_max_n_m;
    energy.add(
        {{.linear = {{grid.deflection(ix, iz), std::sqrt(pressure * grid.hx * grid.hz)}}, .products = {}}});
}

}  // namespace

Grid::Grid(const Plate& of)
    : plate(of),
      hx(1.0 / static_cast<double>(of.nx - 1)),
      hz(of.size_z_m / of.size_x_m / static_cast<double>(of.nz - 1)),
      rigidity_max_n_m(*std::max_element(of.rigidity_n_m.begin(), of.rigidity_n_m.end())) {}

double Grid::cell_rigidity(std::size_t ix, std::size_t iz) const {
    return (rigidity(ix, iz) + rigidity(ix + 1, iz) + rigidity(ix, iz + 1) + rigidity(ix + 1, iz + 1)) / 4.0;
}

void add_bending(LeastSquares& energy, const Grid& grid) {
    for (std::size_t ix = 1; ix + 1 < grid.plate.nx; ++ix) {
        for (std::size_t iz = 1; iz + 1 < grid.plate.nz; ++iz) {
            add_node(energy, grid, ix, iz);
            add_foundation(energy, grid, ix, iz);
        }
    }
    add_edges(energy, grid);
    for (std::size_t ix = 0; ix + 1 < grid.plate.nx; ++ix) {
        for (std::size_t iz = 0; iz + 1 < grid.plate.nz; ++iz) add_cell(energy, grid, ix, iz);
    }
}

}  // namespace palpate::reference
