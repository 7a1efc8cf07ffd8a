/// Stiffness to colour: viridis between the smallest and the largest finite value, grey for unknown.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace palpate::view {

struct Rgb {
    std::uint8_t r = 0;
    std::uint8_t g = 0;
    std::uint8_t b = 0;
    bool operator==(const Rgb&) const = default;
};

constexpr Rgb kUnknown{150, 150, 150};

/// viridis (Smith and van der Walt, 2015, public domain) from ten of its colours, linear between them.
[[nodiscard]] const std::array<Rgb, 256>& viridis();

/// The colour scale of a body.
struct Range {
    float min = 0.0F;
    float max = 0.0F;
    /// Nothing that labels of four digits could tell apart: rounding is not drawn as if it were a find.
    [[nodiscard]] bool is_one_value() const;
};

/// nullopt where no value is finite.
[[nodiscard]] std::optional<Range> finite_range(std::span<const float> values);

/// 0 at range.min, 1 at range.max; 0.5 where the range is one value; -1 for a value that is not finite.
[[nodiscard]] float shade(const Range& range, float value);

}  // namespace palpate::view
