#include "host/view/png.hpp"

#include <epoxy/gl.h>
#include <png.h>

#include <cassert>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace palpate::view {

Rgb Image::at(int x, int y) const {
    assert(x >= 0 && y >= 0 && x < size.width && y < size.height);
    const std::size_t i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) +
                               static_cast<std::size_t>(x));
    return {rgb[i], rgb[i + 1], rgb[i + 2]};
}

Image read_framebuffer(Size size) {
    Image image{size, {}};
    if (size.empty()) return image;
    const std::size_t row = 3 * static_cast<std::size_t>(size.width);
    const auto n_rows = static_cast<std::size_t>(size.height);
    std::vector<std::uint8_t> from_below(row * n_rows);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, size.width, size.height, GL_RGB, GL_UNSIGNED_BYTE, from_below.data());
    image.rgb.resize(row * n_rows);
    for (std::size_t y = 0; y < n_rows; ++y) {
        std::memcpy(&image.rgb[y * row], &from_below[(n_rows - 1 - y) * row], row);
    }
    return image;
}

std::string png_bytes(const Image& image) {
    if (image.size.empty()) throw std::runtime_error("a picture needs at least one pixel");
    png_image header{};
    header.version = PNG_IMAGE_VERSION;
    header.width = static_cast<png_uint_32>(image.size.width);
    header.height = static_cast<png_uint_32>(image.size.height);
    header.format = PNG_FORMAT_RGB;
    png_alloc_size_t n_bytes = PNG_IMAGE_PNG_SIZE_MAX(header);
    std::string bytes(n_bytes, '\0');
    if (png_image_write_to_memory(&header, bytes.data(), &n_bytes, 0, image.rgb.data(), 0, nullptr) == 0) {
        throw std::runtime_error(std::string("cannot make the picture: ") + header.message);
    }
    bytes.resize(n_bytes);
    return bytes;
}

void write_png(const Image& image, const std::filesystem::path& png) {
    const std::string bytes = png_bytes(image);
    std::filesystem::path aside = png;
    aside += ".part";
    const auto fail = [&](const std::string& why) {
        std::error_code ignored;
        std::filesystem::remove(aside, ignored);
        throw std::runtime_error(png.string() + ": cannot write the picture (" + why + ")");
    };
    std::ofstream out(aside, std::ios::binary);
    if (!out) fail(std::generic_category().message(errno));
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) fail(std::generic_category().message(errno));
    std::error_code error;
    std::filesystem::rename(aside, png, error);
    if (error) fail(error.message());
}

}  // namespace palpate::view
