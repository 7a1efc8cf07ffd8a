/// Linked into a test program, counts what it takes from the heap (glibc): malloc and its kin, and so
/// operator new and Eigen.
#pragma once

namespace palpate::plate {

/// Calls since the program began.
[[nodiscard]] long n_allocations();

}  // namespace palpate::plate
