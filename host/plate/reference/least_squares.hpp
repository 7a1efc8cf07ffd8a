/// Energies that are half a sum of squares, minimised by Ceres.
#pragma once
#include <ceres/ceres.h>

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace palpate::reference {

/// One number to find, by its place in LeastSquares::values.
using Unknown = std::size_t;
/// An unknown that is 0 for good, as on a clamped edge: terms with it drop out.
inline constexpr Unknown ZERO = std::numeric_limits<Unknown>::max();

struct Term {
    Unknown unknown;
    double factor;
};
using Terms = std::vector<Term>;

/// `first` times `second`.
struct Product {
    Terms first;
    Terms second;
};

/// One residual: a polynomial of second degree without a constant.
struct Residual {
    Terms linear;
    std::vector<Product> products;
};

struct Minimum {
    double energy = 0.0;
    double reaction = 0.0;  ///< d(energy)/d(held unknown): the force that holds it
    int iterations = 0;
};

/// E(x) = 1/2 sum r(x)^2, with one unknown held where it is (MATH.md eq. 41).
class LeastSquares {
public:
    explicit LeastSquares(std::size_t unknowns) : values_(unknowns, 0.0) {}

    /// Residuals in one block: Ceres takes their derivatives together.
    void add(const std::vector<Residual>& residuals);
    /// Where minimise() begins and what it leaves. An unknown in no residual stays as it is.
    [[nodiscard]] std::span<double> values() { return values_; }
    /// Throws std::runtime_error when Ceres finds no minimum: the work of the derivatives left, sum |g_i x_i|
    /// over the free unknowns, may not exceed 1e-5 of the reaction's. That is also about the reaction's
    /// error.
    [[nodiscard]] Minimum minimise(Unknown held);

private:
    [[nodiscard]] Minimum measured(Unknown held);

    std::vector<double> values_;
    ceres::Problem problem_;
};

}  // namespace palpate::reference
