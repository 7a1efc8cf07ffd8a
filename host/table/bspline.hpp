/// Cubic B-spline coefficients of values on a square grid.
#pragma once
#include <Eigen/Core>

namespace palpate::table {

/// `values`: m x m. The result, (m + 2) x (m + 2), interpolates them: value(i, j) is the tensor of (1 4 1)/6
/// over the coefficients around (i + 1, j + 1); its ring outside continues each line by a parabola (third
/// difference zero). Fourth-order for smooth values. m >= 4. One small matrix product each way.
[[nodiscard]] Eigen::MatrixXd spline_coefficients(const Eigen::Ref<const Eigen::MatrixXd>& values);

}  // namespace palpate::table
