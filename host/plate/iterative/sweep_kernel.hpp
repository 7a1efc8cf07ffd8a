/// Sweeps over a plate's grid, compiled once per instruction set. No Eigen here: an inline function compiled
/// for a newer machine must not be linked into the rest.
#pragma once
#include <cstddef>

namespace palpate::plate {

/// A stencil for the kernels (stencil.hpp's Layout and Coupling). Nodes `first` to `end` of the layout are
/// visited in one go: couplings and inverse diagonal are 0 wherever nothing moves, so nothing happens there.
struct SweepGrid {
    static constexpr std::size_t N_FORWARD = 6;
    const double* inverse_diagonal;
    const double* centre;
    const double* forward[N_FORWARD];
    std::ptrdiff_t offset[N_FORWARD];
    std::size_t first, end;
};

/// |next - x|^2 and |next|^2 of two iterates.
struct Change {
    double difference_squared, next_squared;
};

/// Vectors are in the grid's layout, do not overlap, and are 0 where nothing moves. Sums run in one fixed
/// order, and no kernel contracts a*b + c: every instruction set gives the same bits.
struct SweepKernel {
    /// `baseline`, `x86-64-v3`, `x86-64-v4`.
    const char* name;
    /// next = keep x + omega diag(K)^-1 (f - K x). keep = 1: Jacobi's sweep.
    void (*sweep)(const SweepGrid&, const double* f, const double* x, double* next, double keep,
                  double omega);
    /// next = x + momentum (x - next) + omega diag(K)^-1 (f - K x): `next` holds the iterate before x.
    void (*sweep_on)(const SweepGrid&, const double* f, const double* x, double* next, double momentum,
                     double omega);
    /// r = f - K x.
    void (*residual)(const SweepGrid&, const double* f, const double* x, double* r);
    /// y = K x; returns x'y.
    double (*apply)(const SweepGrid&, const double* x, double* y);
    /// next = omega diag(K)^-1 f.
    void (*start)(const SweepGrid&, const double* f, double* next, double omega);
    double (*dot)(std::size_t n, const double* a, const double* b);
    /// y = x + beta y.
    void (*add_to)(std::size_t n, const double* x, double beta, double* y);
    /// x += alpha p, r -= alpha q. Returns max |r|, in which NaN does not show.
    double (*step)(std::size_t n, double alpha, const double* p, const double* q, double* x, double* r);
    Change (*change)(std::size_t n, const double* x, const double* next);
};

extern const SweepKernel SWEEP_KERNEL_BASELINE;
#ifdef PALPATE_X86_KERNELS
extern const SweepKernel SWEEP_KERNEL_V3;  ///< AVX2
extern const SweepKernel SWEEP_KERNEL_V4;  ///< AVX-512 F, BW, CD, DQ, VL
#endif

}  // namespace palpate::plate
