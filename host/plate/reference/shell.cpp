#include "host/plate/reference/shell.hpp"

#include <cmath>

#include "host/plate/reference/bending.hpp"
#include "host/plate/reference/press.hpp"

namespace palpate::reference {
namespace {

/// Membrane strains on the grid of the bending.
class Membrane {
public:
    Membrane(const Shell& shell, const Grid& grid) : shell_(shell), grid_(grid) {
        const double size2 = shell.plate.size_x_m * shell.plate.size_x_m;
        curvature_x_ = shell.curvature_x_per_m * size2 / shell.thickness_m;
        curvature_z_ = shell.curvature_z_per_m * size2 / shell.thickness_m;
    }

    void add(LeastSquares& energy, Strain strain) const {
        for (std::size_t ix = 0; ix + 1 < grid_.plate.nx; ++ix) {
            for (std::size_t iz = 0; iz + 1 < grid_.plate.nz; ++iz) add_cell(energy, strain, ix, iz);
        }
    }

private:
    [[nodiscard]] Unknown along_x(std::size_t ix, std::size_t iz) const { return in_plane(ix, iz, 1); }
    [[nodiscard]] Unknown along_z(std::size_t ix, std::size_t iz) const { return in_plane(ix, iz, 2); }

    /// A free edge leaves the plate's rigid motions in its plane: (0, 0) holds both displacements, the far
    /// end of its row the turn.
    [[nodiscard]] Unknown in_plane(std::size_t ix, std::size_t iz, std::size_t which) const {
        const bool held = shell_.edge == Edge::fixed
                              ? grid_.on_edge(ix, iz)
                              : iz == 0 && (ix == 0 || (ix + 1 == grid_.plate.nx && which == 2));
        return held ? ZERO : which * grid_.nodes() + grid_.node(ix, iz);
    }

    /// du/ds + (dw/ds)^2/2 - kappa w on a grid edge between two nodes, times `f`.
    static Residual stretch(Unknown w0, Unknown w1, Unknown u0, Unknown u1, double spacing, double curvature,
                            double f) {
        const double bend = -0.5 * f * curvature;
        const Terms slope{{w0, -1.0 / spacing}, {w1, 1.0 / spacing}};
        const Terms half_slope{{w0, -0.5 * f / spacing}, {w1, 0.5 * f / spacing}};
        return {.linear = {{u0, -f / spacing}, {u1, f / spacing}, {w0, bend}, {w1, bend}},
                .products = {{half_slope, slope}}};
    }
    [[nodiscard]] Residual stretch_x(std::size_t ix, std::size_t iz, double f) const {
        return stretch(grid_.deflection(ix, iz), grid_.deflection(ix + 1, iz), along_x(ix, iz),
                       along_x(ix + 1, iz), grid_.hx, curvature_x_, f);
    }
    [[nodiscard]] Residual stretch_z(std::size_t ix, std::size_t iz, double f) const {
        return stretch(grid_.deflection(ix, iz), grid_.deflection(ix, iz + 1), along_z(ix, iz),
                       along_z(ix, iz + 1), grid_.hz, curvature_z_, f);
    }

    /// du/dz + dv/dx + dw/dx dw/dz at the middle of a cell, times `f`.
    [[nodiscard]] Residual shear(std::size_t ix, std::size_t iz, double f) const {
        const double x = 0.5 / grid_.hx;
        const double z = 0.5 / grid_.hz;
        Residual residual{.linear = {}, .products = {{}}};
        for (const std::size_t jx : {0U, 1U}) {
            for (const std::size_t jz : {0U, 1U}) {
                const double sx = jx == 1 ? x : -x;
                const double sz = jz == 1 ? z : -z;
                residual.linear.push_back({along_x(ix + jx, iz + jz), f * sz});
                residual.linear.push_back({along_z(ix + jx, iz + jz), f * sx});
                residual.products[0].first.push_back({grid_.deflection(ix + jx, iz + jz), f * sx});
                residual.products[0].second.push_back({grid_.deflection(ix + jx, iz + jz), sz});
            }
        }
        return residual;
    }

    /// Each corner takes the strains of the two grid edges that meet there.
    void add_cell(LeastSquares& energy, Strain strain, std::size_t ix, std::size_t iz) const {
        const double poisson = grid_.plate.poisson;
        const double stiffness = 12.0 * grid_.cell_rigidity(ix, iz) * grid_.hx * grid_.hz;
        const double corner = std::sqrt(0.25 * stiffness);
        std::vector<Residual> residuals{shear(ix, iz, std::sqrt(0.5 * (1.0 - poisson) * stiffness))};
        for (const std::size_t jx : {0U, 1U}) {
            for (const std::size_t jz : {0U, 1U}) {
                Residual sum = stretch_x(ix, iz + jz, corner);
                const Residual across = stretch_z(ix + jx, iz, corner * poisson);
                sum.linear.insert(sum.linear.end(), across.linear.begin(), across.linear.end());
                sum.products.push_back(across.products[0]);
                residuals.push_back(std::move(sum));
                residuals.push_back(stretch_z(ix + jx, iz, corner * std::sqrt(1.0 - poisson * poisson)));
            }
        }
        if (strain == Strain::linear) {
            for (Residual& residual : residuals) residual.products.clear();
        }
        energy.add(residuals);
    }

    const Shell& shell_;
    const Grid& grid_;
    double curvature_x_;
    double curvature_z_;
};

}  // namespace

Pressed press(const Shell& shell, std::span<const double> depths_m) {
    const Plate& plate = shell.plate;
    const Grid grid(plate);
    const Membrane membrane(shell, grid);
    const Model model{.unknowns = 3 * grid.nodes(),
                      .deflections = grid.nodes(),
                      .contact = grid.deflection(plate.contact_ix, plate.contact_iz),
                      .add = [&](LeastSquares& energy, Strain strain) {
                          add_bending(energy, grid);
                          membrane.add(energy, strain);
                      }};
    return press(model, {shell.thickness_m, plate.size_x_m, grid.rigidity_max_n_m}, depths_m);
}

}  // namespace palpate::reference
