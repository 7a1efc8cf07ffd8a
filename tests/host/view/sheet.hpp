/// A made-up body: a domed sheet with one stiff spot, and ways to press it.
#pragma once
#include "host/view/frame.hpp"

namespace palpate::view::testing {

constexpr float kSoft_n_per_m = 450.0F;
constexpr float kStiff_n_per_m = 1000.0F;

/// n x n points over 80 mm x 80 mm, y up, the top of the dome at the origin; the spot lies 9 mm to its right.
Body domed_sheet(int n = 200);

/// The tool `depth_m` deep in the sheet at (x, z), the force k * depth along the normal, a dip of 7 mm width.
/// Depth 0: the tool rests on the sheet, no force and no dip.
Frame pressed(const Body& body, float x_m, float z_m, float depth_m);

/// Two seconds in which the tool slides over the spot at 4 mm depth.
Source stroke();

}  // namespace palpate::view::testing
