#include "host/plate/batch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "host/plate/direct/entry_terms.hpp"
#include "host/plate/direct/factor.hpp"
#include "host/plate/stencil.hpp"

namespace palpate::plate {
namespace {

using Eigen::ArrayXXd;

constexpr std::size_t LANES_MAX = 8;

/// A row of a front in an analysis, without the empty slots.
std::size_t row_of(const Front& front, std::size_t slot) {
    return slot < front.n_pivots ? slot : slot - (front.pivot_slots - front.n_pivots);
}

std::size_t largest_panel(const Analysis& analysis) {
    std::size_t n = 0;
    for (const Front& front : analysis.fronts)
        n = std::max<std::size_t>(n, std::size_t{front.n_pivots} * (front.n_pivots + front.n_border));
    return n;
}

/// Where the updates lie that share a place in the analysis, and where all of them end. Each column has a
/// zero behind it.
struct UpdatePlaces {
    std::map<std::size_t, std::size_t> start;  ///< by Front::update
    std::size_t end = 0;

    explicit UpdatePlaces(const Analysis& analysis) {
        for (const Front& front : analysis.fronts) {
            std::size_t& size = start[front.update];
            size = std::max<std::size_t>(size, std::size_t{front.n_border} * (front.n_border + 1));
        }
        for (auto& place : start) end += std::exchange(place.second, end);
    }
};

}  // namespace

struct Batch::Impl {
    std::shared_ptr<const Analysis> analysis;
    const Kernels& kernels;
    std::size_t lanes;
    double side_m;
    Mask solid;
    std::vector<ArrayXXd> rigidity;  ///< by lane
    std::vector<char> usable;        ///< by lane
    std::vector<BatchFront> fronts;
    std::vector<std::uint32_t> target, n_terms;  ///< by entry of K, in each front the shortest first
    std::vector<std::uint32_t> number;           ///< by term, as in EntryTerms
    std::vector<double> factor;
    std::vector<std::uint32_t> child_row, child_column;  ///< as Analysis::pull_column, without empty slots
    UpdatePlaces places;
    AlignedDoubles panel, updates, x, scale, largest, sum;

    Impl(const Problem& problem, const Kernels& with)
        : analysis(
              analysis_for({problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols()},
                           Moving(problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols(), problem.edges))),
          kernels(with),
          lanes(with.batch.lanes),
          side_m(problem.size_m.x()),
          solid(problem.solid),
          rigidity(lanes, problem.rigidity_n_m),
          usable(lanes, 0),
          target(analysis->entry_target.size()),
          n_terms(target.size()),
          child_row(analysis->pull_column.size()),
          child_column(analysis->pull_column.size()),
          places(*analysis),
          panel(largest_panel(*analysis) * lanes),
          updates(places.end * lanes),
          x((n_nodes() + 1) * lanes),
          scale(lanes),
          largest(lanes),
          sum(lanes) {
        updates.clear();  // what lies above a diagonal is read, and never used
        std::fill_n(scale.data(), lanes, 1.0);
        const EntryTerms terms = terms_of(problem, *analysis);
        number.resize(terms.number.size());
        factor.resize(terms.factor.size());
        std::size_t term = 0;
        for (const Front& front : analysis->fronts) {
            BatchFront& placed = fronts.emplace_back(place(front));
            placed.number = number.data() + term;
            placed.factor = factor.data() + term;
            term = take_entries(front, terms, term);
            for (const std::uint32_t c : front.children) {
                if (c != Analysis::NONE)
                    placed.children[placed.n_children++] = connect(front, analysis->fronts[c]);
            }
        }
    }
    [[nodiscard]] std::size_t n_nodes() const { return static_cast<std::size_t>(rigidity.front().size()); }
    [[nodiscard]] double* update_of(const Front& front) const {
        return updates.data() + places.start.at(front.update) * lanes;
    }

    [[nodiscard]] BatchFront place(const Front& front) const {
        BatchFront placed{};
        placed.panel = panel.data();
        placed.update = update_of(front);
        placed.n_pivots = front.n_pivots;
        placed.n_rows = front.n_pivots + front.n_border;
        placed.update_stride = front.n_border + 1;
        placed.n_entries = front.n_entries;
        placed.target = target.data() + front.first_entry;
        placed.n_terms = n_terms.data() + front.first_entry;
        return placed;
    }
    /// Sums of one length follow each other, so that a processor foresees where each ends. The next term.
    [[nodiscard]] std::size_t take_entries(const Front& front, const EntryTerms& terms, std::size_t term) {
        const auto length = [&](std::uint32_t e) { return terms.first[e + 1] - terms.first[e]; };
        std::vector<std::uint32_t> order(front.n_entries);
        for (std::uint32_t k = 0; k < front.n_entries; ++k) order[k] = front.first_entry + k;
        std::stable_sort(order.begin(), order.end(),
                         [&](std::uint32_t a, std::uint32_t b) { return length(a) < length(b); });
        for (std::uint32_t k = 0; k < front.n_entries; ++k) {
            const std::uint32_t e = order[k];
            const std::size_t in_panel = analysis->entry_target[e] - front.panel;
            const std::size_t row = row_of(front, in_panel % front.stride);
            target[front.first_entry + k] =
                static_cast<std::uint32_t>(in_panel / front.stride * (front.n_pivots + front.n_border) + row);
            n_terms[front.first_entry + k] = length(e);
            for (std::uint32_t t = terms.first[e]; t < terms.first[e + 1]; ++t, ++term) {
                number[term] = terms.number[t];
                factor[term] = terms.factor[t];
            }
        }
        return term;
    }
    [[nodiscard]] BatchChild connect(const Front& parent, const Front& child) {
        const std::uint32_t* const from = analysis->pull_column.data() + child.pull_slots;
        std::uint32_t* const rows = child_row.data() + child.pull_slots;
        std::uint32_t* const columns = child_column.data() + child.pull_slots;
        for (std::size_t slot = 0; slot < parent.n_slots; ++slot) {
            if (slot >= parent.n_pivots && slot < parent.pivot_slots) continue;
            const bool none = from[slot] == Analysis::NONE;
            const std::size_t row = row_of(parent, slot);
            rows[row] = none ? child.n_border : from[slot];
            columns[row] =
                none ? Analysis::NONE : static_cast<std::uint32_t>(from[slot] * (child.n_border + 1) * lanes);
        }
        return {update_of(child), rows, columns};
    }
};

Batch::Batch(const Problem& problem, Kernel kernel) {
    require_problem(problem);
    if (problem.rigidity_n_m.rows() % 2 == 0 || problem.rigidity_n_m.cols() % 2 == 0)
        throw std::invalid_argument("the centre of the plate is no node; the node counts must be odd");
    if (problem.harmonic_x_n_m.size() != 0) throw std::invalid_argument("a batch has no jumps on grid lines");
    impl_ = std::make_unique<Impl>(problem, kernels_for(kernel));
}

Batch::~Batch() = default;
Batch::Batch(Batch&&) noexcept = default;

std::size_t Batch::lanes() const {
    return impl_->lanes;
}

void Batch::set_rigidity(std::size_t lane, const Eigen::Ref<const ArrayXXd>& rigidity_n_m) {
    ArrayXXd& kept = impl_->rigidity.at(lane);
    if (rigidity_n_m.rows() != kept.rows() || rigidity_n_m.cols() != kept.cols())
        throw std::invalid_argument("another rigidity needs the same nodes");
    const bool good = (rigidity_n_m > 0.0 && rigidity_n_m <= std::numeric_limits<double>::max()).all();
    impl_->usable[lane] = good ? 1 : 0;
    if (!good) return;
    kept = rigidity_n_m;
    double& scale = impl_->scale.data()[lane];
    if (impl_->solid.size() == 0) {
        scale = kept.maxCoeff();
        return;
    }
    scale = impl_->solid.select(kept, 0.0).maxCoeff();
    kept = impl_->solid.select(kept, FREE_EDGE * scale);
}

void Batch::centre_compliances_m_per_n(std::span<double> by_lane) {
    Impl& batch = *impl_;
    if (by_lane.size() != lanes()) throw std::invalid_argument("a batch needs one compliance per lane");
    std::array<const double*, LANES_MAX> rigidity{};
    for (std::size_t lane = 0; lane < lanes(); ++lane) rigidity[lane] = batch.rigidity[lane].data();
    batch.kernels.batch.scale(rigidity.data(), batch.scale.data(), batch.n_nodes(), batch.x.data());
    std::fill_n(batch.largest.data(), lanes(), 1.0);
    std::fill_n(batch.sum.data(), lanes(), 0.0);
    for (const BatchFront& front : batch.fronts)
        batch.kernels.batch.eliminate(front, batch.x.data(), batch.largest.data(), batch.sum.data());
    const BatchFront& root = batch.fronts.back();  // its panel is still there, and it has no border
    const double* const last = batch.panel.data() + (root.n_rows * root.n_rows - 1) * lanes();
    for (std::size_t lane = 0; lane < lanes(); ++lane) {
        const bool sound = batch.usable[lane] != 0 && std::isfinite(batch.sum.data()[lane]) &&
                           1.0 / batch.largest.data()[lane] > PIVOT_RATIO_MIN;
        by_lane[lane] =
            sound ? last[lane] * last[lane] * (batch.side_m * batch.side_m / batch.scale.data()[lane])
                  : std::numeric_limits<double>::quiet_NaN();
    }
}

const char* Batch::kernel() const {
    return impl_->kernels.name;
}

}  // namespace palpate::plate
