/// The sums that a bracket costs: plain loops over contiguous arrays in eight lanes, so that they vectorise
/// without being reassociated and give the same bits everywhere. No Eigen.
#pragma once
#include <cstddef>

namespace palpate::plate::bounds {

/// sum a_i b_i. Relative error at most n 2^-53 where no term is negative.
[[nodiscard]] double dot(const double* a, const double* b, std::size_t n);

/// sum w_i a_i^2 and sum w_i |a_i|. Relative error at most (n + 1) 2^-53 where no w is negative.
[[nodiscard]] double weighted_square(const double* a, const double* weight, std::size_t n);
[[nodiscard]] double weighted_magnitude(const double* a, const double* weight, std::size_t n);

/// sums[r] = sum_i rows[r n + i] x_i for each of `n_rows` rows of n.
void dot_rows(const double* rows, std::size_t n_rows, const double* x, std::size_t n, double* sums);

struct Extremes {
    double least, most;  ///< NaN is passed over
    bool finite;         ///< every one
};
/// reciprocals[i] = 1/x_i, and the extremes of x. n >= 1.
[[nodiscard]] Extremes invert(const double* x, std::size_t n, double* reciprocals);

}  // namespace palpate::plate::bounds
