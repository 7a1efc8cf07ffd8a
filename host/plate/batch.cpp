#include "host/plate/batch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "host/plate/direct/factor.hpp"
#include "host/plate/stencil.hpp"

namespace palpate::plate {
namespace {

constexpr double PIVOT_RATIO_MIN = 1e-8;  // as Plate's

}  // namespace

struct Batch::Impl {
    std::shared_ptr<const Analysis> analysis;
    const Kernels& kernels;
    std::vector<Stencil> stencils;
    std::vector<char> usable;  ///< by lane
    std::vector<BatchFront> fronts;
    std::vector<std::uint32_t> child_row;  ///< as Analysis::pull_column, without empty slots
    std::vector<std::uint32_t>
        target;  ///< as Analysis::entry_target, in the front's panel, without empty slots
    AlignedDoubles panel, updates, largest, sum, zeros;
    std::vector<const double*> couplings;

    Impl(const Problem& problem, const Kernels& with)
        : analysis(
              analysis_for({problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols()},
                           Moving(problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols(), problem.edges))),
          kernels(with),
          stencils(with.batch.lanes, Stencil(problem)),
          usable(with.batch.lanes, 0),
          child_row(analysis->pull_column),
          target(analysis->entry_target),
          panel(largest_panel() * with.batch.lanes),
          updates(analysis->n_updates * with.batch.lanes),
          largest(with.batch.lanes),
          sum(with.batch.lanes),
          zeros(with.batch.lanes) {
        updates.clear();  // what lies above a diagonal is read, and never used
        zeros.clear();
        for (const Front& front : analysis->fronts) fronts.push_back(place(front));
        for (const Stencil& stencil : stencils) couplings.push_back(stencil.couplings());
    }
    [[nodiscard]] std::size_t largest_panel() const {
        std::size_t n = 0;
        for (const Front& front : analysis->fronts)
            n = std::max<std::size_t>(n, std::size_t{front.n_pivots} * (front.n_pivots + front.n_border));
        return n;
    }
    [[nodiscard]] BatchFront place(const Front& front) {
        const std::size_t lanes = kernels.batch.lanes;
        BatchFront b{};
        b.panel = panel.data();
        b.update = updates.data() + front.update * lanes;
        b.n_pivots = front.n_pivots;
        b.n_rows = front.n_pivots + front.n_border;
        b.zeros = zeros.data();
        b.n_entries = front.n_entries;
        b.source = analysis->entry_source.data() + front.first_entry;
        b.target = target.data() + front.first_entry;
        b.diagonal = analysis->node.data() + front.first;
        const auto row_of = [](const Front& in, std::size_t slot) {
            return slot < in.n_pivots ? slot : slot - (in.pivot_slots - in.n_pivots);
        };
        for (std::size_t e = front.first_entry; e < front.first_entry + front.n_entries; ++e) {
            const std::size_t column = (target[e] - front.panel) / front.stride;
            const std::size_t slot = (target[e] - front.panel) % front.stride;
            target[e] = static_cast<std::uint32_t>(column * b.n_rows + row_of(front, slot));
        }
        for (const std::uint32_t c : front.children) {
            if (c == Analysis::NONE) continue;
            const Front& child = analysis->fronts[c];
            std::uint32_t* const rows = child_row.data() + child.pull_slots;
            for (std::size_t slot = 0; slot < front.n_slots; ++slot) {
                const bool empty = slot >= front.n_pivots && slot < front.pivot_slots;
                if (!empty) rows[row_of(front, slot)] = rows[slot];
            }
            b.children[b.n_children++] = {updates.data() + child.update * lanes, child.n_border, rows};
        }
        return b;
    }
};

Batch::Batch(const Problem& problem, Kernel kernel) {
    if (const auto problem_text = problem_with(problem)) throw std::invalid_argument(*problem_text);
    if (problem.rigidity_n_m.rows() % 2 == 0 || problem.rigidity_n_m.cols() % 2 == 0)
        throw std::invalid_argument("the centre of the plate is no node; the node counts must be odd");
    if (problem.harmonic_x_n_m.size() != 0) throw std::invalid_argument("a batch has no jumps on grid lines");
    impl_ = std::make_unique<Impl>(problem, kernels_for(kernel));
}

Batch::~Batch() = default;
Batch::Batch(Batch&&) noexcept = default;

std::size_t Batch::lanes() const {
    return impl_->kernels.batch.lanes;
}

void Batch::set_rigidity(std::size_t lane, const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m) {
    Stencil& stencil = impl_->stencils.at(lane);
    if (rigidity_n_m.rows() != stencil.layout().nx || rigidity_n_m.cols() != stencil.layout().nz)
        throw std::invalid_argument("another rigidity needs the same nodes");
    const bool good = (rigidity_n_m > 0.0 && rigidity_n_m <= std::numeric_limits<double>::max()).all();
    impl_->usable[lane] = good ? 1 : 0;
    if (good) stencil.set_rigidity(rigidity_n_m);
}

void Batch::centre_compliances_m_per_n(std::span<double> by_lane) {
    Impl& batch = *impl_;
    if (by_lane.size() != lanes()) throw std::invalid_argument("a batch needs one compliance per lane");
    std::fill_n(batch.largest.data(), lanes(), 1.0);
    std::fill_n(batch.sum.data(), lanes(), 0.0);
    for (const BatchFront& front : batch.fronts)
        batch.kernels.batch.eliminate(front, batch.couplings.data(), batch.largest.data(), batch.sum.data());
    const BatchFront& root = batch.fronts.back();  // its panel is still there, and it has no border
    const double* const last = batch.panel.data() + (root.n_rows * root.n_rows - 1) * lanes();
    for (std::size_t lane = 0; lane < lanes(); ++lane) {
        const bool sound = batch.usable[lane] != 0 && std::isfinite(batch.sum.data()[lane]) &&
                           1.0 / batch.largest.data()[lane] > PIVOT_RATIO_MIN;
        by_lane[lane] = sound ? last[lane] * last[lane] * batch.stencils[lane].compliance_m_per_n()
                              : std::numeric_limits<double>::quiet_NaN();
    }
}

const char* Batch::kernel() const {
    return impl_->kernels.name;
}

}  // namespace palpate::plate
