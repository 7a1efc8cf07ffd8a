#include "host/plate/contact_set.hpp"

#include <stdexcept>
#include <string>

#include "host/plate/uniform/uniform.hpp"

namespace palpate::plate {
namespace {

using Eigen::ArrayXXd;
using Eigen::Index;

Index spacing(Index n, Index m) {
    if (m < 2 || n < 9 || n % 4 != 1 || (n - 1) / 2 % (m - 1) != 0) {
        throw std::invalid_argument(std::to_string(m) + " contacts do not fit the nodes of a side of " +
                                    std::to_string(n));
    }
    return (n - 1) / 2 / (m - 1);
}

/// The problem on every second node, as far as the grid error asks for it.
Problem halved(const Problem& fine) {
    const auto thinned = [](const auto& all) {
        auto some = all;
        some.resize((all.rows() + 1) / 2, (all.cols() + 1) / 2);
        for (Index iz = 0; iz < some.cols(); ++iz) {
            for (Index ix = 0; ix < some.rows(); ++ix) some(ix, iz) = all(2 * ix, 2 * iz);
        }
        return some;
    };
    Problem coarse;
    coarse.size_m = fine.size_m;
    coarse.rigidity_n_m = thinned(fine.rigidity_n_m);
    coarse.foundation_n_per_m3 = thinned(fine.foundation_n_per_m3);
    const auto lines = [](const Eigen::ArrayXd& all) -> Eigen::ArrayXd {
        return all.size() == 0 ? all : all(Eigen::seqN(0, (all.size() + 1) / 2, 2)).eval();
    };
    coarse.lines_x_m = lines(fine.lines_x_m);
    coarse.lines_z_m = lines(fine.lines_z_m);
    return coarse;
}

/// Compliance less the local uniform square's grid error.
ArrayXXd corrected(const Problem& problem, const Plate& plate, const std::vector<Node>& nodes, Index rows) {
    ArrayXXd m_per_n(rows, static_cast<Index>(nodes.size()) / rows);
    plate.compliances_m_per_n(nodes, {m_per_n.data(), nodes.size()});
    for (std::size_t k = 0; k < nodes.size(); ++k)
        m_per_n.data()[k] -= local_grid_error_m_per_n(problem, nodes[k]);
    return m_per_n;
}

/// Values halfway between rows 0, 2, 4, ... of `values` from the cubic through the nearest four.
void fill_odd_rows(ArrayXXd& values) {
    const Index last = values.rows() - 1;
    for (Index i = 1; i < last; i += 2) {
        if (last < 6) {
            values.row(i) = 0.5 * (values.row(i - 1) + values.row(i + 1));
        } else if (i == 1) {
            values.row(i) =
                (5.0 * values.row(0) + 15.0 * values.row(2) - 5.0 * values.row(4) + values.row(6)) / 16.0;
        } else if (i + 1 == last) {
            values.row(i) = (5.0 * values.row(i + 1) + 15.0 * values.row(i - 1) - 5.0 * values.row(i - 3) +
                             values.row(i - 5)) /
                            16.0;
        } else {
            values.row(i) =
                (9.0 * (values.row(i - 1) + values.row(i + 1)) - (values.row(i - 3) + values.row(i + 3))) /
                16.0;
        }
    }
}

/// G*/G_fine at the contacts, `stride` of which lie between neighbours that both grids have.
ArrayXXd ratios(const ArrayXXd& on_fine, const ArrayXXd& on_coarse, Index stride) {
    ArrayXXd ratio = ArrayXXd::Zero(on_fine.rows(), on_fine.cols());
    for (Index iz = 0; iz < on_coarse.cols(); ++iz) {
        for (Index ix = 0; ix < on_coarse.rows(); ++ix) {
            const double fine = on_fine(stride * ix, stride * iz);
            ratio(stride * ix, stride * iz) = (4.0 * fine - on_coarse(ix, iz)) / (3.0 * fine);
        }
    }
    if (stride == 1) return ratio;
    fill_odd_rows(ratio);
    ratio.transposeInPlace();
    fill_odd_rows(ratio);
    ratio.transposeInPlace();
    return ratio;
}

}  // namespace

std::vector<Node> contact_nodes(Index nx, Index nz, Index m) {
    const Index step_x = spacing(nx, m), step_z = spacing(nz, m);
    std::vector<Node> nodes;
    for (Index iz = 0; iz < m; ++iz) {
        for (Index ix = 0; ix < m; ++ix)
            nodes.push_back({(nx - 1) / 4 + step_x * ix, (nz - 1) / 4 + step_z * iz});
    }
    return nodes;
}

ArrayXXd contact_compliances_m_per_n(const Problem& problem, const Plate& fine, const Plate& coarse,
                                     Index m) {
    const Index nx = problem.rigidity_n_m.rows(), nz = problem.rigidity_n_m.cols();
    const std::vector<Node> nodes = contact_nodes(nx, nz, m);
    const bool all_shared = spacing(nx, m) % 2 == 0 && spacing(nz, m) % 2 == 0;
    const Index stride = all_shared ? 1 : 2;
    if (!all_shared && m % 2 == 0) throw std::invalid_argument("an even number of contacts on odd nodes");
    const Index m_shared = (m - 1) / stride + 1;
    const ArrayXXd on_fine = corrected(problem, fine, nodes, m);
    const ArrayXXd on_coarse =
        corrected(halved(problem), coarse, contact_nodes((nx + 1) / 2, (nz + 1) / 2, m_shared), m_shared);
    ArrayXXd m_per_n = on_fine * ratios(on_fine, on_coarse, stride);
    if (!(m_per_n > 0.0).all())
        throw Guard("an extrapolated compliance is not positive; the grid is too coarse");
    return m_per_n;
}

}  // namespace palpate::plate
