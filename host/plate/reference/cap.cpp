#include "host/plate/reference/cap.hpp"

#include <cmath>
#include <numbers>

#include "host/plate/reference/hermite.hpp"
#include "host/plate/reference/press.hpp"

namespace palpate::reference {
namespace {

Terms joined(const std::vector<Terms>& parts) {
    Terms all;
    for (const Terms& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

/// Lengths over the patch's radius. A node has a value and a slope of w, then of u.
class Elements {
public:
    explicit Elements(const Cap& cap)
        : cap_(cap), curvature_(cap.curvature_per_m * cap.radius_m * cap.radius_m / cap.thickness_m) {}

    [[nodiscard]] std::size_t deflections() const { return 2 * (cap_.elements + 1); }

    void add(LeastSquares& energy, Strain strain) const {
        for (std::size_t e = 0; e < cap_.elements; ++e) {
            for (const GaussPoint& point : GAUSS) add_point(energy, strain, e, point);
        }
    }

private:
    [[nodiscard]] double radius(std::size_t node) const { return graded(node, cap_.elements); }
    [[nodiscard]] Unknown w(std::size_t node, std::size_t slope) const {
        return node == cap_.elements || (node == 0 && slope == 1) ? ZERO : 2 * node + slope;
    }
    [[nodiscard]] Unknown u(std::size_t node, std::size_t slope) const {
        const bool rim = node == cap_.elements && cap_.edge == Edge::fixed;
        return slope == 0 && (rim || node == 0) ? ZERO : deflections() + 2 * node + slope;
    }

    [[nodiscard]] Terms of_w(std::size_t e, const HermiteFactors& factors, double f) const {
        return {{w(e, 0), f * factors[0]},
                {w(e, 1), f * factors[1]},
                {w(e + 1, 0), f * factors[2]},
                {w(e + 1, 1), f * factors[3]}};
    }
    [[nodiscard]] Terms of_u(std::size_t e, const HermiteFactors& factors, double f) const {
        return {{u(e, 0), f * factors[0]},
                {u(e, 1), f * factors[1]},
                {u(e + 1, 0), f * factors[2]},
                {u(e + 1, 1), f * factors[3]}};
    }

    /// u' + w'^2/2 - kappa w and u/r - kappa w; w'' and w'/r.
    void add_point(LeastSquares& energy, Strain strain, std::size_t e, const GaussPoint& point) const {
        const double h = radius(e + 1) - radius(e);
        const double r = radius(e) + point.place * h;
        const auto [value, first, second] = hermite_shape(point.place, h);
        const double nu = cap_.poisson;
        const double across = std::sqrt(1.0 - nu * nu);
        const double b = std::sqrt(2.0 * std::numbers::pi * r * h * point.weight);
        const double m = std::sqrt(12.0) * b;
        const double k = curvature_;
        Residual stretch{.linear = joined({of_u(e, first, m), of_u(e, value, nu * m / r),
                                           of_w(e, value, -(1.0 + nu) * m * k)}),
                         .products = {{of_w(e, first, 0.5 * m), of_w(e, first, 1.0)}}};
        if (strain == Strain::linear) stretch.products.clear();
        energy.add({{.linear = joined({of_w(e, second, b), of_w(e, first, nu * b / r)}), .products = {}},
                    {.linear = of_w(e, first, across * b / r), .products = {}},
                    stretch,
                    {.linear = joined({of_u(e, value, across * m / r), of_w(e, value, -across * m * k)}),
                     .products = {}}});
    }

    const Cap& cap_;
    double curvature_;
};

}  // namespace

double shell_length_m(double thickness_m, double curvature_per_m, double poisson) {
    return std::sqrt(thickness_m / std::abs(curvature_per_m)) /
           std::pow(12.0 * (1.0 - poisson * poisson), 0.25);
}

Pressed press(const Cap& cap, std::span<const double> depths_m) {
    const Elements elements(cap);
    const Model model{.unknowns = 2 * elements.deflections(),
                      .deflections = elements.deflections(),
                      .contact = 0,
                      .add = [&](LeastSquares& energy, Strain strain) { elements.add(energy, strain); }};
    return press(model, {cap.thickness_m, cap.radius_m, cap.rigidity_n_m}, depths_m);
}

}  // namespace palpate::reference
