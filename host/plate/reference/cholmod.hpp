/// CHOLMOD against the clock: what a good general solver needs for the plate's matrix.
#pragma once
#include <istream>
#include <string>

namespace palpate::reference {

/// Reads the keys of `plate` and `budget_s` (default 0.2): seconds for each kind. K is put together anew from
/// D (MATH.md eq. 2-4), factorised with the analysis of the first time, and solved for 1 N at the contact
/// node, again and again. One JSON object: `simplicial` and `supernodal`, each with compliance_m_per_n,
/// analysis_s, first_s (with the analysis), median_s, quartile_1_s, quartile_3_s, repeats,
/// memory_peak_bytes (CHOLMOD's own count); and `blas`, the library that supernodal rests on. Throws
/// BadRequest, std::runtime_error when a factor fails.
[[nodiscard]] std::string cholmod_text(std::istream& in);

}  // namespace palpate::reference
