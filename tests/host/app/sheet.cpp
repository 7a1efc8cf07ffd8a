#include "tests/host/app/sheet.hpp"

#include <array>
#include <cstdio>
#include <fstream>

namespace palpate::test {
namespace {

constexpr int N_SIDE = 41;
constexpr double SPACING_M = 1e-3;

const char* const HEAD = R"(scene = 1
title = "A soft sheet"
[object]
points = "sheet.ply"
length_unit = "m"
[skin]
model = "plate"
young_pa = 0.4e6
thickness_m = 0.0015
foundation_n_per_m3 = 2.0e7
[touch]
ramp_s = 0.1
[hand]
grip = "firm"
path = [
)";

std::string point(double t_s, double x_m, double depth_m) {
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), "  { t_s = %.3f, at_m = [%.4f, 0.0, 0.0], depth_m = %.4f },\n",
                  t_s, x_m, depth_m);
    return text.data();
}

}  // namespace

std::string sheet_ply() {
    std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(N_SIDE * N_SIDE) +
                       "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    for (int j = 0; j < N_SIDE; ++j) {
        for (int i = 0; i < N_SIDE; ++i) {
            std::array<char, 64> line{};
            std::snprintf(line.data(), line.size(), "%.4f %.4f 0\n", (i - N_SIDE / 2) * SPACING_M,
                          (j - N_SIDE / 2) * SPACING_M);
            text += line.data();
        }
    }
    return text;
}

std::string sheet_toml(double hold_s) {
    return HEAD + point(0.0, -0.003, -0.004) + point(0.5, -0.003, 0.004) + point(1.5 + hold_s, 0.003, 0.004) +
           point(2.0 + hold_s, 0.003, -0.004) + "]\n";
}

std::string write_sheet(const std::filesystem::path& folder, double hold_s) {
    const std::string scene = (folder / "sheet.toml").string();
    std::ofstream(folder / "sheet.ply") << sheet_ply();
    std::ofstream(scene) << sheet_toml(hold_s);
    return scene;
}

scene::Scene sheet_scene(const std::filesystem::path& folder, const std::vector<std::string>& set) {
    return scene::load(write_sheet(folder), set);
}

}  // namespace palpate::test
