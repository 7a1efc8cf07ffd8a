#include "host/plate/reference/square.hpp"

#include <array>
#include <cmath>

#include "host/plate/reference/hermite.hpp"
#include "host/plate/reference/press.hpp"

namespace palpate::reference {
namespace {

/// w, then the displacements along x and along z; the place of each in the list of unknowns.
enum Field : std::size_t { W, U, V };

/// Lengths over half a side. A node has, of each field, the value and the derivatives by x, z and xz.
class Quarter {
public:
    explicit Quarter(const Square& square) : square_(square), nodes_(square.elements + 1) {
        const double half2 = 0.25 * square.side_m * square.side_m;
        curvature_x_ = square.curvature_x_per_m * half2 / square.thickness_m;
        curvature_z_ = square.curvature_z_per_m * half2 / square.thickness_m;
    }

    [[nodiscard]] std::size_t unknowns_of_field() const { return 4 * nodes_ * nodes_; }

    void add(LeastSquares& energy, Strain strain) const {
        for (std::size_t ix = 0; ix < square_.elements; ++ix) {
            for (std::size_t iz = 0; iz < square_.elements; ++iz) add_element(energy, strain, ix, iz);
        }
    }

private:
    struct Point {
        std::size_t ix;  ///< of the element
        std::size_t iz;
        HermiteShape x;
        HermiteShape z;
    };

    /// Symmetry: w is even in x and z, u odd in x and even in z, v the other way round. The edge at 1.
    [[nodiscard]] bool vanishes(Field field, std::size_t node, std::size_t order, bool odd) const {
        const bool in_plane = field != W;
        if (node == 0) return (order == 1) != odd;
        return node == square_.elements && (!in_plane || (square_.edge == Edge::fixed && order == 0));
    }
    [[nodiscard]] Unknown unknown(Field field, std::size_t jx, std::size_t jz, std::size_t order_x,
                                  std::size_t order_z) const {
        if (vanishes(field, jx, order_x, field == U) || vanishes(field, jz, order_z, field == V)) return ZERO;
        return field * unknowns_of_field() + 4 * (jx * nodes_ + jz) + 2 * order_x + order_z;
    }

    /// A derivative of a field at a point, times `f`, behind `terms`.
    void append(Terms& terms, const Point& at, Field field, std::size_t by_x, std::size_t by_z,
                double f) const {
        for (std::size_t kx = 0; kx < 4; ++kx) {
            for (std::size_t kz = 0; kz < 4; ++kz) {
                terms.push_back({unknown(field, at.ix + kx / 2, at.iz + kz / 2, kx % 2, kz % 2),
                                 f * at.x[by_x][kx] * at.z[by_z][kz]});
            }
        }
    }
    [[nodiscard]] Terms slope(const Point& at, std::size_t by_x, double f) const {
        Terms terms;
        append(terms, at, W, by_x, 1 - by_x, f);
        return terms;
    }

    /// f (u_x + w_x^2/2 - kappa_x w) + g (v_z + w_z^2/2 - kappa_z w)
    [[nodiscard]] Residual stretch(const Point& at, double f, double g) const {
        Residual residual;
        append(residual.linear, at, U, 1, 0, f);
        append(residual.linear, at, V, 0, 1, g);
        append(residual.linear, at, W, 0, 0, -f * curvature_x_ - g * curvature_z_);
        residual.products = {{slope(at, 1, 0.5 * f), slope(at, 1, 1.0)},
                             {slope(at, 0, 0.5 * g), slope(at, 0, 1.0)}};
        return residual;
    }
    /// f (u_z + v_x + w_x w_z)
    [[nodiscard]] Residual shear(const Point& at, double f) const {
        Residual residual;
        append(residual.linear, at, U, 0, 1, f);
        append(residual.linear, at, V, 1, 0, f);
        residual.products = {{slope(at, 1, f), slope(at, 0, 1.0)}};
        return residual;
    }
    /// f w_xx + g w_zz + s w_xz
    [[nodiscard]] Residual bend(const Point& at, double f, double g, double s) const {
        Residual residual;
        append(residual.linear, at, W, 2, 0, f);
        append(residual.linear, at, W, 0, 2, g);
        append(residual.linear, at, W, 1, 1, s);
        return residual;
    }

    void add_element(LeastSquares& energy, Strain strain, std::size_t ix, std::size_t iz) const {
        const auto place = [&](std::size_t i) { return graded(i, square_.elements); };
        const double hx = place(ix + 1) - place(ix);
        const double hz = place(iz + 1) - place(iz);
        const double nu = square_.poisson;
        const double across = std::sqrt(1.0 - nu * nu);
        std::vector<Residual> residuals;
        for (const GaussPoint& gx : GAUSS) {
            for (const GaussPoint& gz : GAUSS) {
                const Point at{ix, iz, hermite_shape(gx.place, hx), hermite_shape(gz.place, hz)};
                const double b = std::sqrt(4.0 * hx * hz * gx.weight * gz.weight);  // four quarters
                const double m = std::sqrt(12.0) * b;
                residuals.push_back(bend(at, b, nu * b, 0.0));
                residuals.push_back(bend(at, 0.0, across * b, 0.0));
                residuals.push_back(bend(at, 0.0, 0.0, std::sqrt(2.0 * (1.0 - nu)) * b));
                residuals.push_back(stretch(at, m, nu * m));
                residuals.push_back(stretch(at, 0.0, across * m));
                residuals.push_back(shear(at, std::sqrt(0.5 * (1.0 - nu)) * m));
            }
        }
        if (strain == Strain::linear) {
            for (Residual& residual : residuals) residual.products.clear();
        }
        energy.add(residuals);
    }

    const Square& square_;
    std::size_t nodes_;
    double curvature_x_;
    double curvature_z_;
};

}  // namespace

Pressed press(const Square& square, std::span<const double> depths_m) {
    const Quarter quarter(square);
    const Model model{.unknowns = 3 * quarter.unknowns_of_field(),
                      .deflections = quarter.unknowns_of_field(),
                      .contact = 0,
                      .add = [&](LeastSquares& energy, Strain strain) { quarter.add(energy, strain); }};
    return press(model, {square.thickness_m, 0.5 * square.side_m, square.rigidity_n_m}, depths_m);
}

}  // namespace palpate::reference
