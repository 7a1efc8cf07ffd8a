/// The sums that a bracket costs, compiled for several instruction sets: over contiguous arrays in eight
/// lanes whatever the registers' width, without contraction. Every set gives the same bits. No Eigen here.
#pragma once
#include <cstddef>

namespace palpate::plate {

enum class Kernel;  // host/plate/solver.hpp

namespace bounds {

struct Pair {
    double first, second;
};
struct Extremes {
    double least, most;  ///< NaN is passed over
    bool finite;         ///< every one
};

struct SumKernels {
    const char* name;  ///< `baseline`, `x86-64-v3`, `x86-64-v4`
    /// sum a_i b_i. Relative error at most n 2^-53 where no term is negative.
    double (*dot)(const double* a, const double* b, std::size_t n);
    /// The same of a with b and with c: a is read once.
    Pair (*dot_both)(const double* a, const double* b, const double* c, std::size_t n);
    /// sum w_i a_i^2 and sum w_i |a_i|. Relative error at most (n + 1) 2^-53 where no w is negative.
    double (*weighted_square)(const double* a, const double* weight, std::size_t n);
    double (*weighted_magnitude)(const double* a, const double* weight, std::size_t n);
    /// sums[r] = sum_i rows[r n + i] x_i for each of `n_rows` rows of n.
    void (*dot_rows)(const double* rows, std::size_t n_rows, const double* x, std::size_t n, double* sums);
    /// reciprocals[i] = 1/x_i, and the extremes of x. n >= 1.
    Extremes (*invert)(const double* x, std::size_t n, double* reciprocals);
    /// scaled[i] = (x_i scale) unit, their reciprocals and extremes. n >= 1.
    Extremes (*scale_and_invert)(const double* x, std::size_t n, double scale, double unit, double* scaled,
                                 double* reciprocals);
};

extern const SumKernels SUM_KERNELS_BASELINE;
#ifdef PALPATE_X86_KERNELS
extern const SumKernels SUM_KERNELS_V3;
extern const SumKernels SUM_KERNELS_V4;
#endif

/// Those that this processor can run, the baseline first, the widest last.
struct RunnableSums {
    const SumKernels* sets[3];  // NOLINT(*-avoid-c-arrays)
    std::size_t n;
};
[[nodiscard]] RunnableSums runnable_sums();

/// `portable`: the baseline; `best`: the widest.
[[nodiscard]] const SumKernels& sum_kernels_for(Kernel kernel);

}  // namespace bounds
}  // namespace palpate::plate
