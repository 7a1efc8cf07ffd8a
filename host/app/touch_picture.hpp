/// touch.png: the moment of the largest force, drawn by the viewer's renderer.
#pragma once
#include <filesystem>
#include <string>

#include "host/app/run.hpp"

namespace palpate::app {

/// Words for a person when no picture could be made (built without the viewer, no EGL); empty when it was.
[[nodiscard]] std::string draw_touch(const std::filesystem::path& png, const Prepared& prepared,
                                     const RunResult& result);

}  // namespace palpate::app
