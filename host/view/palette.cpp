#include "host/view/palette.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::view {
namespace {

/// At 0, 1/9, ... 1 of the scale.
constexpr std::array<Rgb, 10> kControl{{{0x44, 0x01, 0x54},
                                        {0x48, 0x28, 0x78},
                                        {0x3e, 0x49, 0x89},
                                        {0x31, 0x68, 0x8e},
                                        {0x26, 0x82, 0x8e},
                                        {0x1f, 0x9e, 0x89},
                                        {0x35, 0xb7, 0x79},
                                        {0x6e, 0xce, 0x58},
                                        {0xb5, 0xde, 0x2b},
                                        {0xfd, 0xe7, 0x25}}};

std::uint8_t between(std::uint8_t a, std::uint8_t b, float t) {
    return static_cast<std::uint8_t>(
        std::lround((1.0F - t) * static_cast<float>(a) + t * static_cast<float>(b)));
}

std::array<Rgb, 256> make_viridis() {
    std::array<Rgb, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
        const float at = static_cast<float>(i) / 255.0F * static_cast<float>(kControl.size() - 1);
        const std::size_t low = std::min(static_cast<std::size_t>(at), kControl.size() - 2);
        const float t = at - static_cast<float>(low);
        const Rgb& a = kControl[low];
        const Rgb& b = kControl[low + 1];
        table[i] = {between(a.r, b.r, t), between(a.g, b.g, t), between(a.b, b.b, t)};
    }
    return table;
}

}  // namespace

const std::array<Rgb, 256>& viridis() {
    static const std::array<Rgb, 256> table = make_viridis();
    return table;
}

std::optional<Range> finite_range(std::span<const float> values) {
    std::optional<Range> range;
    for (const float value : values) {
        if (!std::isfinite(value)) continue;
        if (!range) range = Range{value, value};
        range->min = std::min(range->min, value);
        range->max = std::max(range->max, value);
    }
    return range;
}

bool Range::is_one_value() const {
    return !(max - min > 1e-4F * std::max(std::fabs(min), std::fabs(max)));
}

float shade(const Range& range, float value) {
    if (!std::isfinite(value)) return -1.0F;
    if (range.is_one_value()) return 0.5F;
    return std::clamp((value - range.min) / (range.max - range.min), 0.0F, 1.0F);
}

}  // namespace palpate::view
