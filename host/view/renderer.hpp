/// Draws a body and a frame into whatever framebuffer is current. Knows OpenGL 3.3 core, no window.
#pragma once
#include <memory>
#include <optional>

#include "host/view/camera.hpp"
#include "host/view/frame.hpp"
#include "host/view/palette.hpp"

namespace palpate::view {

/// How a picture is drawn.
struct Style {
    float dip_scale = 1.0F;          ///< dip as drawn over dip as it is; the picture says when it is not 1
    float metres_per_newton = 0.0F;  ///< length of the force arrow; 0: arrow_scale() of the body
    int supersample = 1;             ///< 2: edges are smoothed over 2 x 2 samples per pixel
};

constexpr Rgb kForceColour{214, 28, 48};

/// 1, 2 or 5 times a power of ten such that 5 N are about as long as the view's radius, m/N.
[[nodiscard]] float arrow_scale(const Body& body);

/// How far the skin's most pushed point is from its rest, m; 0 without a dip.
[[nodiscard]] float deepest_m(const Frame& frame);

/// Distance between the lines of equal dip for a frame: 1, 2 or 5 times a power of ten, about four lines, m;
/// 0 without a dip.
[[nodiscard]] float contour_step_m(const Frame& frame);

/// The force arrow in the workspace: it starts at the tool's centre.
struct Arrow {
    Eigen::Vector3f tail_m;
    Eigen::Vector3f tip_m;
};
/// nullopt below 0.01 N.
[[nodiscard]] std::optional<Arrow> arrow_of(const Frame& frame, float metres_per_newton);

/// Needs a current context of OpenGL 3.3 core or later, in every call, construction and end included.
class Renderer {
public:
    /// Throws std::invalid_argument on arrays of different length, std::runtime_error when OpenGL is not
    /// enough.
    explicit Renderer(const Body& body);
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    /// Fills the current framebuffer from (0, 0) to `size`. An empty size draws nothing. Text: overlay.hpp.
    void draw(const Frame& frame, const Camera& camera, Size size, const Style& style);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::view
