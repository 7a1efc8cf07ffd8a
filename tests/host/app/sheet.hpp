/// A soft sheet of 40 x 40 mm and a hand that presses and strokes it: the quickest scene that goes through
/// everything.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

namespace palpate::test {

/// ASCII PLY, points 1 mm apart in the plane z = 0, in metres.
std::string sheet_ply();

/// Presses from 0.5 s on, strokes 6 mm, leaves in the last half second; `hold_s` longer in between.
std::string sheet_toml(double hold_s = 0.0);

/// Both written into `folder`; the scene's path.
std::string write_sheet(const std::filesystem::path& folder, double hold_s = 0.0);

/// The 2 s scene as read from `folder`, with --set.
scene::Scene sheet_scene(const std::filesystem::path& folder, const std::vector<std::string>& set = {});

}  // namespace palpate::test
