#include "host/view/overlay.hpp"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <vector>

namespace palpate::view {
namespace {

constexpr ImU32 kInk = IM_COL32(28, 32, 40, 255);
constexpr ImU32 kSoftInk = IM_COL32(82, 90, 104, 255);
constexpr ImU32 kPaper = IM_COL32(250, 251, 253, 225);
constexpr ImU32 kWhite = IM_COL32(255, 255, 255, 255);
constexpr float kMargin_px = 18.0F;
constexpr int kBarWidth_px = 18;
constexpr float kBigText_px = 22.0F;
constexpr float kText_px = 15.0F;
constexpr float kSmallText_px = 14.0F;
const ImVec2 kSection_px{300.0F, 204.0F};
const ImVec2 kSectionRoom_px{1200.0F, 560.0F};  ///< least size of a picture with a cut in it

ImU32 ink_of(Rgb c) {
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

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines(1);
    for (const char c : text) {
        if (c == '\n') {
            lines.emplace_back();
        } else {
            lines.back() += c;
        }
    }
    return lines;
}

void draw_legend(const Pen& pen, const Legend& legend) {
    const PixelRect& bar = legend.bar;
    const auto x0 = static_cast<float>(bar.x0);
    const auto x1 = static_cast<float>(bar.x1);
    const auto y0 = static_cast<float>(bar.y0);
    const auto y1 = static_cast<float>(bar.y1);
    const bool is_one_value = Range{legend.min, legend.max}.is_one_value();
    const float foot = legend.has_unknown ? 76.0F : 26.0F;
    pen.box(x0 - 110.0F, y0 - 62.0F, x1 + 12.0F, y1 + foot);
    pen.write(x1, y0 - 54.0F, "stiffness", Pen::Anchor::right, kInk, kText_px, true);
    pen.write(x1, y0 - 35.0F, legend.unit, Pen::Anchor::right, kSoftInk);
    for (int y = bar.y0; y < bar.y1; ++y) {
        const float along = static_cast<float>(bar.y1 - 1 - y) / static_cast<float>(bar.y1 - bar.y0 - 1);
        const auto index = static_cast<std::size_t>(std::lround((is_one_value ? 0.5F : along) * 255.0F));
        pen.list().AddRectFilled({x0, static_cast<float>(y)}, {x1, static_cast<float>(y + 1)},
                                 ink_of(viridis()[index]));
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
        const float first = std::ceil(legend.min / step);
        for (int i = 0; step * (first + static_cast<float>(i)) < legend.max; ++i) {
            const float v = step * (first + static_cast<float>(i));
            const float y = y1 - (v - legend.min) / span * (y1 - y0);
            if (y - y0 < 16.0F || y1 - y < 16.0F) continue;
            pen.list().AddLine({x0 - 5.0F, y}, {x0, y}, kInk);
            pen.write(text_x, y - half, text_of("%.4g", v), Pen::Anchor::right, kSoftInk);
        }
    }
    if (legend.has_unknown) {
        pen.list().AddRectFilled({x0, y1 + 28.0F}, {x1, y1 + 46.0F}, ink_of(kUnknown));
        float y = y1 + 23.0F;
        for (const std::string& line : lines_of(legend.unknown)) {
            pen.write(text_x, y, line, Pen::Anchor::right, kSoftInk, kSmallText_px);
            y += 1.2F * kSmallText_px;
        }
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

/// A mark in the picture and what it means.
struct KeyRow {
    std::string words;
    std::function<void(ImDrawList&, ImVec2 at)> mark;
};

void mark_skin(ImDrawList& list, ImVec2 at) {
    list.AddRectFilled({at.x - 9.0F, at.y - 9.0F}, {at.x + 9.0F, at.y + 9.0F}, ink_of(viridis()[48]), 4.0F);
}

void mark_force(ImDrawList& list, ImVec2 at) {
    list.AddLine({at.x - 9.0F, at.y}, {at.x + 4.0F, at.y}, ink_of(kForceColour), 4.0F);
    list.AddTriangleFilled({at.x + 10.0F, at.y}, {at.x + 2.0F, at.y - 6.0F}, {at.x + 2.0F, at.y + 6.0F},
                           ink_of(kForceColour));
}

void mark_tool(ImDrawList& list, ImVec2 at) {
    list.AddCircleFilled(at, 7.0F, IM_COL32(240, 243, 247, 255), 24);
    list.AddCircle(at, 7.0F, kSoftInk, 24);
}

void mark_proxy(ImDrawList& list, ImVec2 at) {
    list.AddCircle(at, 7.0F, IM_COL32(13, 26, 77, 220), 24, 2.0F);
}

void mark_normal(ImDrawList& list, ImVec2 at) {
    list.AddLine({at.x, at.y - 8.0F}, {at.x, at.y + 8.0F}, kInk, 2.0F);
}

void mark_dots(ImDrawList& list, ImVec2 at) {
    mark_skin(list, at);
    for (const float dx : {-5.5F, 0.0F, 5.5F}) list.AddCircleFilled({at.x + dx, at.y}, 2.0F, kWhite, 12);
}

void mark_lines(ImDrawList& list, ImVec2 at) {
    mark_skin(list, at);
    list.AddCircle(at, 6.5F, kWhite, 24, 1.5F);
    list.AddCircle(at, 3.0F, kWhite, 24, 1.5F);
}

std::vector<KeyRow> key_of(const Frame& frame, const Caption& caption) {
    std::vector<KeyRow> rows;
    if (frame.force_n.norm() > 0.0F) {
        rows.push_back(
            {text_of("force on the hand, %.3g mm per N", 1.0e3F * caption.metres_per_newton), mark_force});
    }
    rows.push_back({"tool", mark_tool});
    if (frame.proxy_m) rows.push_back({"where it would rest on undeformed skin", mark_proxy});
    if (frame.normal) rows.push_back({"contact normal", mark_normal});
    if (!frame.dip.empty()) {
        rows.push_back({"undeformed skin over the dip", mark_dots});
        rows.push_back(
            {text_of("lines of equal dip, every %.3g mm", 1.0e3F * contour_step_m(frame)), mark_lines});
    }
    return rows;
}

/// Top left under the readout.
void draw_key(const Pen& pen, const Frame& frame, const Caption& caption) {
    constexpr float kRow_px = 22.0F;
    const std::vector<KeyRow> rows = key_of(frame, caption);
    const bool is_exaggerated = std::abs(caption.dip_scale - 1.0F) > 1.0e-3F;
    const std::string warning =
        is_exaggerated ? text_of("dip drawn %.3g times as deep as it is", caption.dip_scale) : "";
    float width = pen.width_px(warning, kSmallText_px, true);
    for (const KeyRow& row : rows)
        width = std::max(width, 31.0F + pen.width_px(row.words, kSmallText_px, false));
    const float x = kMargin_px + 9.0F;
    float y = kMargin_px + 80.0F;
    const auto n_rows = static_cast<float>(rows.size() + (is_exaggerated ? 1 : 0));
    pen.box(kMargin_px - 10.0F, y - 17.0F, kMargin_px + width + 12.0F, y + kRow_px * n_rows - 5.0F);
    for (const KeyRow& row : rows) {
        row.mark(pen.list(), {x, y});
        pen.write(x + 22.0F, y - 8.5F, row.words, Pen::Anchor::left, kSoftInk, kSmallText_px);
        y += kRow_px;
    }
    pen.write(x - 9.0F, y - 8.0F, warning, Pen::Anchor::left, ink_of(kForceColour), kSmallText_px, true);
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
    pen.write(x, y, words, Pen::Anchor::centre, ink_of(kForceColour), kBigText_px, true);
}

/// The cut through the contact, to one scale in both directions.
void draw_section(const Pen& pen, const Section& section, const Frame& frame, float x0, float y1) {
    const float y0 = y1 - kSection_px.y, x1 = x0 + kSection_px.x;
    ImDrawList& list = pen.list();
    pen.box(x0, y0, x1, y1);
    pen.write(x0 + 10.0F, y0 + 6.0F, "cut through the contact", Pen::Anchor::left, kInk, kSmallText_px, true);
    const float px_per_m = 0.5F * (x1 - x0 - 16.0F) / section.half_width_m;
    const ImVec2 skin{0.5F * (x0 + x1), y0 + 0.61F * kSection_px.y};
    const auto at = [&](const Eigen::Vector2f& m) {
        return ImVec2{skin.x + px_per_m * m.x(), skin.y - px_per_m * m.y()};
    };
    list.PushClipRect({x0 + 4.0F, y0 + 24.0F}, {x1 - 4.0F, y1 - 4.0F}, true);
    const auto line = [&](const std::vector<Eigen::Vector2f>& points_m, ImU32 colour, float width_px,
                          bool dots) {
        for (std::size_t i = 1; i < points_m.size(); ++i) {
            const bool is_gap = points_m[i].x() - points_m[i - 1].x() > 0.1F * section.half_width_m;
            if (is_gap || (dots && i % 4 > 1)) continue;
            list.AddLine(at(points_m[i - 1]), at(points_m[i]), colour, width_px);
        }
    };
    const float radius_px = px_per_m * frame.tool_radius_m;
    list.AddCircleFilled(at(section.tool_m), radius_px, IM_COL32(205, 213, 224, 255), 48);
    list.AddCircle(at(section.tool_m), radius_px, kSoftInk, 48);
    line(section.rest_m, kSoftInk, 1.5F, true);
    line(section.dipped_m, ink_of(viridis()[48]), 3.0F, false);
    list.PopClipRect();
    const bool is_pressed = frame.depth_m > 0.0F && !frame.dip.empty();
    pen.write(x1 - 10.0F, y1 - 21.0F,
              is_pressed ? text_of("skin pushed in %.1f mm", 1.0e3F * deepest_m(frame)) : "skin at rest",
              Pen::Anchor::right, kSoftInk, kSmallText_px);
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
    const int bottom = std::min(size.height - 160, top + 340);
    const int right = size.width - 34;
    if (!range || bottom < top + 64 || right < 200) return std::nullopt;
    Legend legend;
    legend.min = range->min;
    legend.max = range->max;
    legend.unknown = body.unknown;
    legend.bar = {right - kBarWidth_px, top, right, bottom};
    legend.low = range->is_one_value() ? viridis()[128] : viridis().front();
    legend.high = range->is_one_value() ? viridis()[128] : viridis().back();
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
    if (caption.section && width >= kSectionRoom_px.x && bottom >= kSectionRoom_px.y) {
        draw_section(pen, *caption.section, frame, 132.0F, bottom - 24.0F);
    }
    draw_scale(pen, camera, size, width - 190.0F, bottom - 50.0F);
    if (!frame.rate_line.empty()) {
        const float half = 0.5F * pen.width_px(frame.rate_line, kText_px, false);
        pen.box(0.5F * width - half - 10.0F, bottom - 30.0F, 0.5F * width + half + 10.0F, bottom - 6.0F);
        pen.write(0.5F * width, bottom - 26.0F, frame.rate_line, Pen::Anchor::centre);
    }
}

}  // namespace palpate::view
