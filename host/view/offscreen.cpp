#include "host/view/offscreen.hpp"

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <imgui.h>
#include <imgui_impl_opengl3.h>

#include <array>
#include <stdexcept>

#include "host/view/gl.hpp"
#include "host/view/overlay.hpp"

namespace palpate::view {
namespace {

[[noreturn]] void refuse(const char* what) {
    throw std::runtime_error(std::string("no OpenGL 3.3 without a window (") + what +
                             "): install libgl1-mesa-dri and libegl1, which draw on any CPU");
}

/// A context without any surface, current while it lives.
class Context {
public:
    Context() {
        display_ = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
        if (display_ == EGL_NO_DISPLAY || eglInitialize(display_, nullptr, nullptr) == EGL_FALSE) {
            refuse("EGL has no surfaceless display");
        }
        constexpr std::array<EGLint, 5> kAnyGl{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                               EGL_OPENGL_BIT, EGL_NONE};
        EGLConfig config = nullptr;
        EGLint n_configs = 0;
        if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE ||
            eglChooseConfig(display_, kAnyGl.data(), &config, 1, &n_configs) == EGL_FALSE || n_configs < 1) {
            refuse("EGL has no desktop OpenGL");
        }
        constexpr std::array<EGLint, 7> kCore33{EGL_CONTEXT_MAJOR_VERSION,
                                                3,
                                                EGL_CONTEXT_MINOR_VERSION,
                                                3,
                                                EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                                EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                                EGL_NONE};
        context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, kCore33.data());
        if (context_ == EGL_NO_CONTEXT) refuse("EGL gives no core context");
        if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) {
            eglDestroyContext(display_, context_);
            refuse("EGL cannot draw without a surface");
        }
    }
    ~Context() {
        eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        eglDestroyContext(display_, context_);
        eglTerminate(display_);
    }
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

private:
    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
};

/// Dear ImGui without a window, for the words.
class Words {
public:
    Words() {
        ImGui::CreateContext();
        ImGui::GetIO().IniFilename = nullptr;
        fonts_ = load_fonts();
        ImGui_ImplOpenGL3_Init("#version 330 core");
    }
    ~Words() {
        ImGui_ImplOpenGL3_Shutdown();
        ImGui::DestroyContext();
    }
    Words(const Words&) = delete;
    Words& operator=(const Words&) = delete;

    void draw(const Frame& frame, const Camera& camera, Size size, const Caption& caption) const {
        ImGui::GetIO().DisplaySize = {static_cast<float>(size.width), static_cast<float>(size.height)};
        ImGui_ImplOpenGL3_NewFrame();
        ImGui::NewFrame();
        draw_overlay(*ImGui::GetBackgroundDrawList(), fonts_, frame, camera, size, caption);
        ImGui::Render();
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    }

private:
    Fonts fonts_;
};

}  // namespace

struct Offscreen::Impl {
    explicit Impl(const Source& s) : source(s), renderer(s.body) {}
    const Source& source;
    Context context;  // first made, last unmade
    Words words;
    Renderer renderer;
};

Offscreen::Offscreen(const Source& source) : impl_(std::make_unique<Impl>(source)) {}
Offscreen::~Offscreen() = default;

Image Offscreen::picture(const Frame& frame, const Camera& camera, Size size, const Style& style) {
    if (size.empty()) return {};
    const gl::Texture colours(size, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
    const gl::Target target({&colours}, nullptr);
    impl_->renderer.draw(frame, camera, size, style);
    const Source& source = impl_->source;
    const float scale = style.metres_per_newton > 0.0F ? style.metres_per_newton : arrow_scale(source.body);
    impl_->words.draw(frame, camera, size,
                      {.title = source.title,
                       .legend = legend_of(source.body, size),
                       .section = section_of(source.body, frame, camera.right()),
                       .metres_per_newton = scale,
                       .dip_scale = style.dip_scale});
    return read_framebuffer(size);
}

void screenshot(const Source& source, double at_s, const Camera& camera, int width, int height,
                const std::filesystem::path& png, Style style) {
    Offscreen offscreen(source);
    write_png(offscreen.picture(source.frame_at(at_s), camera, {width, height}, style), png);
}

}  // namespace palpate::view
