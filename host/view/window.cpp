#include "host/view/window.hpp"

#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>
#include <imgui_impl_glfw.h>
#include <imgui_impl_opengl3.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <stdexcept>

#include "host/view/overlay.hpp"
#include "host/view/png.hpp"

namespace palpate::view {
namespace {

constexpr double kFrame_s = 1.0 / 60.0;
constexpr double kTick_s = 0.001;
constexpr double kDtMax_s = 0.1;  ///< a stalled window does not skip through the run
constexpr double kNotice_s = 4.0;
constexpr int kControls_px = 40;
constexpr float kControlsText = 0.7F;  ///< of the overlay's largest letters
struct HelpRow {
    const char* what;
    const char* does;
};
constexpr std::array<HelpRow, 11> kHelp{{{"left drag", "turn"},
                                         {"right or middle drag", "move"},
                                         {"wheel", "nearer, farther"},
                                         {"R", "first view"},
                                         {"F", "whole object"},
                                         {"Space", "play, pause"},
                                         {"Left, Right", "one frame (1/60 s); with Shift one tick (1 ms)"},
                                         {"[ ]", "half, double speed"},
                                         {"P", "picture to a file"},
                                         {"F1", "this help"},
                                         {"Q, Escape", "quit"}}};

std::string text_of(const char* format, double value) {
    std::array<char, 64> buffer{};
    std::snprintf(buffer.data(), buffer.size(), format, value);
    return buffer.data();
}

std::string last_glfw_error() {
    const char* words = nullptr;
    glfwGetError(&words);
    return words != nullptr ? words : "no reason given";
}

/// GLFW, a window and its context, current while it lives.
class Screen {
public:
    Screen(Size size, const std::string& title) {
        if (glfwInit() != GLFW_TRUE) {
            throw std::runtime_error("no display: set DISPLAY or use --screenshot FILE (" +
                                     last_glfw_error() + ")");
        }
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
        glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
        window_ = glfwCreateWindow(std::max(size.width, 1), std::max(size.height, 1), title.c_str(), nullptr,
                                   nullptr);
        if (window_ == nullptr) {
            const std::string why = last_glfw_error();
            glfwTerminate();
            throw std::runtime_error("cannot open a window with OpenGL 3.3: " + why +
                                     "; use --screenshot FILE");
        }
        glfwMakeContextCurrent(window_);
        glfwSwapInterval(1);
    }
    ~Screen() {
        glfwDestroyWindow(window_);
        glfwTerminate();
    }
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;
    [[nodiscard]] GLFWwindow* window() const { return window_; }
    [[nodiscard]] Size pixels() const {
        Size size;
        glfwGetFramebufferSize(window_, &size.width, &size.height);
        return size;
    }
    /// In the units of the mouse, which are not pixels on every screen.
    [[nodiscard]] Size extent() const {
        Size size;
        glfwGetWindowSize(window_, &size.width, &size.height);
        return size;
    }
    [[nodiscard]] bool is_minimised() const {
        return glfwGetWindowAttrib(window_, GLFW_ICONIFIED) == GLFW_TRUE;
    }

private:
    GLFWwindow* window_ = nullptr;
};

class Controls {
public:
    explicit Controls(GLFWwindow* window) {
        ImGui::CreateContext();
        ImGui::GetIO().IniFilename = nullptr;
        fonts_ = load_fonts();
        ImGui::StyleColorsLight();
        ImGui::GetIO().FontGlobalScale = kControlsText;
        ImGui_ImplGlfw_InitForOpenGL(window, true);
        ImGui_ImplOpenGL3_Init("#version 330 core");
    }
    ~Controls() {
        ImGui_ImplOpenGL3_Shutdown();
        ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
    }
    Controls(const Controls&) = delete;
    Controls& operator=(const Controls&) = delete;
    [[nodiscard]] const Fonts& fonts() const { return fonts_; }

private:
    Fonts fonts_;
};

/// Everything between an event and the next picture.
class Viewer {
public:
    Viewer(const Source& source, const WindowOptions& options)
        : source_(source), options_(options), screen_(options.size, "Palpate: " + source.title) {
        glfwSetWindowUserPointer(screen_.window(), this);
        // Before Dear ImGui's, which pass events on to these.
        glfwSetKeyCallback(screen_.window(), on_key);
        glfwSetCursorPosCallback(screen_.window(), on_cursor);
        glfwSetScrollCallback(screen_.window(), on_wheel);
        controls_ = std::make_unique<Controls>(screen_.window());
        renderer_ = std::make_unique<Renderer>(source.body);
        state_.camera = home_camera(source.body);
        state_.player.duration_s = source.duration_s;
        state_.player.seek(options.start_s);
        state_.player.is_playing = options.start_playing;
    }
    void run();

private:
    static Viewer& of(GLFWwindow* window) { return *static_cast<Viewer*>(glfwGetWindowUserPointer(window)); }
    static void on_key(GLFWwindow* window, int key, int code, int action, int mods);
    static void on_cursor(GLFWwindow* window, double x, double y);
    static void on_wheel(GLFWwindow* window, double dx, double dy);
    void press(int key, bool is_repeat, bool is_shift);
    void drag(float dx, float dy);
    void draw();
    void draw_controls(Size extent);
    void draw_help(Size extent) const;
    void save_picture(Size pixels);
    void count_picture();
    void notify(const std::string& words);

    const Source& source_;
    const WindowOptions& options_;
    Screen screen_;
    std::unique_ptr<Controls> controls_;
    std::unique_ptr<Renderer> renderer_;
    WindowState state_;
    double cursor_x_ = 0.0;
    double cursor_y_ = 0.0;
    bool wants_picture_ = false;
    std::string notice_;
    double notice_until_s_ = 0.0;
    double counted_since_s_ = 0.0;
    std::size_t counted_from_ = 0;
};

void Viewer::on_key(GLFWwindow* window, int key, int /*code*/, int action, int mods) {
    if (action == GLFW_RELEASE) return;
    of(window).press(key, action == GLFW_REPEAT, (mods & GLFW_MOD_SHIFT) != 0);
}

void Viewer::press(int key, bool is_repeat, bool is_shift) {
    const double step_s = is_shift ? kTick_s : kFrame_s;
    if (key == GLFW_KEY_LEFT) state_.player.step(-step_s);
    if (key == GLFW_KEY_RIGHT) state_.player.step(step_s);
    if (is_repeat) return;
    switch (key) {
        case GLFW_KEY_SPACE:
            state_.player.toggle();
            break;
        case GLFW_KEY_LEFT_BRACKET:
            state_.player.slower();
            break;
        case GLFW_KEY_RIGHT_BRACKET:
            state_.player.faster();
            break;
        case GLFW_KEY_R:
            state_.camera = home_camera(source_.body);
            break;
        case GLFW_KEY_F:
            state_.camera = framed(state_.camera, source_.body);
            break;
        case GLFW_KEY_P:
            wants_picture_ = true;
            break;
        case GLFW_KEY_F1:
            state_.has_help = !state_.has_help;
            break;
        case GLFW_KEY_Q:
        case GLFW_KEY_ESCAPE:
            glfwSetWindowShouldClose(screen_.window(), GLFW_TRUE);
            break;
        default:
            break;
    }
}

void Viewer::on_cursor(GLFWwindow* window, double x, double y) {
    Viewer& viewer = of(window);
    const auto dx = static_cast<float>(x - viewer.cursor_x_);
    const auto dy = static_cast<float>(y - viewer.cursor_y_);
    viewer.cursor_x_ = x;
    viewer.cursor_y_ = y;
    if (!ImGui::GetIO().WantCaptureMouse) viewer.drag(dx, dy);
}

void Viewer::drag(float dx, float dy) {
    const auto is_down = [this](int button) {
        return glfwGetMouseButton(screen_.window(), button) == GLFW_PRESS;
    };
    if (is_down(GLFW_MOUSE_BUTTON_LEFT)) {
        state_.camera = orbited(state_.camera, dx, dy);
    } else if (is_down(GLFW_MOUSE_BUTTON_RIGHT) || is_down(GLFW_MOUSE_BUTTON_MIDDLE)) {
        state_.camera = panned(state_.camera, dx, dy, screen_.extent());
    }
}

void Viewer::on_wheel(GLFWwindow* window, double /*dx*/, double dy) {
    if (ImGui::GetIO().WantCaptureMouse) return;
    of(window).state_.camera = zoomed(of(window).state_.camera, static_cast<float>(dy));
}

void Viewer::notify(const std::string& words) {
    notice_ = words;
    notice_until_s_ = glfwGetTime() + kNotice_s;
}

/// Never over an earlier picture: -2, -3, ... are appended. A failure is shown, not fatal.
void Viewer::save_picture(Size pixels) {
    wants_picture_ = false;
    const std::string stem = options_.picture_name + text_of("-%.3fs", state_.player.t_s);
    std::filesystem::path file = options_.picture_folder / (stem + ".png");
    for (int i = 2; std::filesystem::exists(file); ++i) {
        file = options_.picture_folder / (stem + "-" + std::to_string(i) + ".png");
    }
    try {
        write_png(read_framebuffer(pixels), file);
        state_.last_picture_file = file;
        notify("wrote " + file.string());
    } catch (const std::exception& error) {
        notify(error.what());
    }
}

void Viewer::count_picture() {
    ++state_.n_pictures;
    const double now_s = glfwGetTime();
    if (now_s - counted_since_s_ < 0.5) return;
    state_.graphics_hz = static_cast<double>(state_.n_pictures - counted_from_) / (now_s - counted_since_s_);
    counted_since_s_ = now_s;
    counted_from_ = state_.n_pictures;
}

void Viewer::draw_help(Size extent) const {
    ImGui::SetNextWindowPos(
        {0.5F * static_cast<float>(extent.width), 0.5F * static_cast<float>(extent.height)}, ImGuiCond_Always,
        {0.5F, 0.5F});
    ImGui::Begin("Keys and mouse", nullptr,
                 ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoMove);
    if (ImGui::BeginTable("keys", 2)) {
        for (const HelpRow& row : kHelp) {
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(row.what);
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(row.does);
        }
        ImGui::EndTable();
    }
    ImGui::End();
}

void Viewer::draw_controls(Size extent) {
    constexpr auto kFixed =
        ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings;
    ImGui::SetNextWindowPos({0.0F, static_cast<float>(extent.height - kControls_px)});
    ImGui::SetNextWindowSize({static_cast<float>(extent.width), static_cast<float>(kControls_px)});
    ImGui::Begin("controls", nullptr, kFixed);
    Player& player = state_.player;
    if (ImGui::Button(player.is_playing ? "pause" : "play", {80.0F, 0.0F})) player.toggle();
    ImGui::SameLine();
    constexpr float kWords_px = 330.0F;
    ImGui::SetNextItemWidth(std::max(static_cast<float>(extent.width) - kWords_px - 110.0F, 60.0F));
    const double first_s = 0.0;
    if (ImGui::SliderScalar("##time", ImGuiDataType_Double, &player.t_s, &first_s, &player.duration_s,
                            "%.3f s")) {
        player.seek(player.t_s);
    }
    ImGui::SameLine();
    const std::string words = "x " + text_of("%.3g", player.speed) + "   graphics " +
                              text_of("%.0f Hz", state_.graphics_hz) + "   F1 help";
    ImGui::TextUnformatted(words.c_str());
    ImGui::End();
    if (glfwGetTime() < notice_until_s_) {
        ImGui::SetNextWindowPos({0.5F * static_cast<float>(extent.width), 40.0F}, ImGuiCond_Always,
                                {0.5F, 0.0F});
        ImGui::Begin("notice", nullptr,
                     kFixed | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoInputs);
        ImGui::TextUnformatted(notice_.c_str());
        ImGui::End();
    }
    if (state_.has_help) draw_help(extent);
}

void Viewer::draw() {
    const Size pixels = screen_.pixels();
    const Size extent = screen_.extent();
    const Frame frame = source_.frame_at(state_.player.t_s);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    renderer_->draw(frame, state_.camera, pixels, options_.style);
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    const Style& style = options_.style;
    draw_overlay(*ImGui::GetBackgroundDrawList(), controls_->fonts(), frame, state_.camera, extent,
                 {.title = source_.title,
                  .legend = legend_of(source_.body, extent),
                  .section = section_of(source_.body, frame, state_.camera.right()),
                  .metres_per_newton =
                      style.metres_per_newton > 0.0F ? style.metres_per_newton : arrow_scale(source_.body),
                  .dip_scale = style.dip_scale,
                  .bottom_px = kControls_px});
    draw_controls(extent);
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    if (wants_picture_) save_picture(pixels);
    glfwSwapBuffers(screen_.window());
    count_picture();
}

void Viewer::run() {
    double before_s = glfwGetTime();
    while (glfwWindowShouldClose(screen_.window()) == GLFW_FALSE) {
        const bool is_hidden = screen_.is_minimised() || screen_.pixels().empty();
        if (is_hidden) {
            glfwWaitEventsTimeout(kDtMax_s);
        } else {
            glfwPollEvents();
        }
        const double now_s = glfwGetTime();
        state_.player.advance(std::min(now_s - before_s, kDtMax_s));
        before_s = now_s;
        state_.size = screen_.pixels();
        if (!is_hidden && !state_.size.empty()) draw();
        if (options_.on_frame) options_.on_frame(state_);
    }
}

}  // namespace

int show(const Source& source, const WindowOptions& options) {
    Viewer(source, options).run();
    return 0;
}

}  // namespace palpate::view
