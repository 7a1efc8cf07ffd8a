#include "tests/host/plate/counting_heap.hpp"

#include <atomic>
#include <cerrno>
#include <cstddef>

// glibc's own, by their other names; operator new and Eigen come through those below.
extern "C" {
void* __libc_malloc(std::size_t n);                           // NOLINT(bugprone-reserved-identifier)
void* __libc_calloc(std::size_t n, std::size_t size);         // NOLINT(bugprone-reserved-identifier)
void* __libc_realloc(void* memory, std::size_t n);            // NOLINT(bugprone-reserved-identifier)
void* __libc_memalign(std::size_t alignment, std::size_t n);  // NOLINT(bugprone-reserved-identifier)
}

namespace {

std::atomic<long> n_made{0};  // NOLINT(*-avoid-non-const-global-variables)

}  // namespace

extern "C" {
void* malloc(std::size_t n) noexcept {
    ++n_made;
    return __libc_malloc(n);
}
void* calloc(std::size_t n, std::size_t size) noexcept {
    ++n_made;
    return __libc_calloc(n, size);
}
void* realloc(void* memory, std::size_t n) noexcept {
    ++n_made;
    return __libc_realloc(memory, n);
}
void* aligned_alloc(std::size_t alignment, std::size_t n) noexcept {
    ++n_made;
    return __libc_memalign(alignment, n);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t n) noexcept {
    ++n_made;
    *memory = __libc_memalign(alignment, n);
    return *memory == nullptr ? ENOMEM : 0;
}
}

namespace palpate::plate {

long n_allocations() {
    return n_made;
}

}  // namespace palpate::plate
