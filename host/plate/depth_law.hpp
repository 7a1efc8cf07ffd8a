/// How a point's force grows with depth beyond the linear law.
#pragma once
#include <array>
#include <cstddef>
#include <span>

namespace palpate::plate {

/// psi(x) = (1 + n1 x + n2 x^2 + n4 x^4)/(1 + m1 x + m2 x^2) at x = depth/thickness (MATH.md eq. 42-43), in
/// the order of pal_table.psi: energy U = k d^2 psi/2, force F = k d phi, k the linear stiffness. All 0:
/// linear.
struct DepthLaw {
    double n1 = 0.0;
    double n2 = 0.0;
    double n4 = 0.0;
    double m1 = 0.0;
    double m2 = 0.0;
};

/// Uniform patches at nu = 0.2, x to 5, fitted to depth_law_table(): the square clamped plate (phi within
/// 0.14 %), and the spherical cap of radius 12 l pressed from outside (0.19 %) and from inside (0.05 %).
inline constexpr DepthLaw FLAT_LAW{.n2 = 0.282008, .n4 = 0.009521, .m2 = 0.071697};
inline constexpr DepthLaw CONVEX_LAW{.n1 = 0.162014, .n2 = 0.037056, .m1 = 0.463190, .m2 = 0.185746};
inline constexpr DepthLaw CONCAVE_LAW{.n1 = 1.040865, .n2 = 0.281401, .m1 = 0.729168};

/// For x >= 0.
[[nodiscard]] double psi(const DepthLaw& law, double x);
/// F/(k d) = psi + x psi'/2.
[[nodiscard]] double phi(const DepthLaw& law, double x);
/// (dF/dd)/k = phi + x phi'.
[[nodiscard]] double tangent(const DepthLaw& law, double x);

/// Whether the denominator and the tangent are positive everywhere in [0, x_max]: the force never falls as
/// the depth grows. Certain when true: Bernstein coefficients bound the polynomials.
[[nodiscard]] bool rises(const DepthLaw& law, double x_max);

/// Which constants a fit may move; the others stay 0.
struct Free {
    bool n1 = true;
    bool n2 = true;
    bool n4 = true;
    bool m1 = true;
    bool m2 = true;
};
inline constexpr Free FLAT_FREE{.n1 = false, .m1 = false};  ///< even in x; membrane law for x large
inline constexpr Free CONVEX_FREE{.n4 = false};
inline constexpr Free CONCAVE_FREE{.n4 = false, .m2 = false};

struct DepthLawFit {
    DepthLaw law;
    double largest_error;  ///< of phi at the points given, relative
};

/// Least squares of the relative errors of phi, by Levenberg-Marquardt from the linear law, then reweighted
/// (Lawson) towards the smallest largest error. The denominator has no zero at x >= 0, and no constant
/// exceeds 4; whether the law rises is for the caller to ask. `x` and `phi`: positive, as long as each other,
/// at least as many as the free constants: else std::invalid_argument.
[[nodiscard]] DepthLawFit fit_depth_law(std::span<const double> x, std::span<const double> phi,
                                        Free free = {});

/// What the reference found (`palpate-reference depth-law`): F/(k d).
struct DepthLawRow {
    double x;
    double flat;
    double convex;
    double concave;
};
[[nodiscard]] std::span<const DepthLawRow> depth_law_table();

}  // namespace palpate::plate
