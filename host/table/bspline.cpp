#include "host/table/bspline.hpp"

#include <Eigen/LU>

namespace palpate::table {
namespace {

/// (m + 2) x m: coefficients of a line from its m values.
Eigen::MatrixXd line_filter(Eigen::Index m) {
    const Eigen::Index n = m + 2;
    Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n, n);
    system.row(0).head<4>() << -1.0, 3.0, -3.0, 1.0;
    system.row(n - 1).tail<4>() << -1.0, 3.0, -3.0, 1.0;
    for (Eigen::Index i = 1; i + 1 < n; ++i)
        system.row(i).segment<3>(i - 1) << 1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0;
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n, m);
    right.middleRows(1, m).setIdentity();
    return system.partialPivLu().solve(right);
}

}  // namespace

Eigen::MatrixXd spline_coefficients(const Eigen::Ref<const Eigen::MatrixXd>& values) {
    const Eigen::MatrixXd filter = line_filter(values.rows());
    return filter * values * filter.transpose();
}

}  // namespace palpate::table
