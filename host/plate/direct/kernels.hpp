/// The dense arithmetic of the plate's Cholesky, compiled for several instruction sets. Plain pointers: a
/// front's slots are a multiple of 8, empty slots hold zeros.
#pragma once
#include <cstddef>
#include <cstdint>

namespace palpate::plate {

enum class Kernel;  // host/plate/solver.hpp

/// A child's Schur complement, and where it goes in its parent's slots (Analysis::pull_*).
struct ChildView {
    const double* update;  ///< lower triangle, columns `stride` apart; 8 more numbers may be read behind it
    std::size_t stride;
    const std::uint8_t* mask;     ///< by blocks of 8 of the parent's slots
    const std::uint32_t* row;     ///< by blocks of 8 of the parent's slots
    const std::uint32_t* column;  ///< by the parent's slots; -1: none
};

/// A front in memory. `panel` has n_pivots columns of n_slots numbers: the pivots' rows in the first
/// pivot_slots, the border's behind. After `factor` the diagonal holds 1/L_kk.
struct FrontView {
    double* panel;
    std::size_t stride;
    std::size_t n_pivots, pivot_slots, n_slots;
    double* update;  ///< lower triangle, columns n_slots - pivot_slots apart
    std::size_t n_border;
    ChildView children[2];  // NOLINT(*-avoid-c-arrays): plain, for the kernels
    std::size_t n_children;
};

/// The same for several patches at once, one in each lane: each number is `lanes` doubles, columns are n_rows
/// such numbers, pivots first, without empty slots.
struct BatchChild {
    const double* update;
    const std::uint32_t* row;     ///< by the parent's rows: the child's there, or its row of zeros
    const std::uint32_t* column;  ///< by the parent's rows: from `update` to the child's column; -1: none
};
struct BatchFront {
    double* panel;
    double* update;  ///< lower triangle, columns update_stride numbers apart, a zero below each
    std::size_t n_pivots, n_rows, update_stride;
    std::size_t n_entries;                  ///< of K
    const std::uint32_t *target, *n_terms;  ///< by entry: its place in the panel, how many terms it has
    const std::uint32_t* number;            ///< by term, entry after entry: which of x
    const double* factor;                   ///< by term (EntryTerms)
    BatchChild children[2];                 // NOLINT(*-avoid-c-arrays)
    std::size_t n_children;
};
struct BatchKernels {
    std::size_t lanes;
    /// x[i] = d[i]/scale, i < n, and x[n] = 1/scale, of each lane; x: lanes side by side.
    void (*scale)(const double* const* d, const double* scale, std::size_t n, double* x);
    /// Assembles and factors a front from x. Takes the largest and the sum of K_kk/L_kk^2 on, by lane: not
    /// finite where a pivot failed.
    void (*eliminate)(const BatchFront& front, const double* x, double* inverse_ratio,
                      double* inverse_ratio_sum);
};

struct Kernels {
    const char* name;  ///< `baseline`, `x86-64-v3`, `x86-64-v4`
    /// Panel and update become the sum of the children's updates; the panel zero where there is none.
    void (*assemble)(const FrontView& front);
    /// Cholesky of the panel. False when a pivot is not positive.
    bool (*factor)(const FrontView& front);
    /// update -= L21 L21'; of a leaf, update = -L21 L21'.
    void (*schur)(const FrontView& front);
    /// x: n_slots numbers. Solves with L from pivot `first` on (those before must be zero), and takes what
    /// that does to the border off its slots.
    void (*forward)(const FrontView& front, std::size_t first, double* x);
    /// x: n_slots numbers, the border's known. Solves with L' for the pivots'.
    void (*backward)(const FrontView& front, double* x);
    BatchKernels batch;
};

/// Plain C++ in vectors of two, no contraction: the same bits from every compiler at every level.
extern const Kernels KERNELS_BASELINE;
#ifdef PALPATE_X86_KERNELS
extern const Kernels KERNELS_V3;  ///< AVX2, FMA
extern const Kernels KERNELS_V4;  ///< AVX-512 F, BW, CD, DQ, VL
#endif

/// Those that this processor can run, the baseline first, the widest last.
struct RunnableKernels {
    const Kernels* sets[3];  // NOLINT(*-avoid-c-arrays)
    std::size_t n;
};
[[nodiscard]] RunnableKernels runnable_kernels();

/// `portable`: the baseline; `best`: the widest.
[[nodiscard]] const Kernels& kernels_for(Kernel kernel);

}  // namespace palpate::plate
