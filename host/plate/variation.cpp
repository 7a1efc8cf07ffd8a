#include "host/plate/variation.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::plate {
namespace {

using Eigen::Index;

double ratio(double a, double b) {
    return a == b ? 1.0 : std::max(a / b, b / a);
}

/// Whether D jumps between two nodes, from its values just beside them and in the middle: the middle of a
/// smooth field is near their geometric mean, beside a jump it is one of them.
bool jumps(double here, double middle, double there) {
    const double step = std::fabs(std::log(there / here));
    return step > std::log(SMOOTH_STEP) && std::fabs(std::log(middle * middle / (here * there))) > 0.5 * step;
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

Eigen::ArrayXXd beyond_jumps(const Sheet& sheet, const Problem& on_grid, Extreme which) {
    const GridLines lines(on_grid);
    Eigen::ArrayXXd extreme = on_grid.rigidity_n_m;
    const auto at = [&](double x_m, double z_m) { return sheet.rigidity_n_m(x_m, z_m); };
    for (Index iz = 0; iz < extreme.cols(); ++iz) {
        for (Index ix = 0; ix < extreme.rows(); ++ix) {
            double& d = extreme(ix, iz);
            for (Index side = 0; side < 9; ++side) {
                const Index dx = side % 3 - 1, dz = side / 3 - 1;
                const Index jx = ix + dx, jz = iz + dz;
                if (jx < 0 || jx >= extreme.rows() || jz < 0 || jz >= extreme.cols()) continue;
                const double ex = BESIDE * sheet.size_m.x() * static_cast<double>(dx),
                             ez = BESIDE * sheet.size_m.y() * static_cast<double>(dz);
                const double x = lines.x_m(ix), z = lines.z_m(iz), xj = lines.x_m(jx), zj = lines.z_m(jz);
                const double there = at(xj - ex, zj - ez);
                if (!jumps(at(x + ex, z + ez), at(0.5 * (x + xj), 0.5 * (z + zj)), there)) continue;
                d = which == Extreme::softest ? std::min(d, there) : std::max(d, there);
            }
        }
    }
    return extreme;
}

}  // namespace palpate::plate
