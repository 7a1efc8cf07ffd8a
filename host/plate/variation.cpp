#include "host/plate/variation.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::plate {
namespace {

using Eigen::Index;

double ratio(double a, double b) {
    return a == b ? 1.0 : std::max(a / b, b / a);
}

/// D half a spacing beside a node if it jumps on the way there, else D at the node. Between two nodes of a
/// smooth field the middle is near their geometric mean; beside a jump it is one of them.
double across_jump(double here, double middle, double there) {
    const double step = std::fabs(std::log(there / here));
    const bool jumps =
        step > std::log(SMOOTH_STEP) && std::fabs(std::log(middle * middle / (here * there))) > 0.5 * step;
    return jumps ? (std::fabs(std::log(middle / here)) > 0.5 * step ? middle : there) : here;
}

}  // namespace

Variation::Variation(const Eigen::ArrayXXd& field) {
    if (field.size() == 0) return;
    contrast = ratio(field.maxCoeff(), field.minCoeff());
    for (Index iz = 0; iz < field.cols(); ++iz) {
        for (Index ix = 0; ix < field.rows(); ++ix) {
            if (ix > 0) step = std::max(step, ratio(field(ix, iz), field(ix - 1, iz)));
            if (iz > 0) step = std::max(step, ratio(field(ix, iz), field(ix, iz - 1)));
        }
    }
}

Eigen::ArrayXXd beyond_jumps(const Sheet& sheet, const GridLines& lines, Extreme which) {
    const auto near = [](const Eigen::ArrayXd& at_m, Index i, Index side) {
        return at_m(std::clamp<Index>(i + side, 0, at_m.size() - 1));
    };
    Eigen::ArrayXXd extreme(lines.x_m.size(), lines.z_m.size());
    for (Index iz = 0; iz < extreme.cols(); ++iz) {
        for (Index ix = 0; ix < extreme.rows(); ++ix) {
            const double x = lines.x_m(ix), z = lines.z_m(iz), own = sheet.rigidity_n_m(x, z);
            double& d = extreme(ix, iz);
            d = own;
            for (Index side = 0; side < 9; ++side) {
                const double xs = near(lines.x_m, ix, side % 3 - 1), zs = near(lines.z_m, iz, side / 3 - 1);
                const double other = across_jump(own, sheet.rigidity_n_m(0.5 * (x + xs), 0.5 * (z + zs)),
                                                 sheet.rigidity_n_m(xs, zs));
                d = which == Extreme::softest ? std::min(d, other) : std::max(d, other);
            }
        }
    }
    return extreme;
}

}  // namespace palpate::plate
