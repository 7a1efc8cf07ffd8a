/// K's entries as sums over the nodes' rigidities: for many D on one grid, where K itself is never wanted.
#pragma once
#include <cstdint>
#include <vector>

#include "host/plate/direct/analysis.hpp"
#include "host/plate/problem.hpp"

namespace palpate::plate {

/// Entry e of the analysis is the sum of factor[t] x[number[t]], first[e] <= t < first[e + 1], in units of
/// s/side^2, s any rigidity in N m: x[ix + nx iz] = D(ix, iz)/s, and x[nx nz] = 1 N m/s, for the foundation.
struct EntryTerms {
    std::vector<std::uint32_t> first, number;
    std::vector<double> factor;
};

/// Found by asking the stencil, in which an entry depends on D in the 3 x 3 nodes about its own (MATH.md
/// eq. 58). Where `problem.solid` is false, D is the caller's to set. No jumps of D on grid lines.
[[nodiscard]] EntryTerms terms_of(const Problem& problem, const Analysis& analysis);

}  // namespace palpate::plate
