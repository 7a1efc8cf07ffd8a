/// How long a call takes, and how much memory it leaves in use.
#pragma once
#include <cstddef>
#include <functional>

#include "host/study/fit.hpp"

namespace palpate::study {

/// Monotonic clock, s.
[[nodiscard]] double now_s();

struct Timing {
    double first_s = 0.0;  ///< the first call, which finds nothing warm
    Quartiles wall_s{};    ///< of the calls after it; of the first if no other was made
    std::size_t repeats = 0;
};
/// Calls once, then again until `budget_s` is used up, at least `repeats_min` and at most 201 times; a first
/// call longer than the budget is the only one. `stop` is asked between calls and may throw.
[[nodiscard]] Timing timed(const std::function<void()>& call, double budget_s,
                           const std::function<void()>& stop, std::size_t repeats_min = 3);

/// Bytes that malloc has handed out to this process and not got back (mallinfo2: main arena and mapped
/// blocks). Objects freed into a thread's small cache still count: differences below 100 kB mean little. 0
/// under a sanitizer.
[[nodiscard]] std::size_t heap_in_use_bytes();

}  // namespace palpate::study
