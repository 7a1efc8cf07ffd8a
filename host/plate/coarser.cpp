#include "host/plate/coarser.hpp"

#include <algorithm>

namespace palpate::plate {
namespace {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;

template <typename Array>
Array thinned(const Array& fine) {
    if (fine.size() == 0) return fine;
    const auto even = [](Index n) { return Eigen::seqN(0, (n + 1) / 2, 2); };
    return fine(even(fine.rows()), even(fine.cols()));
}

ArrayXd thinned_lines(const ArrayXd& lines) {
    if (lines.size() == 0) return lines;
    return lines(Eigen::seqN(0, (lines.size() + 1) / 2, 2));
}

/// Rows at 0, 4/3, 8/3 ... of `fine`.
ArrayXXd three_quarters_of_rows(const ArrayXXd& fine) {
    constexpr Index N_POINTS = 6;
    const Index n = fine.rows();
    if (n < 9 || n % 4 != 1)
        throw std::invalid_argument(std::to_string(n) +
                                    " nodes have no three quarters; needs 4 m + 1, at least 9");
    ArrayXXd coarse = ArrayXXd::Zero((n - 1) / 4 * 3 + 1, fine.cols());
    for (Index i = 0; i < coarse.rows(); ++i) {
        const Index first = std::clamp<Index>(4 * i / 3 - 2, 0, n - N_POINTS);
        for (Index k = first; k < first + N_POINTS; ++k) {
            double weight = 1.0;
            for (Index j = first; j < first + N_POINTS; ++j) {
                if (j != k) weight *= static_cast<double>(4 * i - 3 * j) / static_cast<double>(3 * (k - j));
            }
            coarse.row(i) += weight * fine.row(k);
        }
    }
    return coarse;
}

ArrayXd three_quarters_of_lines(const ArrayXd& lines) {
    if (lines.size() == 0) return lines;
    return three_quarters_of_rows(lines);
}

ArrayXXd three_quarters_or_empty(const ArrayXXd& fine) {
    return fine.size() == 0 ? fine : three_quarters(fine);
}

}  // namespace

ArrayXXd every_second_node(const Eigen::Ref<const ArrayXXd>& fine) {
    return thinned<ArrayXXd>(fine);
}

Problem every_second_node(const Problem& fine) {
    Problem coarse = fine;
    coarse.rigidity_n_m = thinned(fine.rigidity_n_m);
    coarse.foundation_n_per_m3 = thinned(fine.foundation_n_per_m3);
    coarse.poisson_at_nodes = thinned(fine.poisson_at_nodes);
    coarse.harmonic_x_n_m = thinned(fine.harmonic_x_n_m);
    coarse.harmonic_z_n_m = thinned(fine.harmonic_z_n_m);
    coarse.solid = thinned(fine.solid);
    coarse.lines_x_m = thinned_lines(fine.lines_x_m);
    coarse.lines_z_m = thinned_lines(fine.lines_z_m);
    return coarse;
}

ArrayXXd three_quarters(const Eigen::Ref<const ArrayXXd>& fine) {
    const ArrayXXd along_x = three_quarters_of_rows(fine);
    return three_quarters_of_rows(along_x.transpose()).transpose();
}

Problem three_quarters(const Problem& fine) {
    if (fine.harmonic_x_n_m.size() != 0 || fine.harmonic_z_n_m.size() != 0 || fine.solid.size() != 0)
        throw std::invalid_argument(
            "no three quarters of the nodes of a plate with holes or jumps along grid lines");
    Problem coarse = fine;
    coarse.rigidity_n_m = three_quarters(fine.rigidity_n_m);
    coarse.foundation_n_per_m3 = three_quarters_or_empty(fine.foundation_n_per_m3).max(0.0);
    coarse.poisson_at_nodes = three_quarters_or_empty(fine.poisson_at_nodes);
    coarse.lines_x_m = three_quarters_of_lines(fine.lines_x_m);
    coarse.lines_z_m = three_quarters_of_lines(fine.lines_z_m);
    return coarse;
}

bool has_jump(const Eigen::Ref<const ArrayXXd>& field) {
    const auto jumps = [](double a, double b) { return a > 2.0 * b || b > 2.0 * a; };
    for (Index iz = 0; iz < field.cols(); ++iz) {
        for (Index ix = 0; ix < field.rows(); ++ix) {
            if (ix > 0 && jumps(field(ix, iz), field(ix - 1, iz))) return true;
            if (iz > 0 && jumps(field(ix, iz), field(ix, iz - 1))) return true;
        }
    }
    return false;
}

}  // namespace palpate::plate
