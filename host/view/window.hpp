/// The viewer's window. Keys and mouse: kHelp in window.cpp, shown by F1.
#pragma once
#include <filesystem>
#include <functional>

#include "host/view/player.hpp"
#include "host/view/renderer.hpp"

namespace palpate::view {

/// What the window is doing, after each picture.
struct WindowState {
    Player player;
    Camera camera;
    Size size;
    bool has_help = false;
    std::size_t n_pictures = 0;               ///< drawn so far; stands still while nothing can be seen
    double graphics_hz = 0.0;                 ///< pictures per second over the last half second
    std::filesystem::path last_picture_file;  ///< what P wrote last
};

struct WindowOptions {
    Size size{1280, 720};
    double start_s = 0.0;
    bool start_playing = true;
    std::filesystem::path picture_folder = ".";  ///< where P writes, as NAME-T.TTTs.png
    std::string picture_name = "palpate";
    Style style;
    std::function<void(const WindowState&)> on_frame;  ///< called after each turn of the loop
};

/// Shows the run until Q, Escape or the window's close button; returns 0. Throws std::runtime_error without a
/// display, saying what to do instead, and where OpenGL 3.3 cannot be had.
int show(const Source& source, const WindowOptions& options);

}  // namespace palpate::view
