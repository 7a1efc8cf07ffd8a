#include "host/plate/reference/depth_table.hpp"

#include <array>
#include <cstdio>

#include "host/plate/reference/cap.hpp"
#include "host/plate/reference/square.hpp"

namespace palpate::reference {
namespace {

constexpr double POISSON = 0.2;
constexpr double PATCH_RADII = 12.0;         ///< of a cap, in l: the rim is out of the load's reach
constexpr std::size_t SQUARE_ELEMENTS = 24;  ///< error 1e-4 at x = 5, 1e-5 at 1
/// In these units a depth is a number of thicknesses. F/(k d) has no units, so it does not matter which.
constexpr double THICKNESS = 1.0;

std::vector<double> cap_ratios(const std::vector<double>& x, double curvature, Edge edge) {
    const Cap cap{.radius_m = PATCH_RADII * shell_length_m(THICKNESS, curvature, POISSON),
                  .thickness_m = THICKNESS,
                  .poisson = POISSON,
                  .curvature_per_m = curvature,
                  .edge = edge};
    return press(cap, x).force_ratio;
}

std::vector<double> mean_of_rims(const std::vector<double>& x, double curvature) {
    std::vector<double> mean = cap_ratios(x, curvature, Edge::fixed);
    const std::vector<double> free = cap_ratios(x, curvature, Edge::free);
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = 0.5 * (mean[i] + free[i]);
    return mean;
}

}  // namespace

DepthTable depth_table(const std::vector<double>& x, std::size_t elements) {
    const Square square{.side_m = 1.0, .thickness_m = THICKNESS, .poisson = POISSON, .elements = elements};
    const double curvature = 1.0 / (30.0 * THICKNESS);  // a shallow shell's F/(k d) is the same for every one
    return {.x = x,
            .flat = press(square, x).force_ratio,
            .convex = mean_of_rims(x, curvature),
            .concave = mean_of_rims(x, -curvature)};
}

std::string depth_table_text() {
    const DepthTable table =
        depth_table({0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0},
                    SQUARE_ELEMENTS);
    std::string text =
        "// Written by `palpate-reference depth-law > host/plate/depth_law_table.inc`:\n"
        "// depth/thickness, then F/(k d) of a flat, a convex and a concave patch.\n";
    for (std::size_t i = 0; i < table.x.size(); ++i) {
        std::array<char, 128> line{};
        std::snprintf(line.data(), line.size(), "{%.2f, %.6f, %.6f, %.6f},\n", table.x[i], table.flat[i],
                      table.convex[i], table.concave[i]);
        text += line.data();
    }
    return text;
}

}  // namespace palpate::reference
