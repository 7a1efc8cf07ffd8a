#include "host/plate/direct/factor.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <new>
#include <utility>

namespace palpate::plate {
namespace {

constexpr std::align_val_t ALIGNMENT{64};
constexpr double INFINITE = std::numeric_limits<double>::infinity();

}  // namespace

AlignedDoubles::AlignedDoubles(std::size_t n)
    : n_(n), memory_(static_cast<double*>(::operator new(n * sizeof(double), ALIGNMENT))) {}

void AlignedDoubles::clear() {
    std::fill_n(memory_.get(), n_, 0.0);
}

void AlignedDoubles::Free::operator()(double* memory) const {
    ::operator delete(memory, ALIGNMENT);
}

FactorWorkspace::FactorWorkspace(const Analysis& analysis)
    : slots(analysis.n_slots_max), parent_slots(analysis.n_slots_max) {}

Factor::Factor(std::shared_ptr<const Analysis> analysis, const Kernels& kernels)
    : analysis_(std::move(analysis)),
      kernels_(&kernels),
      memory_(analysis_->n_factor + analysis_->n_updates),
      panels_(memory_.data()),
      updates_(panels_ + analysis_->n_factor) {
    std::fill_n(updates_, analysis_->n_updates, 0.0);  // what lies above a diagonal is read, and never used
}

FrontView Factor::view(const Front& front) const {
    FrontView view{};
    view.panel = panels_ + front.panel;
    view.stride = front.stride;
    view.n_pivots = front.n_pivots;
    view.pivot_slots = front.pivot_slots;
    view.n_slots = front.n_slots;
    view.update = updates_ + front.update;
    view.n_border = front.n_border;
    for (const std::uint32_t c : front.children) {
        if (c == Analysis::NONE) continue;
        const Front& child = analysis_->fronts[c];
        view.children[view.n_children++] = {
            updates_ + child.update, child.border_slots(), analysis_->pull_mask.data() + child.pull_blocks,
            analysis_->pull_row.data() + child.pull_blocks, analysis_->pull_column.data() + child.pull_slots};
    }
    return view;
}

void Factor::factorise(const Stencil& stencil) {
    assert(stencil.moving() == analysis_->moving && stencil.layout().size() == analysis_->layout.size());
    smallest_pivot_ratio_ = -1.0;
    double largest_inverse_ratio = 1.0;
    for (const Front& front : analysis_->fronts) {
        if (!eliminate(front, stencil.couplings(), largest_inverse_ratio)) return;
    }
    smallest_pivot_ratio_ = 1.0 / largest_inverse_ratio;
}

bool Factor::eliminate(const Front& front, const double* couplings, double& largest_inverse_ratio) {
    const FrontView v = view(front);
    kernels_->assemble(v);
    const std::uint32_t* const source = analysis_->entry_source.data() + front.first_entry;
    const std::uint32_t* const target = analysis_->entry_target.data() + front.first_entry;
    for (std::uint32_t e = 0; e < front.n_entries; ++e) panels_[target[e]] += couplings[source[e]];
    if (!kernels_->factor(v)) return false;
    kernels_->schur(v);
    for (std::uint32_t k = 0; k < front.n_pivots; ++k) {
        const double reciprocal = v.panel[k * v.stride + k];
        const double ratio = reciprocal * reciprocal * couplings[analysis_->node[front.first + k]];
        if (!(ratio <= largest_inverse_ratio)) largest_inverse_ratio = ratio;
        if (!(ratio < INFINITE)) return false;
    }
    return true;
}

double Factor::last_compliance() const {
    const Front& root = analysis_->fronts.back();
    const std::size_t last = root.n_pivots - 1;  // the root has no border
    const double reciprocal = panels_[root.panel + last * root.stride + last];
    return reciprocal * reciprocal;
}

double Factor::compliance(std::size_t number, FactorWorkspace& work) const {
    double* slots = work.slots.data();
    double* parent_slots = work.parent_slots.data();
    const Front* front = &analysis_->fronts[analysis_->owner[number]];
    std::size_t first = number - front->first;
    std::fill_n(slots, front->n_slots, 0.0);
    slots[first] = 1.0;
    double sum = 0.0;
    for (;;) {
        kernels_->forward(view(*front), first, slots);
        for (std::size_t k = first; k < front->n_pivots; ++k) sum += slots[k] * slots[k];
        if (front->parent == Analysis::NONE) return sum;
        const Front& parent = analysis_->fronts[front->parent];
        std::fill_n(parent_slots, parent.n_slots, 0.0);
        const std::uint32_t* const place = analysis_->parent_slot.data() + front->border;
        for (std::size_t r = 0; r < front->n_border; ++r)
            parent_slots[place[r]] = slots[front->pivot_slots + r];
        std::swap(slots, parent_slots);
        front = &parent;
        first = 0;
    }
}

void Factor::forward(std::span<double> x, FactorWorkspace& work) const {
    double* const slots = work.slots.data();
    for (const Front& front : analysis_->fronts) {
        const std::uint32_t* const border = analysis_->border.data() + front.border;
        double* const outside = slots + front.pivot_slots;
        std::fill_n(slots, front.n_slots, 0.0);
        std::copy_n(x.data() + front.first, front.n_pivots, slots);
        kernels_->forward(view(front), 0, slots);
        std::copy_n(slots, front.n_pivots, x.data() + front.first);
        for (std::uint32_t r = 0; r < front.n_border; ++r) x[border[r]] += outside[r];
    }
}

void Factor::backward(std::span<double> x, FactorWorkspace& work) const {
    double* const slots = work.slots.data();
    for (auto front = analysis_->fronts.rbegin(); front != analysis_->fronts.rend(); ++front) {
        const std::uint32_t* const border = analysis_->border.data() + front->border;
        double* const outside = slots + front->pivot_slots;
        std::copy_n(x.data() + front->first, front->n_pivots, slots);
        for (std::uint32_t r = 0; r < front->n_border; ++r) outside[r] = x[border[r]];
        std::fill_n(slots + front->n_pivots, front->pivot_slots - front->n_pivots, 0.0);
        std::fill_n(outside + front->n_border, front->border_slots() - front->n_border, 0.0);
        kernels_->backward(view(*front), slots);
        std::copy_n(slots, front->n_pivots, x.data() + front->first);
    }
}

void Factor::solve(std::span<double> x, FactorWorkspace& work) const {
    forward(x, work);
    backward(x, work);
}

void Factor::solve_last(std::span<double> x, FactorWorkspace& work) const {
    std::fill(x.begin(), x.end(), 0.0);
    const Front& root = analysis_->fronts.back();
    const std::size_t last = root.n_pivots - 1;
    x.back() = panels_[root.panel + last * root.stride + last];
    backward(x, work);
}

}  // namespace palpate::plate
