#include "host/plate/bounds/bounds.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>

#include "host/plate/bounds/kernels.hpp"
#include "host/plate/bounds/krylov.hpp"
#include "host/plate/bounds/member.hpp"
#include "host/plate/bounds/rungs.hpp"
#include "host/plate/stencil.hpp"

namespace palpate::plate {
namespace {

/// D in N m beyond which squares of it would leave double's range.
constexpr double UNSCALED_MOST = 1e60;

using bounds::Keep;
using bounds::Member;
using bounds::Range;
using bounds::Weights;

constexpr double ANCHOR_RATIO = 1.5;  ///< between anchors, members that keep modes and a factor, at most

double squared(double x) {
    return x * x;
}

std::span<const double> span_of(const Eigen::ArrayXXd& field) {
    return {field.data(), static_cast<std::size_t>(field.size())};
}

/// Refuses a load that does nothing, or pulls.
void require_load(const Problem& problem, std::span<const double> force_n) {
    const Eigen::Index nx = problem.rigidity_n_m.rows(), nz = problem.rigidity_n_m.cols();
    if (static_cast<Eigen::Index>(force_n.size()) != nx * nz)
        throw std::invalid_argument("a load needs one force per node");
    const Moving moving(nx, nz, problem.edges);
    double total = 0.0;
    for (Eigen::Index iz = moving.z0; iz < moving.z1; ++iz) {
        for (Eigen::Index ix = moving.x0; ix < moving.x1; ++ix) {
            const double f = force_n[static_cast<std::size_t>(ix + iz * nx)];
            if (!(f >= 0.0 && f < 1e100)) throw std::invalid_argument("forces must be finite, none negative");
            total += f;
        }
    }
    if (!(total > 0.0)) throw std::invalid_argument("no force acts on a node that can move");
}

}  // namespace

/// What one call needs and leaves.
struct Bounds::Scratch::Impl {
    std::vector<double> d, inverse_d, k, inverse_k;
    double scale = 1.0;  ///< D and k were multiplied by it
    bounds::Krylov krylov;
    Weights weights{};
    double ratio = 0.0;  ///< k over D, means where the load is felt
    Rung rung = Rung::extremes;

    Impl(const bounds::Setting& setting, bool with_foundation)
        : d(setting.strains.grid().nx * setting.strains.grid().nz),
          inverse_d(d.size()),
          k(with_foundation ? inverse_d.size() : 0),
          inverse_k(k.size()),
          krylov(setting) {}
};

struct Bounds::Impl {
    bounds::Setting setting;
    const bounds::SumKernels& sums;
    bool with_foundation;
    double side_m;                ///< along x
    std::vector<Member> members;  ///< bare, then foundations growing; bare, first and every few an anchor

    Impl(const Problem& problem, std::span<const double> force, const Foundations& foundations, Kernel kernel)
        : setting(problem, force),
          sums(bounds::sum_kernels_for(kernel)),
          with_foundation(problem.foundation_n_per_m3.size() != 0),
          side_m(problem.size_m.x()) {
        const double shorter = std::min(1.0, problem.size_m.y() / problem.size_m.x());
        members.push_back(make_member(setting, 0.0, with_foundation, Keep::anchor));
        double since_anchor = ANCHOR_RATIO;
        for (double s = foundations.first; with_foundation && s < foundations.last * foundations.ratio;
             s *= foundations.ratio) {
            since_anchor *= foundations.ratio;
            const bool anchor = since_anchor > ANCHOR_RATIO;
            if (anchor) since_anchor = 1.0;
            members.push_back(make_member(setting, squared(squared(s / shorter)), with_foundation,
                                          anchor ? Keep::anchor : Keep::sums));
        }
    }

    [[nodiscard]] std::size_t n() const { return setting.strains.grid().nx * setting.strains.grid().nz; }
    [[nodiscard]] std::size_t nearest(double k, bool anchors_only) const;
    struct Trials {
        const Member &below, &above;
    };
    /// The anchors that serve best where the load feels this k over D.
    [[nodiscard]] Trials trials(const Weights& w, double ratio) const {
        const Member& below = members[nearest(ratio, true)];
        return {below, bounds::can_bound_above(below, w) ? below : members[0]};
    }
    Weights weights(std::span<const double> d, std::span<const double> k, Scratch::Impl& scratch) const;
    Range climb(const Weights& weights, const Climb& climb, Scratch::Impl& scratch) const;
    void climb_uniform(const Weights& weights, Scratch::Impl& scratch, Range& range) const;
};

/// The member whose foundation over rigidity is nearest to `k`, as a ratio. The bare plate counts as a
/// quarter of the first foundation.
std::size_t Bounds::Impl::nearest(double k, bool anchors_only) const {
    std::size_t best = 0;
    double best_ratio = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < members.size(); ++i) {
        if (anchors_only && members[i].plate == nullptr) continue;
        const double own = i > 0 ? members[i].k0 : (members.size() > 1 ? 0.25 * members[1].k0 : 1.0);
        const double ratio = k > own ? k / own : own / k;
        if (!(ratio < best_ratio)) continue;
        best = i;
        best_ratio = ratio;
    }
    return best;
}

/// Checks D and k_f; reciprocals and extremes.
Weights Bounds::Impl::weights(std::span<const double> d, std::span<const double> k,
                              Scratch::Impl& scratch) const {
    if (d.size() != n() || (!k.empty() && k.size() != n()))
        throw std::invalid_argument("rigidity and foundation need one value per node");
    if (!k.empty() && !with_foundation)
        throw std::invalid_argument("these bounds were made for plates without a foundation");
    auto ends = sums.invert(d.data(), d.size(), scratch.inverse_d.data());
    if (!(ends.finite && ends.least >= std::numeric_limits<double>::min()))
        throw std::invalid_argument("rigidity must be positive and finite at every node");
    scratch.scale = 1.0;
    if (!(ends.most <= UNSCALED_MOST && ends.least >= 1.0 / UNSCALED_MOST)) {
        scratch.scale = std::ldexp(1.0, -std::ilogb(ends.most));  // a power of two: exact
        for (std::size_t i = 0; i < d.size(); ++i) scratch.d[i] = d[i] * scratch.scale;
        d = scratch.d;
        ends = sums.invert(d.data(), d.size(), scratch.inverse_d.data());
    }
    Weights weights{d, scratch.inverse_d, {}, {}, ends.least, ends.most, 0.0, 0.0, &sums};
    if (k.empty()) return weights;
    const double side4 = squared(squared(side_m));
    const auto k_ends = sums.scale_and_invert(k.data(), k.size(), scratch.scale, side4, scratch.k.data(),
                                              scratch.inverse_k.data());
    if (!(k_ends.finite && k_ends.least >= 0.0))
        throw std::invalid_argument("foundation must be finite and not negative at every node");
    if (!(k_ends.most > 0.0)) return weights;
    weights.k = scratch.k;
    weights.inverse_k = scratch.inverse_k;
    weights.k_least = k_ends.least;
    weights.k_most = k_ends.most;
    return weights;
}

/// The bare plate's trial, then that of the foundation which the load feels, and once more with what that
/// says.
void Bounds::Impl::climb_uniform(const Weights& w, Scratch::Impl& scratch, Range& range) const {
    constexpr int N_FURTHER = 2;
    scratch.ratio = 0.0;
    for (std::size_t at = 0, pass = 0;; ++pass) {
        const Member& member = members[at];
        const bounds::Energies energies = bounds::energies(member, w);
        bounds::uniform_rung(member, w, energies, range);
        if (w.k.empty()) return;
        scratch.ratio =
            (energies.foundation / member.foundation_sum) / (energies.bending / member.bending_sum);
        const std::size_t next = nearest(scratch.ratio, false);
        if (next == at || pass == N_FURTHER) return;
        at = next;
    }
}

Range Bounds::Impl::climb(const Weights& w, const Climb& climb, Scratch::Impl& scratch) const {
    Range range;
    const auto enough = [&](Rung rung) {
        scratch.rung = rung;
        return climb.last == rung || std::sqrt(range.upper / range.lower) - 1.0 <= climb.relative_error;
    };
    scratch.ratio = 0.0;
    extremes_rung(members[0], w, range);
    if (!w.k.empty()) {  // only a foundation bounds a foundation from below
        const std::size_t below = nearest(w.k_most / w.d_most, false);
        extremes_rung(members[below > 0 ? below : 1], w, range);
        extremes_rung(members[nearest(w.k_least / w.d_least, false)], w, range);
        scratch.ratio = w.k_most / w.d_most;
    }
    if (enough(Rung::extremes)) return range;

    climb_uniform(w, scratch, range);
    if (enough(Rung::uniform)) return range;

    const auto& [below, above] = trials(w, scratch.ratio);
    modes_lower_rung(below, w, range);
    modes_upper_rung(above, w, range);
    if (enough(Rung::modes)) return range;

    scratch.krylov.start(below, above, w);
    for (const Rung rung : {Rung::krylov2, Rung::krylov3, Rung::krylov4}) {
        scratch.krylov.step();
        range.meet(scratch.krylov.lower(), scratch.krylov.upper());
        if (enough(rung)) break;
    }
    return range;
}

const char* name_of(Rung rung) {
    constexpr std::array NAMES{"extremes", "uniform", "modes", "krylov-2", "krylov-3", "krylov-4"};
    return NAMES[static_cast<std::size_t>(rung)];
}

double uniform_rung_error(double d_least, double d_most) {
    const double ratio = d_most / d_least;
    return 0.5 * (ratio + 1.0) / std::sqrt(ratio) - 1.0;
}

std::optional<std::string> Bounds::none_because(const Problem& problem) {
    if (auto words = problem_with(problem)) return words;
    if (problem.solid.size() != 0 && !problem.solid.all())
        return "no certificate for a plate with holes or an outline of its own";
    if (problem.harmonic_x_n_m.size() != 0 && !((problem.harmonic_x_n_m == problem.rigidity_n_m).all() &&
                                                (problem.harmonic_z_n_m == problem.rigidity_n_m).all()))
        return "no certificate for a laminate: its energy is no multiple of one rigidity per node";
    if (problem.poisson_at_nodes.size() != 0 &&
        !(problem.poisson_at_nodes == problem.poisson_at_nodes(0, 0)).all())
        return "no certificate where Poisson's ratio varies";
    Problem bare = problem;
    bare.foundation_n_per_m3.resize(0, 0);
    if (problem_with(bare)) return "no certificate for a plate that only its foundation holds";
    return std::nullopt;
}

Bounds::Bounds(const Problem& grid_of, std::span<const double> force_n, Kernel kernel)
    : Bounds(grid_of, force_n, Foundations{}, kernel) {}

Bounds::Bounds(const Problem& grid_of, std::span<const double> force_n, const Foundations& foundations,
               Kernel kernel) {
    if (const auto words = none_because(grid_of)) throw std::invalid_argument(*words);
    if (!(foundations.ratio > 1.0 && foundations.first > 0.0 && foundations.last >= foundations.first &&
          foundations.last < 1e4))
        throw std::invalid_argument("foundations must grow by a ratio above 1, from above 0 to below 1e4");
    require_load(grid_of, force_n);
    impl_ = std::make_unique<Impl>(grid_of, force_n, foundations, kernel);
}

Bounds::~Bounds() = default;
Bounds::Bounds(Bounds&&) noexcept = default;

Bounds::Scratch::Scratch(const Bounds& bounds)
    : impl_(std::make_unique<Impl>(bounds.impl_->setting, bounds.impl_->with_foundation)) {}
Bounds::Scratch::~Scratch() = default;
Bounds::Scratch::Scratch(Scratch&&) noexcept = default;

Bracket Bounds::bracket(std::span<const double> rigidity_n_m, std::span<const double> foundation_n_per_m3,
                        const Climb& climb, Scratch& scratch) const {
    scratch.impl_->weights = impl_->weights(rigidity_n_m, foundation_n_per_m3, *scratch.impl_);
    const Range range = impl_->climb(scratch.impl_->weights, climb, *scratch.impl_);
    const double m2 = squared(impl_->side_m) * scratch.impl_->scale, slack = 4.0 * bounds::EPSILON;
    return {range.lower * m2 * (1.0 - slack), range.upper * m2 * (1.0 + slack), scratch.impl_->rung};
}

const char* Bounds::kernel() const {
    return impl_->sums.name;
}

std::vector<Bounds::Uniform> Bounds::uniforms() const {
    std::vector<Uniform> uniforms;
    for (const Member& member : impl_->members) {
        const double c = 0.5 * (member.compliance_low + member.compliance_high);
        uniforms.push_back({member.k0 / squared(squared(impl_->side_m)), c * squared(impl_->side_m)});
    }
    return uniforms;
}

void Bounds::energy_shares(Scratch& scratch, std::span<double> rigidity, std::span<double> foundation) const {
    Scratch::Impl& s = *scratch.impl_;
    if (s.rung < Rung::krylov2) {
        const auto& [below, above] = impl_->trials(s.weights, s.ratio);
        s.krylov.start(below, above, s.weights);
        s.krylov.step();
    }
    s.krylov.energy_shares(rigidity, foundation);
}

Bracket bracket(const Problem& problem, std::span<const double> force_n, const Climb& climb) {
    const Bounds bounds(problem, force_n);
    Bounds::Scratch scratch(bounds);
    return bounds.bracket(span_of(problem.rigidity_n_m), span_of(problem.foundation_n_per_m3), climb,
                          scratch);
}

}  // namespace palpate::plate
