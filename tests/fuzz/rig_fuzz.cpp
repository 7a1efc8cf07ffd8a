// Modbus frames from anyone: whatever the bytes, the reader stays inside them and lets only requests through
// that the map can answer.
#include <cstdlib>

#include "host/rig/frame.hpp"

using namespace palpate::rig;

namespace {

void require(bool claim) {
    if (!claim) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t n_bytes) {
    constexpr Sizes SIZES{.n_words = 26, .n_coils = 2};
    std::span<const std::uint8_t> rest(data, n_bytes);
    for (;;) {
        const std::optional<std::size_t> length = frame_bytes(rest);
        if (!length) return 0;
        require(*length <= FRAME_MAX_BYTES);
        if (*length == 0) {
            require(rest.size() < FRAME_MAX_BYTES);  // a full buffer always holds a whole frame
            return 0;
        }
        require(*length <= rest.size());
        const auto frame = rest.first(*length);
        require(frame_bytes(frame) == length);
        require(frame_bytes(frame.first(*length - 1)) == 0U);
        if (verdict_on(frame, SIZES) == Verdict::Answer) {
            const CoilWrite write = coil_write(frame);
            require(write.mask < 1U << SIZES.n_coils);
            require((write.values & ~write.mask) == 0);
        }
        rest = rest.subspan(*length);
    }
}
