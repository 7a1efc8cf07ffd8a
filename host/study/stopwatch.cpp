#include "host/study/stopwatch.hpp"

#include <malloc.h>

#include <chrono>
#include <vector>

namespace palpate::study {

double now_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Timing timed(const std::function<void()>& call, double budget_s, const std::function<void()>& stop,
             std::size_t repeats_min) {
    constexpr std::size_t REPEATS_MAX = 201;
    const double begin_s = now_s();
    call();
    Timing timing{now_s() - begin_s, {}, 1};
    std::vector<double> walls_s;
    while (timing.first_s <= budget_s && walls_s.size() < REPEATS_MAX &&
           (walls_s.size() < repeats_min || now_s() - begin_s < budget_s)) {
        stop();
        const double from_s = now_s();
        call();
        walls_s.push_back(now_s() - from_s);
    }
    if (walls_s.empty()) walls_s.push_back(timing.first_s);
    timing.repeats = walls_s.size();
    timing.wall_s = quartiles(walls_s);
    return timing;
}

std::size_t heap_in_use_bytes() {
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

}  // namespace palpate::study
