#include "host/plate/contact_set.hpp"

#include <stdexcept>
#include <string>

#include "host/plate/coarser.hpp"
#include "host/plate/uniform/uniform.hpp"

namespace palpate::plate {
namespace {

using Eigen::ArrayXXd;
using Eigen::Index;

bool fits(Index n, Index m) {
    return m >= 2 && n >= 9 && n % 4 == 1 && (n - 1) / 2 % (m - 1) == 0;
}

void require_fit(Index n, Index m) {
    if (fits(n, m)) return;
    throw std::invalid_argument(std::to_string(m) + " contacts do not fit the nodes of a side of " +
                                std::to_string(n));
}

/// Every 1st, 2nd or 4th of m contacts along a side is a node of nx x nz; nullopt: fewer.
std::optional<Index> stride_of(Index nx, Index nz, Index m) {
    for (const Index stride : {1, 2, 4}) {
        const Index shared = (m - 1) / stride + 1;
        if ((m - 1) % stride == 0 && fits(nx, shared) && fits(nz, shared)) return stride;
    }
    return std::nullopt;
}

Index stride_of_half(const Problem& fine, Index m) {
    const Index nx = fine.rigidity_n_m.rows(), nz = fine.rigidity_n_m.cols();
    require_fit(nx, m);
    require_fit(nz, m);
    const auto stride = stride_of((nx + 1) / 2, (nz + 1) / 2, m);
    if (stride) return *stride;
    throw std::invalid_argument(std::to_string(m) + " contacts have too few nodes on half of " +
                                std::to_string(nx) + " x " + std::to_string(nz));
}

/// nullopt where three quarters of the nodes do not serve.
std::optional<Index> stride_of_three_quarters(const Problem& fine, Index m) {
    const bool plain = fine.harmonic_x_n_m.size() == 0 && fine.harmonic_z_n_m.size() == 0 &&
                       fine.solid.size() == 0 && fine.poisson_at_nodes.size() == 0;
    if (!plain || has_jump(fine.foundation_n_per_m3)) return std::nullopt;
    const auto count = [](Index n) { return (n - 1) / 4 * 3 + 1; };
    return stride_of(count(fine.rigidity_n_m.rows()), count(fine.rigidity_n_m.cols()), m);
}

/// Every `stride`-th along both sides.
ArrayXXd every(const ArrayXXd& contacts, Index stride) {
    const auto some = Eigen::seqN(0, (contacts.rows() - 1) / stride + 1, stride);
    return contacts(some, some);
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

/// Values at m x m contacts from those at every second, fourth ... of them.
ArrayXXd filled(ArrayXXd values, Index m) {
    while (values.rows() < m) {
        const auto even = Eigen::seqN(0, values.rows(), 2);
        ArrayXXd finer = ArrayXXd::Zero(2 * values.rows() - 1, 2 * values.cols() - 1);
        finer(even, even) = values;
        fill_odd_rows(finer);
        finer.transposeInPlace();
        fill_odd_rows(finer);
        values = finer.transpose();
    }
    return values;
}

}  // namespace

std::vector<Node> contact_nodes(Index nx, Index nz, Index m) {
    require_fit(nx, m);
    require_fit(nz, m);
    const Index step_x = (nx - 1) / 2 / (m - 1), step_z = (nz - 1) / 2 / (m - 1);
    std::vector<Node> nodes;
    for (Index iz = 0; iz < m; ++iz) {
        for (Index ix = 0; ix < m; ++ix)
            nodes.push_back({(nx - 1) / 4 + step_x * ix, (nz - 1) / 4 + step_z * iz});
    }
    return nodes;
}

ContactTable::Grid::Grid(const Problem& on_grid, Index every, Kernel kernel)
    : problem(on_grid), plate(on_grid, kernel), stride(every) {}

void ContactTable::Grid::set_rigidity(const ArrayXXd& rigidity_n_m) {
    plate.set_rigidity(rigidity_n_m);
    problem.rigidity_n_m = rigidity_n_m;
}

/// Compliances less the local uniform square's grid error at every stride-th of m x m contacts.
ArrayXXd ContactTable::Grid::corrected_m_per_n(Index m) const {
    const Index shared = (m - 1) / stride + 1;
    const std::vector<Node> nodes =
        contact_nodes(problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols(), shared);
    ArrayXXd m_per_n(shared, shared);
    plate.compliances_m_per_n(nodes, {m_per_n.data(), nodes.size()});
    for (std::size_t k = 0; k < nodes.size(); ++k)
        m_per_n.data()[k] -= local_grid_error_m_per_n(problem, nodes[k]);
    return m_per_n;
}

ContactTable::ContactTable(const Problem& problem, Index m, Kernel kernel)
    : m_(m), all_(problem, 1, kernel), half_(every_second_node(problem), stride_of_half(problem, m), kernel) {
    if (const auto stride = stride_of_three_quarters(problem, m)) {
        Problem flat = problem;  // D follows, if it is smooth
        flat.rigidity_n_m.setConstant(problem.rigidity_n_m.maxCoeff());
        const Problem coarse = three_quarters(flat);
        if (!problem_with(coarse)) three_quarters_.emplace(coarse, *stride, kernel);
    }
    set_third(problem.rigidity_n_m);
}

void ContactTable::set_rigidity(const Eigen::Ref<const ArrayXXd>& rigidity_n_m) {
    all_.set_rigidity(rigidity_n_m);
    half_.set_rigidity(every_second_node(rigidity_n_m));
    set_third(rigidity_n_m);
}

void ContactTable::set_third(const Eigen::Ref<const ArrayXXd>& rigidity_n_m) {
    smooth_ = false;
    if (!three_quarters_ || has_jump(rigidity_n_m)) return;
    const ArrayXXd third_n_m = three_quarters(rigidity_n_m);
    smooth_ = (third_n_m > 0.0).all();
    if (smooth_) three_quarters_->set_rigidity(third_n_m);
}

ArrayXXd ContactTable::compliances_m_per_n() const {
    const ArrayXXd all = all_.corrected_m_per_n(m_), half = half_.corrected_m_per_n(m_);
    const ArrayXXd all_of_half = every(all, half_.stride);
    const ArrayXXd of_two = (4.0 * all_of_half - half) / 3.0;
    ArrayXXd m_per_n = all * filled(of_two / all_of_half, m_);
    if (smooth_) {
        const Index stride = three_quarters_->stride;
        const ArrayXXd of_three =
            (320.0 * every(all, stride) - 243.0 * three_quarters_->corrected_m_per_n(m_) +
             28.0 * every(half, stride / half_.stride)) /
            105.0;
        m_per_n *= filled(of_three / every(m_per_n, stride), m_);
    }
    if (!(m_per_n > 0.0).all())
        throw Guard("an extrapolated compliance is not positive; the grid is too coarse");
    return m_per_n;
}

ArrayXXd contact_compliances_m_per_n(const Problem& problem, Index m, Kernel kernel) {
    return ContactTable(problem, m, kernel).compliances_m_per_n();
}

}  // namespace palpate::plate
