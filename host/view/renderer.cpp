#include "host/view/renderer.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "host/view/gl.hpp"
#include "host/view/shaders.hpp"
#include "host/view/solids.hpp"
#include "host/view/surfels.hpp"

namespace palpate::view {
namespace {

const Eigen::Vector3f kLight = Eigen::Vector3f(-0.55F, 0.62F, 0.56F).normalized();
const Eigen::Vector3f kFillLight = Eigen::Vector3f(0.75F, -0.1F, 0.65F).normalized();
const Eigen::Vector3f kTopColour{0.965F, 0.972F, 0.980F};
const Eigen::Vector3f kBottomColour{0.800F, 0.822F, 0.845F};
const Eigen::Vector4f kToolColour{0.93F, 0.95F, 0.97F, 1.0F};
const Eigen::Vector4f kProxyColour{0.05F, 0.10F, 0.30F, 0.75F};
const Eigen::Vector4f kNormalColour{0.10F, 0.11F, 0.14F, 1.0F};
const Eigen::Vector4f kDotColour{1.0F, 1.0F, 1.0F, 0.80F};
constexpr float kToolBody = 0.35F;  ///< opacity of the tool's middle over its rim's
constexpr float kProxyBody = 0.12F;
constexpr float kSeenThrough = 0.28F;  ///< opacity of the part of an arrow that is behind the skin
constexpr float kSolidRim =
    0.62F;  ///< of a disc hides what is behind; the rest only blends with its neighbours
// Widths over the camera's distance, so that they look alike at every zoom.
constexpr float kShaft = 0.0060F;
constexpr float kHead = 0.0150F;
constexpr float kHeadLength = 0.040F;
constexpr float kNormalLine = 0.0020F;
constexpr float kNormalLength = 0.160F;
constexpr float kNormalToolRadii = 6.0F;  ///< at most: from afar it would be longer than the object

Eigen::Vector4f colour_of(Rgb rgb) {
    return {static_cast<float>(rgb.r) / 255.0F, static_cast<float>(rgb.g) / 255.0F,
            static_cast<float>(rgb.b) / 255.0F, 1.0F};
}

/// The textures between cloud and picture, for one size.
struct Layers {
    explicit Layers(Size s)
        : size(s),
          colour_sums(s, GL_RGBA32F, GL_RGBA, GL_FLOAT, nullptr),
          normal_sums(s, GL_RGBA32F, GL_RGBA, GL_FLOAT, nullptr),
          depths(s, GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, nullptr),
          picture(s, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, nullptr),
          picture_depths(s, GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, nullptr),
          sums({&colour_sums, &normal_sums}, &depths),
          shown({&picture}, &picture_depths) {}
    Size size;
    gl::Texture colour_sums;
    gl::Texture normal_sums;
    gl::Texture depths;
    gl::Texture picture;
    gl::Texture picture_depths;
    gl::Target sums;
    gl::Target shown;
};

struct Rod {
    Solid solid;
    Eigen::Matrix4f model;
    Eigen::Vector4f colour;
};

std::vector<Rod> rods_of(const Frame& frame, const Camera& camera, float metres_per_newton) {
    std::vector<Rod> rods;
    const float d = camera.distance_m;
    if (frame.normal && frame.normal->norm() > 0.0F) {
        const Eigen::Vector3f from_m = frame.proxy_m.value_or(frame.tool_m);
        // Longer than the force arrow, which often lies along it.
        const float arrow_m = 1.25F * metres_per_newton * frame.force_n.norm();
        const float short_m = std::min(kNormalLength * d, kNormalToolRadii * frame.tool_radius_m);
        const float length_m = std::max(short_m, std::isfinite(arrow_m) ? arrow_m : 0.0F);
        const Eigen::Vector3f to_m = from_m + length_m * frame.normal->normalized();
        rods.push_back({Solid::cylinder, rod(from_m, to_m, kNormalLine * d), kNormalColour});
    }
    if (const auto arrow = arrow_of(frame, metres_per_newton)) {
        const Eigen::Vector3f along_m = arrow->tip_m - arrow->tail_m;
        const float head = std::min(0.5F, kHeadLength * d / along_m.norm());
        const Eigen::Vector3f neck_m = arrow->tip_m - head * along_m;
        rods.push_back({Solid::cylinder, rod(arrow->tail_m, neck_m, kShaft * d), colour_of(kForceColour)});
        rods.push_back({Solid::cone, rod(neck_m, arrow->tip_m, kHead * d), colour_of(kForceColour)});
    }
    return rods;
}

/// Discs as squares of two triangles. Four equal vertices and no instances: software renderers pay for each
/// instance.
class Squares {
public:
    Squares() {
        constexpr int kStride = sizeof(Surfel) / sizeof(float);
        vertices_.attribute(0, 3, kStride, 0);
        vertices_.attribute(1, 3, kStride, 3);
        vertices_.attribute(2, 1, kStride, 6);
        vertices_.attribute(3, 1, kStride, 7);
        vertices_.attribute(4, 1, kStride, 8);
    }
    /// Takes those discs that `to_clip` puts into the picture, or near its edge.
    void upload(std::span<const Surfel> discs, const Eigen::Matrix4f& to_clip) {
        corners_.clear();
        const float reach = to_clip.block<2, 3>(0, 0).rowwise().norm().maxCoeff();
        for (const Surfel& disc : discs) {
            const Eigen::Vector4f clip =
                to_clip * Eigen::Vector4f(disc.at_m[0], disc.at_m[1], disc.at_m[2], 1.0F);
            const float edge = clip.w() + 2.0F * (reach + 1.0F) * disc.radius_m;
            if (std::abs(clip.x()) < edge && std::abs(clip.y()) < edge)
                corners_.insert(corners_.end(), 4, disc);
        }
        vertices_.upload(corners_.data(), corners_.size() * sizeof(Surfel));
        for (auto i = static_cast<std::uint32_t>(indices_.size() / 6); 4 * i < corners_.size(); ++i) {
            for (const std::uint32_t corner : {0U, 1U, 2U, 2U, 1U, 3U}) indices_.push_back(4 * i + corner);
        }
        vertices_.upload_indices(indices_);
        n_ = corners_.size() / 4;
    }
    void draw() const {
        vertices_.bind();
        glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(6 * n_), GL_UNSIGNED_INT, nullptr);
    }

private:
    gl::Vertices vertices_;
    std::vector<Surfel> corners_;
    std::vector<std::uint32_t> indices_;
    std::size_t n_ = 0;
};

/// The nearest of 1, 2, 5 times a power of ten.
float rounded(float wanted) {
    const float decade = std::pow(10.0F, std::floor(std::log10(wanted)));
    const float leading = wanted / decade;
    return decade * (leading < 1.5F ? 1.0F : leading < 3.5F ? 2.0F : leading < 7.5F ? 5.0F : 10.0F);
}

}  // namespace

float arrow_scale(const Body& body) {
    const float wanted = std::max(body.view_radius_m, 1.0e-4F) / 5.0F;
    return rounded(wanted);
}

float deepest_m(const Frame& frame) {
    float deepest = 0.0F;
    for (const Moved& move : frame.dip) deepest = std::max(deepest, move.by_m.norm());
    return deepest;
}

float contour_step_m(const Frame& frame) {
    const float deepest = deepest_m(frame);
    return deepest > 1.0e-7F ? rounded(deepest / 4.0F) : 0.0F;
}

std::optional<Arrow> arrow_of(const Frame& frame, float metres_per_newton) {
    if (!(frame.force_n.norm() > 0.01F) || !frame.force_n.allFinite()) return std::nullopt;
    return Arrow{frame.tool_m, frame.tool_m + metres_per_newton * frame.force_n};
}

struct Renderer::Impl {
    explicit Impl(const Body& body)
        : surfels(body),
          bounds(bounds_of(body.points_m)),
          metres_per_newton(arrow_scale(body)),
          discs(shaders::kDiscVertex, shaders::kDiscFragment),
          dots(shaders::kDiscVertex, shaders::kDotFragment),
          resolve(shaders::kScreenVertex, shaders::kResolveFragment),
          mesh(shaders::kMeshVertex, shaders::kMeshFragment),
          palette({256, 1}, GL_RGB8, GL_RGB, GL_UNSIGNED_BYTE, viridis().data()) {}

    void sum_discs(float push_back_m);
    void light_discs(const Frame& frame, float push_back_m);
    void draw_solids(const Frame& frame, const Camera& camera, float arrow_m_per_n);
    void draw_dots(float lift_m);
    void draw_solid(const Rod& part) const;
    void set_view(const gl::Program& program) const;

    Surfels surfels;
    Bounds bounds;
    float metres_per_newton;
    gl::Program discs;
    gl::Program dots;
    gl::Program resolve;
    gl::Program mesh;
    gl::Texture palette;
    Squares disc_squares;
    Squares dot_squares;
    gl::Vertices no_vertices;
    Solids solids;
    std::optional<Layers> layers;
    Eigen::Matrix4f view;
    Eigen::Matrix4f projection;
};

void Renderer::Impl::set_view(const gl::Program& program) const {
    program.use();
    program.set("view", view);
    program.set("projection", projection);
}

/// First the nearest depth alone, pushed back by a little; then the sum of all discs in front of that.
void Renderer::Impl::sum_discs(float push_back_m) {
    glBindFramebuffer(GL_FRAMEBUFFER, layers->sums.id());
    glViewport(0, 0, layers->size.width, layers->size.height);
    glClearColor(0.0F, 0.0F, 0.0F, 0.0F);
    glDepthMask(GL_TRUE);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    disc_squares.upload(surfels.discs(), projection * view);
    set_view(discs);
    palette.bind(0);
    discs.set("palette", 0);
    discs.set("unknown_colour", Eigen::Vector3f(colour_of(kUnknown).head<3>()));
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glDisable(GL_BLEND);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    discs.set("push_back_m", push_back_m);
    discs.set("rim", kSolidRim);
    disc_squares.draw();
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_FALSE);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    discs.set("push_back_m", 0.0F);
    discs.set("rim", 1.0F);
    disc_squares.draw();
}

void Renderer::Impl::light_discs(const Frame& frame, float push_back_m) {
    glBindFramebuffer(GL_FRAMEBUFFER, layers->shown.id());
    glDisable(GL_BLEND);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_ALWAYS);
    resolve.use();
    layers->colour_sums.bind(0);
    layers->normal_sums.bind(1);
    layers->depths.bind(2);
    resolve.set("colour_sums", 0);
    resolve.set("normal_sums", 1);
    resolve.set("depths", 2);
    resolve.set("projection", projection);
    resolve.set("inverse_projection", Eigen::Matrix4f(projection.inverse()));
    resolve.set("light", kLight);
    resolve.set("fill_light", kFillLight);
    resolve.set("tool_eye_m", Eigen::Vector3f((view * frame.tool_m.homogeneous()).head<3>()));
    resolve.set("tool_radius_m", frame.tool_radius_m);
    resolve.set("push_back_m", push_back_m);
    const float step_m = contour_step_m(frame);
    resolve.set("contour_mm", step_m > 0.0F ? 1.0e3F * step_m : 1.0e9F);
    resolve.set("top_colour", kTopColour);
    resolve.set("bottom_colour", kBottomColour);
    no_vertices.bind();
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void Renderer::Impl::draw_solid(const Rod& part) const {
    mesh.set("model", part.model);
    mesh.set("colour", part.colour);
    solids.draw(part.solid);
}

void Renderer::Impl::draw_solids(const Frame& frame, const Camera& camera, float arrow_m_per_n) {
    set_view(mesh);
    mesh.set("light", kLight);
    mesh.set("fill_light", kFillLight);
    mesh.set("glass", 0.0F);
    mesh.set("flat_shade", 1.0F);
    glEnable(GL_CULL_FACE);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    // What the skin hides of an arrow shows through it.
    const std::vector<Rod> rods = rods_of(frame, camera, arrow_m_per_n);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_FALSE);
    for (Rod part : rods) {
        part.colour.w() = kSeenThrough;
        draw_solid(part);
    }
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    mesh.set("flat_shade", 0.0F);
    for (const Rod& part : rods) draw_solid(part);
    // Glass: the dip is under it.
    mesh.set("glass", 1.0F);
    mesh.set("body", kToolBody);
    draw_solid({Solid::sphere, ball(frame.tool_m, frame.tool_radius_m), kToolColour});
    if (frame.proxy_m) {
        mesh.set("body", kProxyBody);
        mesh.set("flat_shade", 1.0F);
        glDepthMask(GL_FALSE);
        draw_solid({Solid::sphere, ball(*frame.proxy_m, frame.tool_radius_m), kProxyColour});
        glDepthMask(GL_TRUE);
    }
    glDisable(GL_CULL_FACE);
}

void Renderer::Impl::draw_dots(float lift_m) {
    const auto left = surfels.left_behind();
    if (left.empty()) return;
    dot_squares.upload(left, projection * view);
    set_view(dots);
    palette.bind(0);
    dots.set("palette", 0);
    dots.set("unknown_colour", Eigen::Vector3f(0.0F, 0.0F, 0.0F));
    dots.set("push_back_m", -lift_m);
    dots.set("rim", 1.0F);
    dots.set("dot_colour", kDotColour);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_FALSE);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    dot_squares.draw();
    glDepthMask(GL_TRUE);
}

Renderer::Renderer(const Body& body) {
    if (epoxy_gl_version() < 33) {
        throw std::runtime_error("the viewer needs OpenGL 3.3, this machine offers " +
                                 std::to_string(epoxy_gl_version() / 10) + "." +
                                 std::to_string(epoxy_gl_version() % 10));
    }
    impl_ = std::make_unique<Impl>(body);
}

Renderer::~Renderer() = default;

void Renderer::draw(const Frame& frame, const Camera& camera, Size size, const Style& style) {
    if (size.empty()) return;
    GLint target = 0;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &target);
    const int n = std::clamp(style.supersample, 1, 2);  // the blit below averages 2 x 2, not more
    const Size inner{size.width * n, size.height * n};
    if (!impl_->layers || impl_->layers->size.width != inner.width ||
        impl_->layers->size.height != inner.height) {
        impl_->layers.reset();
        impl_->layers.emplace(inner);
    }
    impl_->view = camera.view();
    impl_->projection = camera.projection(size, impl_->bounds.centre_m, 1.2F * impl_->bounds.radius_m);
    impl_->surfels.bend(frame.dip, style.dip_scale);
    const float spacing_m = impl_->surfels.spacing_m();
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_CULL_FACE);
    impl_->sum_discs(0.9F * spacing_m);
    impl_->light_discs(frame, 0.9F * spacing_m);
    impl_->draw_dots(0.1F * spacing_m);
    const float scale = style.metres_per_newton > 0.0F ? style.metres_per_newton : impl_->metres_per_newton;
    impl_->draw_solids(frame, camera, scale);
    glDisable(GL_BLEND);
    glDisable(GL_DEPTH_TEST);
    glBindVertexArray(0);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, impl_->layers->shown.id());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(target));
    glBlitFramebuffer(0, 0, inner.width, inner.height, 0, 0, size.width, size.height, GL_COLOR_BUFFER_BIT,
                      n == 1 ? GL_NEAREST : GL_LINEAR);
    glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(target));
    glViewport(0, 0, size.width, size.height);
}

}  // namespace palpate::view
