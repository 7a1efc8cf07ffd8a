/// The words in a picture: colour bar, labels, scale, axes, rate line. Through a Dear ImGui draw list.
#pragma once
#include <string>

#include "host/view/renderer.hpp"
#include "host/view/section.hpp"

struct ImDrawList;
struct ImFont;

namespace palpate::view {

/// A rectangle in pixels from the picture's top left corner; the far edges are outside.
struct PixelRect {
    int x0 = 0;
    int y0 = 0;
    int x1 = 0;
    int y1 = 0;
};

/// The colour bar: upright, `low` at its bottom.
struct Legend {
    float min = 0.0F;
    float max = 0.0F;
    std::string unit = "N/m";
    PixelRect bar;
    Rgb low;
    Rgb high;
    bool has_unknown = false;  ///< some values are not finite; a grey swatch says so, with the words of
    std::string unknown;       ///< body.unknown
};
/// nullopt when no point's stiffness is known, or the picture is too small for a bar.
[[nodiscard]] std::optional<Legend> legend_of(const Body& body, Size size);

/// The fonts of the pictures; null members mean Dear ImGui's own font.
struct Fonts {
    ImFont* plain = nullptr;
    ImFont* bold = nullptr;
};
/// Loads DejaVu Sans where the system has it, before the first frame of the current Dear ImGui context.
[[nodiscard]] Fonts load_fonts();

/// What a picture says besides what it shows.
struct Caption {
    std::string title;
    std::optional<Legend> legend;
    std::optional<Section> section;  ///< drawn bottom left where the picture has room
    float metres_per_newton = 0.0F;
    float dip_scale = 1.0F;
    int bottom_px = 0;  ///< kept free at the bottom (for controls)
};

void draw_overlay(ImDrawList& list, const Fonts& fonts, const Frame& frame, const Camera& camera, Size size,
                  const Caption& caption);

}  // namespace palpate::view
