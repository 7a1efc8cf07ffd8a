/// Memory that two threads or processes share, and how it is touched: for the .c files that do, not for their
/// callers. In production compiler builtins and nothing more. With PAL_ATOMIC_HOOK defined the same calls go
/// to a test: an explorer that runs the shipped files through all executions (tests/common/explore.hpp), or
/// one that spoils what was copied (tests/firmware/hostile_copy_test.cpp).
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#ifdef __cplusplus
extern "C" {
#endif

#ifdef PAL_ATOMIC_HOOK
uint32_t pal_atomic_load_relaxed(const uint32_t* word);
uint32_t pal_atomic_load_acquire(const uint32_t* word);
void pal_atomic_store_relaxed(uint32_t* word, uint32_t value);
void pal_atomic_store_release(uint32_t* word, uint32_t value);
bool pal_atomic_swap(uint32_t* word, uint32_t* seen, uint32_t next);
void pal_note_read(const void* place);
void pal_note_write(const void* place);
void pal_copy_once(void* copy, const void* shared, size_t n_bytes);
#else

static inline uint32_t pal_atomic_load_relaxed(const uint32_t* word) {
    return __atomic_load_n(word, __ATOMIC_RELAXED);
}

static inline uint32_t pal_atomic_load_acquire(const uint32_t* word) {
    return __atomic_load_n(word, __ATOMIC_ACQUIRE);
}

static inline void pal_atomic_store_relaxed(uint32_t* word, uint32_t value) {
    __atomic_store_n(word, value, __ATOMIC_RELAXED);
}

static inline void pal_atomic_store_release(uint32_t* word, uint32_t value) {
    __atomic_store_n(word, value, __ATOMIC_RELEASE);
}

/// Compare-and-exchange, acquire and release: true when *word was *seen and is `next` now; otherwise *seen is
/// what it was, acquired.
static inline bool pal_atomic_swap(uint32_t* word, uint32_t* seen, uint32_t next) {
    return __atomic_compare_exchange_n(word, seen, next, false, __ATOMIC_ACQ_REL, __ATOMIC_ACQUIRE);
}

/// Plain memory that changes hands by an atomic is read here. Nothing in production.
static inline void pal_note_read(const void* place) {
    (void)place;
}

/// The same, written.
static inline void pal_note_write(const void* place) {
    (void)place;
}

/// Copies memory that a broken or hostile process may be writing. Afterwards the copy alone counts: the
/// compiler may not read the original again, so what was checked is what is used.
static inline void pal_copy_once(void* copy, const void* shared, size_t n_bytes) {
    memcpy(copy, shared, n_bytes);
    __atomic_signal_fence(__ATOMIC_SEQ_CST);
}
#endif

#ifdef __cplusplus
}
#endif
