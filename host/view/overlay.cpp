#include "host/view/overlay.hpp"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>

namespace palpate::view {
namespace {

constexpr ImU32 kInk = IM_COL32(28, 32, 40, 255);
constexpr ImU32 kSoftInk = IM_COL32(82, 90, 104, 255);
constexpr ImU32 kPaper = IM_COL32(250, 251, 253, 225);
constexpr float kMargin_px = 18.0F;
constexpr int kBarWidth_px = 18;
constexpr float kBigText_px = 22.0F;
constexpr float kText_px = 15.0F;

ImU32 colour_of(Rgb c) {
    return IM_COL32(c.r, c.g, c.b, 255);
}

template <typename... Numbers>
std::string text_of(const char* format, Numbers... numbers) {
    std::array<char, 160> buffer{};
    std::snprintf(buffer.data(), buffer.size(), format, static_cast<double>(numbers)...);
    return buffer.data();
}

/// Writes at places in the picture; knows the fonts.
class Pen {
public:
    Pen(ImDrawList& list, const Fonts& fonts) : list_(list) {
        plain_ = fonts.plain != nullptr ? fonts.plain : ImGui::GetFont();
        bold_ = fonts.bold != nullptr ? fonts.bold : plain_;
    }
    enum class Anchor { left, right, centre };
    void write(float x, float y, const std::string& text, Anchor anchor = Anchor::left, ImU32 colour = kInk,
               float size_px = kText_px, bool is_bold = false) const {
        ImFont* font = is_bold ? bold_ : plain_;
        const float width = width_px(text, size_px, is_bold);
        const float left = anchor == Anchor::left    ? x
                           : anchor == Anchor::right ? x - width
                                                     : x - 0.5F * width;
        list_.AddText(font, size_px, {std::round(left), std::round(y)}, colour, text.c_str());
    }
    [[nodiscard]] float width_px(const std::string& text, float size_px, bool is_bold) const {
        const ImFont* font = is_bold ? bold_ : plain_;
        return font->CalcTextSizeA(size_px, 1.0e9F, 0.0F, text.c_str()).x;
    }
    void box(float x0, float y0, float x1, float y1) const {
        list_.AddRectFilled({x0, y0}, {x1, y1}, kPaper, 5.0F);
    }
    [[nodiscard]] ImDrawList& list() const { return list_; }

private:
    ImDrawList& list_;
    ImFont* plain_;
    ImFont* bold_;
};

/// 1, 2 or 5 times a power of ten, at most `wanted`.
float round_step(float wanted) {
    const float decade = std::pow(10.0F, std::floor(std::log10(wanted)));
    const float leading = wanted / decade;
    return decade * (leading >= 5.0F ? 5.0F : leading >= 2.0F ? 2.0F : 1.0F);
}

void draw_legend(const Pen& pen, const Legend& legend) {
    const PixelRect& bar = legend.bar;
    const auto x0 = static_cast<float>(bar.x0);
    const auto x1 = static_cast<float>(bar.x1);
    const auto y0 = static_cast<float>(bar.y0);
    const auto y1 = static_cast<float>(bar.y1);
    const bool is_one_value = !(legend.max > legend.min);
    const float foot = legend.has_unknown ? 58.0F : 26.0F;
    pen.box(x0 - 74.0F, y0 - 62.0F, x1 + 12.0F, y1 + foot);
    pen.write(x1, y0 - 54.0F, "stiffness", Pen::Anchor::right, kInk, kText_px, true);
    pen.write(x1, y0 - 35.0F, legend.unit, Pen::Anchor::right, kSoftInk);
    for (int y = bar.y0; y < bar.y1; ++y) {
        const float along = static_cast<float>(bar.y1 - 1 - y) / static_cast<float>(bar.y1 - bar.y0 - 1);
        const auto index = static_cast<std::size_t>(std::lround((is_one_value ? 0.5F : along) * 255.0F));
        pen.list().AddRectFilled({x0, static_cast<float>(y)}, {x1, static_cast<float>(y + 1)},
                                 colour_of(viridis()[index]));
    }
    const float text_x = x0 - 9.0F;
    const float half = 0.5F * kText_px;
    if (is_one_value) {
        pen.write(text_x, 0.5F * (y0 + y1) - half, text_of("%.4g", legend.max), Pen::Anchor::right);
    } else {
        pen.write(text_x, y0 - half, text_of("%.4g", legend.max), Pen::Anchor::right, kInk, kText_px, true);
        pen.write(text_x, y1 - half, text_of("%.4g", legend.min), Pen::Anchor::right, kInk, kText_px, true);
        const float span = legend.max - legend.min;
        const float step = round_step(span / 3.0F);
        for (float v = step * std::ceil(legend.min / step); v < legend.max; v += step) {
            const float y = y1 - (v - legend.min) / span * (y1 - y0);
            if (y - y0 < 16.0F || y1 - y < 16.0F) continue;
            pen.list().AddLine({x0 - 5.0F, y}, {x0, y}, kInk);
            pen.write(text_x, y - half, text_of("%.4g", v), Pen::Anchor::right, kSoftInk);
        }
    }
    if (legend.has_unknown) {
        pen.list().AddRectFilled({x0, y1 + 28.0F}, {x1, y1 + 46.0F}, colour_of(kUnknown));
        pen.write(text_x, y1 + 29.0F, "unknown", Pen::Anchor::right, kSoftInk);
    }
}

void draw_readout(const Pen& pen, const Frame& frame, const std::string& title) {
    const bool is_touching = frame.k_n_per_m > 0.0F;
    std::string line = text_of("t %.3f s", frame.t_s);
    line += text_of("     force %.2f N", frame.force_n.norm());
    line += is_touching ? text_of("     depth %.2f mm", 1.0e3F * frame.depth_m) : "     no contact";
    if (is_touching) line += text_of("     stiffness %.0f N/m", frame.k_n_per_m);
    const float width = std::max(pen.width_px(title, kBigText_px, true), pen.width_px(line, kText_px, false));
    pen.box(kMargin_px - 10.0F, kMargin_px - 8.0F, kMargin_px + width + 12.0F, kMargin_px + 52.0F);
    pen.write(kMargin_px, kMargin_px - 3.0F, title, Pen::Anchor::left, kInk, kBigText_px, true);
    pen.write(kMargin_px, kMargin_px + 28.0F, line);
}

/// What each mark in the picture means, top left under the readout.
void draw_key(const Pen& pen, const Frame& frame, const Caption& caption) {
    const float x = kMargin_px + 9.0F;
    float y = kMargin_px + 80.0F;
    const auto row = [&](const std::string& words) {
        pen.write(x + 22.0F, y - 8.5F, words, Pen::Anchor::left, kSoftInk, 14.0F);
        y += 22.0F;
    };
    ImDrawList& list = pen.list();
    if (frame.force_n.norm() > 0.0F) {
        list.AddLine({x - 9.0F, y}, {x + 4.0F, y}, colour_of(kForceColour), 4.0F);
        list.AddTriangleFilled({x + 10.0F, y}, {x + 2.0F, y - 6.0F}, {x + 2.0F, y + 6.0F},
                               colour_of(kForceColour));
        row(text_of("force on the hand, %.3g mm per N", 1.0e3F * caption.metres_per_newton));
    }
    list.AddCircleFilled({x, y}, 7.0F, IM_COL32(240, 243, 247, 255), 24);
    list.AddCircle({x, y}, 7.0F, kSoftInk, 24);
    row("tool");
    if (frame.proxy_m) {
        list.AddCircle({x, y}, 7.0F, IM_COL32(13, 26, 77, 220), 24, 2.0F);
        row("where it would rest on undeformed skin");
    }
    if (frame.normal) {
        list.AddLine({x, y - 8.0F}, {x, y + 8.0F}, kInk, 2.0F);
        row("contact normal");
    }
    if (!frame.dip.empty()) {
        list.AddRectFilled({x - 9.0F, y - 9.0F}, {x + 9.0F, y + 9.0F}, colour_of(viridis()[48]), 4.0F);
        for (const float dx : {-5.5F, 0.0F, 5.5F}) {
            list.AddCircleFilled({x + dx, y}, 2.0F, IM_COL32(255, 255, 255, 255), 12);
        }
        row("undeformed skin over the dip");
        list.AddRectFilled({x - 9.0F, y - 9.0F}, {x + 9.0F, y + 9.0F}, colour_of(viridis()[48]), 4.0F);
        list.AddCircle({x, y}, 6.5F, IM_COL32(255, 255, 255, 255), 24, 1.5F);
        list.AddCircle({x, y}, 3.0F, IM_COL32(255, 255, 255, 255), 24, 1.5F);
        row(text_of("lines of equal dip, every %.3g mm", 1.0e3F * contour_step_m(frame)));
    }
    if (std::abs(caption.dip_scale - 1.0F) > 1.0e-3F) {
        pen.write(x - 9.0F, y - 8.0F, text_of("dip drawn %.3g times as deep as it is", caption.dip_scale),
                  Pen::Anchor::left, colour_of(kForceColour), 14.0F, true);
    }
}

void draw_force_label(const Pen& pen, const Frame& frame, const Camera& camera, Size size,
                      float metres_per_newton) {
    const auto arrow = arrow_of(frame, metres_per_newton);
    if (!arrow) return;
    const auto tip = project(camera, size, arrow->tip_m);
    const auto tail = project(camera, size, arrow->tail_m);
    if (!tip || !tail) return;
    const std::string words = text_of("%.1f N", frame.force_n.norm());
    const float width = pen.width_px(words, kBigText_px, true);
    // Beside the tip, square to the arrow and rather above: neither arrow nor normal runs there.
    Eigen::Vector2f beside(tail->y - tip->y, tip->x - tail->x);
    beside = beside.norm() > 1.0F ? Eigen::Vector2f(beside.normalized()) : Eigen::Vector2f(1.0F, 0.0F);
    if (beside.y() > 0.2F) beside = -beside;
    const float away = 0.5F * (width * std::abs(beside.x()) + kBigText_px * std::abs(beside.y())) + 22.0F;
    const float x = tip->x + away * beside.x();
    const float y = tip->y + away * beside.y() - 0.5F * kBigText_px;
    pen.box(x - 0.5F * width - 6.0F, y - 1.0F, x + 0.5F * width + 6.0F, y + kBigText_px + 2.0F);
    pen.write(x, y, words, Pen::Anchor::centre, colour_of(kForceColour), kBigText_px, true);
}

void draw_axes(const Pen& pen, const Camera& camera, float x, float y) {
    constexpr float kLength_px = 34.0F;
    const Eigen::Matrix3f turn = camera.view().block<3, 3>(0, 0);
    struct Axis {
        const char* name;
        ImU32 colour;
    };
    constexpr std::array<Axis, 3> kAxes{{{"x", IM_COL32(196, 96, 64, 255)},
                                         {"y", IM_COL32(50, 140, 60, 255)},
                                         {"z", IM_COL32(50, 90, 190, 255)}}};
    std::array<int, 3> order{0, 1, 2};  // far ones first
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return turn(2, a) < turn(2, b); });
    for (const int i : order) {
        const Axis& axis = kAxes[static_cast<std::size_t>(i)];
        const ImVec2 end{x + kLength_px * turn(0, i), y - kLength_px * turn(1, i)};
        pen.list().AddLine({x, y}, end, axis.colour, 2.5F);
        pen.write(x + 1.32F * kLength_px * turn(0, i), y - 1.32F * kLength_px * turn(1, i) - 8.0F, axis.name,
                  Pen::Anchor::centre, axis.colour, kText_px, true);
    }
}

void draw_scale(const Pen& pen, const Camera& camera, Size size, float x, float y) {
    const float per_pixel_m = metres_per_pixel(camera, size);
    const float length_m = round_step(140.0F * per_pixel_m);
    const float length_px = length_m / per_pixel_m;
    ImDrawList& list = pen.list();
    pen.box(x - 12.0F, y - 26.0F, x + length_px + 12.0F, y + 12.0F);
    list.AddLine({x, y}, {x + length_px, y}, kInk, 2.0F);
    for (const float at : {x, x + length_px}) list.AddLine({at, y - 5.0F}, {at, y + 5.0F}, kInk, 2.0F);
    pen.write(x + 0.5F * length_px, y - 22.0F, text_of("%.3g mm", 1.0e3F * length_m), Pen::Anchor::centre);
}

}  // namespace

std::optional<Legend> legend_of(const Body& body, Size size) {
    const auto range = finite_range(body.stiffness_n_per_m);
    const int top = 92;
    const int bottom = std::min(size.height - 130, top + 340);
    const int right = size.width - 34;
    if (!range || bottom < top + 64 || right < 200) return std::nullopt;
    Legend legend;
    legend.min = range->min;
    legend.max = range->max;
    legend.bar = {right - kBarWidth_px, top, right, bottom};
    const bool is_one_value = !(range->max > range->min);
    legend.low = is_one_value ? viridis()[128] : viridis().front();
    legend.high = is_one_value ? viridis()[128] : viridis().back();
    legend.has_unknown = std::any_of(body.stiffness_n_per_m.begin(), body.stiffness_n_per_m.end(),
                                     [](float value) { return !std::isfinite(value); });
    return legend;
}

Fonts load_fonts() {
    const std::filesystem::path folder = "/usr/share/fonts/truetype/dejavu";
    const auto load = [&](const char* name) -> ImFont* {
        std::error_code ignored;
        if (!std::filesystem::exists(folder / name, ignored)) return nullptr;
        return ImGui::GetIO().Fonts->AddFontFromFileTTF((folder / name).c_str(), kBigText_px);
    };
    Fonts fonts{load("DejaVuSans.ttf"), load("DejaVuSans-Bold.ttf")};
    if (fonts.plain == nullptr) fonts.plain = ImGui::GetIO().Fonts->AddFontDefault();
    return fonts;
}

void draw_overlay(ImDrawList& list, const Fonts& fonts, const Frame& frame, const Camera& camera, Size size,
                  const Caption& caption) {
    if (size.empty()) return;
    const Pen pen(list, fonts);
    const float bottom = static_cast<float>(size.height - caption.bottom_px);
    const auto width = static_cast<float>(size.width);
    draw_force_label(pen, frame, camera, size, caption.metres_per_newton);
    if (caption.legend) draw_legend(pen, *caption.legend);
    draw_readout(pen, frame, caption.title);
    draw_key(pen, frame, caption);
    pen.box(kMargin_px - 10.0F, bottom - 132.0F, 122.0F, bottom - 24.0F);
    draw_axes(pen, camera, 65.0F, bottom - 78.0F);
    draw_scale(pen, camera, size, width - 190.0F, bottom - 50.0F);
    if (!frame.rate_line.empty()) {
        const float half = 0.5F * pen.width_px(frame.rate_line, kText_px, false);
        pen.box(0.5F * width - half - 10.0F, bottom - 30.0F, 0.5F * width + half + 10.0F, bottom - 6.0F);
        pen.write(0.5F * width, bottom - 26.0F, frame.rate_line, Pen::Anchor::centre);
    }
}

}  // namespace palpate::view
