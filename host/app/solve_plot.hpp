/// A deflection as a picture.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "host/scene/plate_file.hpp"

namespace palpate::app {

/// A map of `deflection_m` (even places, corner to corner) with contours, one at each mark of the colour bar,
/// and the load; drawn beside `png` and renamed. Words for a person when there is none and why; empty when it
/// was drawn.
[[nodiscard]] std::string draw_deflection(const std::filesystem::path& png, const scene::PlateFile& file,
                                          const Eigen::Ref<const Eigen::ArrayXXd>& deflection_m);

}  // namespace palpate::app
