/// Pictures without a window or a display: OpenGL on a surfaceless EGL context (Mesa).
#pragma once
#include <filesystem>
#include <memory>

#include "host/view/png.hpp"
#include "host/view/renderer.hpp"

namespace palpate::view {

/// Draws pictures of one source. Its own context is current from construction to end: one at a time per
/// thread, and none while a window is open.
class Offscreen {
public:
    /// Throws std::runtime_error where no OpenGL 3.3 can be had, saying what would help. `source` must
    /// outlive it.
    explicit Offscreen(const Source& source);
    ~Offscreen();
    Offscreen(const Offscreen&) = delete;
    Offscreen& operator=(const Offscreen&) = delete;

    /// The picture with its words. An empty size gives an empty picture.
    [[nodiscard]] Image picture(const Frame& frame, const Camera& camera, Size size, const Style& style);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// One moment of `source` as a PNG file, edges smoothed. Throws std::runtime_error.
void screenshot(const Source& source, double at_s, const Camera& camera, int width, int height,
                const std::filesystem::path& png, Style style = {.supersample = 2});

}  // namespace palpate::view
