/// Pictures in memory and as PNG files.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/view/camera.hpp"
#include "host/view/palette.hpp"

namespace palpate::view {

/// Rows from the top, three bytes per pixel.
struct Image {
    Size size;
    std::vector<std::uint8_t> rgb;
    /// The pixel in column x, row y; both inside the picture.
    [[nodiscard]] Rgb at(int x, int y) const;
};

/// From the framebuffer that is bound for reading, its lower left `size`.
[[nodiscard]] Image read_framebuffer(Size size);

/// As a PNG file's bytes. Throws std::runtime_error for an empty picture.
[[nodiscard]] std::string png_bytes(const Image& image);

/// Written beside `png` and renamed when complete. Throws std::runtime_error naming the file.
void write_png(const Image& image, const std::filesystem::path& png);

}  // namespace palpate::view
