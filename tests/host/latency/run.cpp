#include "tests/host/latency/run.hpp"

namespace sample {

std::vector<pal_tick> run(std::size_t n, std::uint32_t late_ns) {
    std::vector<pal_tick> out(n);
    for (std::size_t i = 0; i < n; ++i) {
        pal_tick& tick = out[i];
        tick = {};
        tick.tick = static_cast<std::uint32_t>(i);
        tick.state = PAL_STATE_ENABLED;
        tick.t_ns = T0_NS + i * 1000000 + late_ns;
        tick.wake_late_ns = late_ns;
        tick.stamp_ns[1] = tick.t_ns;
        tick.stamp_ns[0] = tick.t_ns + 5000;
        tick.stamp_ns[2] = tick.t_ns + 6000;
        tick.stamp_ns[3] = tick.t_ns + 20000;
        tick.stamp_ns[4] = tick.t_ns + 23000;
        tick.stamp_ns[5] = i == 0 ? 0 : out[i - 1].stamp_ns[4] + 400000;
    }
    return out;
}

void shift(pal_tick& tick, std::int64_t by_ns) {
    const auto by = static_cast<std::uint64_t>(by_ns);
    tick.t_ns += by;
    for (int i = 0; i < 5; ++i) tick.stamp_ns[i] += by;
}

}  // namespace sample
