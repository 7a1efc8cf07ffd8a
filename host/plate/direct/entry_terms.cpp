#include "host/plate/direct/entry_terms.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/plate/stencil.hpp"

namespace palpate::plate {
namespace {

using Eigen::ArrayXXd;
using Eigen::Index;

constexpr double ABSENT = 1e-300;  ///< N m: a stencil wants every D above 0
constexpr double LEAST = 1e-200;   ///< what ABSENT leaves of an entry is far below
constexpr Index REACH = 3;         ///< nodes along each axis on which an entry depends

using Couplings = std::vector<double>;

Couplings couplings_of(Stencil& stencil, const ArrayXXd& rigidity_n_m) {
    stencil.set_rigidity(rigidity_n_m);
    return {stencil.couplings(), stencil.couplings() + N_COUPLINGS * stencil.layout().size()};
}

Problem without_mask(const Problem& problem) {
    Problem all = problem;
    if (problem.solid.size() != 0 && problem.foundation_n_per_m3.size() != 0)
        all.foundation_n_per_m3 = problem.solid.select(problem.foundation_n_per_m3, 0.0);
    all.solid.resize(0, 0);
    return all;
}

/// Of each colour, K where the nodes of that colour alone have a D. No two in reach of an entry share one.
std::array<Couplings, REACH * REACH> by_colour(const Problem& problem) {
    Problem bare = problem;
    bare.foundation_n_per_m3.resize(0, 0);
    Stencil stencil(bare);
    const Index nx = problem.rigidity_n_m.rows(), nz = problem.rigidity_n_m.cols();
    std::array<Couplings, REACH * REACH> all;
    for (Index colour = 0; colour < REACH * REACH; ++colour) {
        const ArrayXXd d = ArrayXXd::NullaryExpr(nx, nz, [=](Index ix, Index iz) {
            return ix % REACH + REACH * (iz % REACH) == colour ? 1.0 : ABSENT;
        });
        all[static_cast<std::size_t>(colour)] = couplings_of(stencil, d);
    }
    return all;
}

/// K of the foundation alone: one corner has a D, to be the scale, and no entry feels two corners.
Couplings of_foundation(const Problem& problem) {
    Stencil stencil(problem);
    const Index nx = problem.rigidity_n_m.rows(), nz = problem.rigidity_n_m.cols();
    ArrayXXd d = ArrayXXd::Constant(nx, nz, ABSENT);
    d(0, 0) = 1.0;
    Couplings least = couplings_of(stencil, d);
    std::swap(d(0, 0), d(nx - 1, nz - 1));
    const Couplings other = couplings_of(stencil, d);
    for (std::size_t i = 0; i < least.size(); ++i) {
        if (std::fabs(other[i]) < std::fabs(least[i])) least[i] = other[i];
    }
    return least;
}

}  // namespace

EntryTerms terms_of(const Problem& problem, const Analysis& analysis) {
    const Layout& layout = analysis.layout;
    const Problem all = without_mask(problem);
    const auto colours = by_colour(all);
    const Couplings foundation = of_foundation(all);
    EntryTerms terms;
    const auto add = [&](double factor, Index number) {
        if (!(std::fabs(factor) > LEAST)) return;
        terms.factor.push_back(factor);
        terms.number.push_back(static_cast<std::uint32_t>(number));
    };
    for (const std::uint32_t source : analysis.entry_source) {
        terms.first.push_back(static_cast<std::uint32_t>(terms.factor.size()));
        const Index at = Index{source} % static_cast<Index>(layout.size());
        const Index ix = at % layout.stride() - Layout::PADDING, iz = at / layout.stride() - Layout::PADDING;
        for (Index z = std::max<Index>(iz - 1, 0); z < std::min(iz + 2, layout.nz); ++z) {
            for (Index x = std::max<Index>(ix - 1, 0); x < std::min(ix + 2, layout.nx); ++x)
                add(colours[static_cast<std::size_t>(x % REACH + REACH * (z % REACH))][source],
                    x + layout.nx * z);
        }
        add(foundation[source], layout.nx * layout.nz);
    }
    terms.first.push_back(static_cast<std::uint32_t>(terms.factor.size()));
    return terms;
}

}  // namespace palpate::plate
