/// A cut through the skin at the contact: what a dip looks like from its side.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "host/view/frame.hpp"

namespace palpate::view {

/// In the plane of the contact normal and a tangent, metres: x along the tangent, y along the normal, the
/// place on the undeformed skin below the tool at (0, 0).
struct Section {
    std::vector<Eigen::Vector2f> rest_m;    ///< undeformed skin, from left to right; empty where none is near
    std::vector<Eigen::Vector2f> dipped_m;  ///< the same places, pushed in
    Eigen::Vector2f tool_m{0, 0};
    float half_width_m = 0.0F;  ///< the cut reaches from minus this to this
};

/// nullopt without a contact normal. `right`: where the cut's x shall point, as far as the skin lets it.
/// Between the scan's points the skin is a quadratic fitted to the points of its wall (weights of one
/// spacing); it ends where there is none. O(points).
[[nodiscard]] std::optional<Section> section_of(const Body& body, const Frame& frame,
                                                const Eigen::Vector3f& right);

}  // namespace palpate::view
