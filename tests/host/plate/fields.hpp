/// Plates to test with.
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <utility>

#include "host/plate/field.hpp"
#include "host/plate/plate.hpp"

namespace palpate::plate::fields {

/// f(x, z) at the nodes of the unit square.
template <typename Function>
[[nodiscard]] Eigen::ArrayXXd sampled(Eigen::Index n, Function f) {
    Eigen::ArrayXXd field(n, n);
    for (Eigen::Index ix = 0; ix < n; ++ix) {
        for (Eigen::Index iz = 0; iz < n; ++iz) {
            field(ix, iz) = f(static_cast<double>(ix) / static_cast<double>(n - 1),
                              static_cast<double>(iz) / static_cast<double>(n - 1));
        }
    }
    return field;
}

/// Unit square, no foundation, nu = 0.2.
template <typename Function>
[[nodiscard]] Problem unit_square(Eigen::Index n, Function rigidity) {
    Problem problem;
    problem.size_m = {1.0, 1.0};
    problem.rigidity_n_m = sampled(n, std::move(rigidity));
    return problem;
}

/// The same, on no grid yet.
[[nodiscard]] inline Sheet unit_sheet(Field rigidity, double poisson = 0.2) {
    Sheet sheet;
    sheet.size_m = {1.0, 1.0};
    sheet.rigidity_n_m = std::move(rigidity);
    sheet.poisson = poisson;
    return sheet;
}

/// A uniform foundation that makes side/l = side_over_l where D = 1 on a unit square.
[[nodiscard]] inline Problem on_foundation(Problem problem, double side_over_l) {
    const double s2 = side_over_l * side_over_l;
    problem.foundation_n_per_m3 =
        Eigen::ArrayXXd::Constant(problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols(), s2 * s2);
    return problem;
}

/// 1 at (cx, cz), falling off with `sigma`.
[[nodiscard]] inline double bell(double x, double z, double cx, double cz, double sigma) {
    return std::exp(-((x - cx) * (x - cx) + (z - cz) * (z - cz)) / (2.0 * sigma * sigma));
}

inline double one(double, double) {
    return 1.0;
}
inline double hyper10(double x, double) {
    return 10.0 / (1.0 + 9.0 * x);
}
inline double linear10(double x, double) {
    return 1.0 + 9.0 * x;
}
inline double wart(double x, double z) {
    return 1.0 + 9.0 * bell(x, z, 0.5, 0.5, 0.08);
}
inline double gauss(double x, double z) {
    return 1.0 + 4.0 * bell(x, z, 0.5, 0.5, 0.15);
}
inline double jump1000(double x, double) {
    return x > 0.4 ? 1e3 : 1.0;
}
inline double soft_centre(double x, double z) {
    return x == 0.5 && z == 0.5 ? 0.5 : 1.0;
}

/// Fixed stream of numbers in [0, 1).
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    double next() {
        state_ = state_ * 6364136223846793005U + 1442695040888963407U;
        return static_cast<double>(state_ >> 11U) * 0x1p-53;
    }

private:
    std::uint64_t state_;
};

}  // namespace palpate::plate::fields
