/// A real window under an X server, with real key and mouse events from xdotool. Pictures are the clock: each
/// step acts, then waits for its effect, for at most so many turns of the window's loop.
#include "host/view/window.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <stdexcept>

#include "tests/host/view/sheet.hpp"

using namespace palpate::view;
using namespace palpate::view::testing;

namespace {

constexpr int kPatience = 400;  ///< turns of the loop

struct Step {
    std::string name;
    std::string events;  ///< arguments of xdotool; empty: none
    std::function<bool(const WindowState& now, const WindowState& before)> has_worked;
};

void send(const std::string& events) {
    if (events.empty()) return;
    // The caller is a test that waits for its effect; xdotool returns when the X server has the events.
    if (std::system(("xdotool " + events).c_str()) != 0) throw std::runtime_error("xdotool " + events);
}

/// Goes through steps while the window runs; a step that has no effect is an error.
class Script {
public:
    explicit Script(std::vector<Step> steps) : steps_(std::move(steps)) {}
    void operator()(const WindowState& now) {
        if (now.n_pictures < 3 || next_ >= steps_.size()) return;
        if (!has_sent_) {
            before_ = now;
            send(steps_[next_].events);
            has_sent_ = true;
            waited_ = 0;
            return;
        }
        if (steps_[next_].has_worked(now, before_)) {
            ++next_;
            has_sent_ = false;
        } else if (++waited_ > kPatience) {
            throw std::runtime_error("no effect of step: " + steps_[next_].name);
        }
    }
    [[nodiscard]] std::size_t n_done() const { return next_; }

private:
    std::vector<Step> steps_;
    std::size_t next_ = 0;
    bool has_sent_ = false;
    int waited_ = 0;
    WindowState before_;
};

/// Small: a software renderer on a busy machine.
WindowOptions small_window() {
    WindowOptions options;
    options.size = {480, 320};
    options.start_playing = false;
    options.picture_folder = std::filesystem::temp_directory_path() / "palpate-window-test";
    std::filesystem::remove_all(options.picture_folder);
    std::filesystem::create_directories(options.picture_folder);
    return options;
}

Source small_source() {
    Source source = stroke();
    source.body = domed_sheet(60);
    source.duration_s = 1000.0;
    source.frame_at = [body = source.body](double t_s) {
        Frame frame = pressed(body, 0, 0, 0.002F);
        frame.t_s = t_s;
        return frame;
    };
    return source;
}

bool has_turned(const Camera& a, const Camera& b) {
    return a.yaw_rad != b.yaw_rad || a.pitch_rad != b.pitch_rad;
}

}  // namespace

TEST_CASE("keys play, pause, step, change speed, help, and q quits") {
    WindowOptions options = small_window();
    const auto shifted = [](double by_s) {
        return [by_s](const WindowState& now, const WindowState& before) {
            return !now.player.is_playing && std::abs(now.player.t_s - before.player.t_s - by_s) < 1e-9;
        };
    };
    Script script({
        {"pointer over the window", "mousemove 240 100",
         [](auto& now, auto& before) { return now.n_pictures > before.n_pictures; }},
        {"space plays", "key space",
         [](auto& now, auto& before) { return now.player.is_playing && now.player.t_s > before.player.t_s; }},
        {"space pauses", "key space", [](auto& now, auto&) { return !now.player.is_playing; }},
        {"paused stays", "",
         [](auto& now, auto& before) {
             return now.n_pictures > before.n_pictures + 5 && now.player.t_s == before.player.t_s;
         }},
        {"right steps a frame", "key Right", shifted(1.0 / 60.0)},
        {"shift right steps a tick", "key shift+Right", shifted(0.001)},
        {"left steps back", "key Left", shifted(-1.0 / 60.0)},
        {"] doubles", "key bracketright",
         [](auto& now, auto& before) { return now.player.speed == 2.0 * before.player.speed; }},
        {"[ halves", "key bracketleft",
         [](auto& now, auto& before) { return now.player.speed == 0.5 * before.player.speed; }},
        {"F1 helps", "key F1", [](auto& now, auto&) { return now.has_help; }},
        {"F1 again", "key F1", [](auto& now, auto&) { return !now.has_help; }},
        {"q quits", "key q", [](auto&, auto&) { return false; }},
    });
    options.on_frame = [&](const WindowState& now) { script(now); };
    CHECK(show(small_source(), options) == 0);
    CHECK(script.n_done() == 11);
}

TEST_CASE("drags turn and move, the wheel zooms, R and F set the view, Escape quits") {
    WindowOptions options = small_window();
    Camera home;
    Script script({
        {"pointer over the window", "mousemove 240 130",
         [&](auto& now, auto& before) {
             home = now.camera;
             return now.n_pictures > before.n_pictures;
         }},
        {"left drag turns", "mousedown 1 mousemove 300 150 mouseup 1",
         [](auto& now, auto& before) { return has_turned(now.camera, before.camera); }},
        {"moving without a button does nothing", "mousemove 240 130",
         [](auto& now, auto& before) {
             return now.n_pictures > before.n_pictures + 5 && !has_turned(now.camera, before.camera);
         }},
        {"right drag moves", "mousedown 3 mousemove 280 130 mouseup 3",
         [](auto& now, auto& before) {
             return (now.camera.target_m - before.camera.target_m).norm() > 1e-4F &&
                    !has_turned(now.camera, before.camera);
         }},
        {"wheel zooms in", "click 4",
         [](auto& now, auto& before) { return now.camera.distance_m < before.camera.distance_m; }},
        {"F frames the object", "key f",
         [](auto& now, auto& before) { return now.camera.distance_m > 1.5F * before.camera.distance_m; }},
        {"R goes back", "key r",
         [&](auto& now, auto&) {
             return now.camera.target_m == home.target_m && !has_turned(now.camera, home);
         }},
        {"Escape quits", "key Escape", [](auto&, auto&) { return false; }},
    });
    options.on_frame = [&](const WindowState& now) { script(now); };
    CHECK(show(small_source(), options) == 0);
    CHECK(script.n_done() == 7);
}

TEST_CASE("dragging the slider scrubs, turns nothing, and ends with the button") {
    WindowOptions options = small_window();
    options.size = {800, 320};  // the slider: from 96 to 456 px, of a run of 1000 s
    Camera home;
    const auto is_at = [&home](double share) {
        return [share, &home](const WindowState& now, const WindowState&) {
            // The handle is 12 px wide, and its middle goes where the pointer is: 2 % of the track at its
            // ends.
            return std::abs(now.player.t_s - 1000.0 * share) < 25.0 && !has_turned(now.camera, home) &&
                   now.camera.target_m == home.target_m;
        };
    };
    Script script({
        {"pointer over the slider", "mousemove 186 298",
         [&](auto& now, auto& before) {
             home = now.camera;
             return now.n_pictures > before.n_pictures + 1;
         }},
        {"a press goes there", "mousedown 1", is_at(0.25)},
        {"a drag goes along", "mousemove 366 298", is_at(0.75)},
        {"off the slider too", "mousemove 276 120", is_at(0.5)},
        {"released", "mouseup 1",
         [](auto& now, auto& before) { return now.n_pictures > before.n_pictures + 2; }},
        {"moving on changes nothing", "mousemove 186 298",
         [&](auto& now, auto& before) {
             return now.n_pictures > before.n_pictures + 5 && is_at(0.5)(now, before);
         }},
        {"q", "key q", [](auto&, auto&) { return false; }},
    });
    options.on_frame = [&](const WindowState& now) { script(now); };
    CHECK(show(small_source(), options) == 0);
    CHECK(script.n_done() == 6);
}

TEST_CASE("P writes a picture and never over an earlier one") {
    WindowOptions options = small_window();
    options.start_s = 1.25;
    options.picture_name = "run";
    Script script({
        {"pointer over the window", "mousemove 240 130",
         [](auto& now, auto& before) { return now.n_pictures > before.n_pictures; }},
        {"P", "key p", [](auto& now, auto&) { return now.last_picture_file.filename() == "run-1.250s.png"; }},
        {"P again", "key p",
         [](auto& now, auto&) { return now.last_picture_file.filename() == "run-1.250s-2.png"; }},
        {"q", "key q", [](auto&, auto&) { return false; }},
    });
    options.on_frame = [&](const WindowState& now) { script(now); };
    show(small_source(), options);
    CHECK(script.n_done() == 3);
    CHECK(std::filesystem::file_size(options.picture_folder / "run-1.250s.png") > 1000);
    CHECK(std::filesystem::file_size(options.picture_folder / "run-1.250s-2.png") > 1000);
    std::filesystem::remove_all(options.picture_folder);
}

TEST_CASE("a window made tiny, hidden, and shown again goes on") {
    WindowOptions options = small_window();
    const std::string find_it = "search --name Palpate ";
    Script script({
        {"tiny", find_it + "windowsize 1 1", [](auto& now, auto&) { return now.size.width <= 2; }},
        {"draws tiny", "", [](auto& now, auto& before) { return now.n_pictures > before.n_pictures + 2; }},
        {"back", find_it + "windowsize 480 320", [](auto& now, auto&) { return now.size.width == 480; }},
        {"hidden", find_it + "windowunmap", [](auto&, auto&) { return true; }},
        {"shown", "search --onlyvisible --name Palpate windowmap || xdotool search --name Palpate windowmap",
         [](auto& now, auto& before) { return now.n_pictures > before.n_pictures; }},
        {"pointer over the window", "mousemove 240 130",
         [](auto& now, auto& before) { return now.n_pictures > before.n_pictures; }},
        {"q", "key q", [](auto&, auto&) { return false; }},
    });
    options.on_frame = [&](const WindowState& now) { script(now); };
    CHECK(show(small_source(), options) == 0);
    CHECK(script.n_done() == 6);
}

TEST_CASE("without a display the error says what to do") {
    const char* display = std::getenv("DISPLAY");
    const std::string kept = display != nullptr ? display : "";
    unsetenv("DISPLAY");
    CHECK_THROWS_WITH(show(small_source(), small_window()),
                      Catch::StartsWith("no display: set DISPLAY or use --screenshot FILE"));
    if (!kept.empty()) setenv("DISPLAY", kept.c_str(), 1);
}
