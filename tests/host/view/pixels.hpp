/// Finds things in pictures.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "host/view/png.hpp"

namespace palpate::view::testing {

/// A box of columns x0..x1 and rows y0..y1, far edges outside.
struct Box {
    int x0;
    int y0;
    int x1;
    int y1;
};

[[nodiscard]] inline bool is_force_red(Rgb c) {
    return c.r > 110 && c.g < 80 && c.b < 90 && c.r > 2 * c.g + 40;
}

/// Centres of the pixels in `box` for which `wanted` holds.
template <typename Wanted>
[[nodiscard]] std::vector<Eigen::Vector2f> find(const Image& image, Box box, Wanted wanted) {
    std::vector<Eigen::Vector2f> found;
    for (int y = std::max(box.y0, 0); y < std::min(box.y1, image.size.height); ++y) {
        for (int x = std::max(box.x0, 0); x < std::min(box.x1, image.size.width); ++x) {
            if (wanted(image.at(x, y)))
                found.emplace_back(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
        }
    }
    return found;
}

/// Pixels in `box` that differ by more than `threshold` in some channel.
[[nodiscard]] inline int n_different(const Image& a, const Image& b, Box box, int threshold) {
    int n = 0;
    for (int y = box.y0; y < box.y1; ++y) {
        for (int x = box.x0; x < box.x1; ++x) {
            const Rgb p = a.at(x, y);
            const Rgb q = b.at(x, y);
            const int worst = std::max({std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)});
            if (worst > threshold) ++n;
        }
    }
    return n;
}

}  // namespace palpate::view::testing
