/// The cloud as little discs, at rest and pushed in.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/view/frame.hpp"
#include "host/view/palette.hpp"

namespace palpate::view {

/// One disc, as the shader reads it.
struct Surfel {
    std::array<float, 3> at_m;
    std::array<float, 3> normal;
    float radius_m;
    float shade;     ///< see view::shade()
    float dipped_m;  ///< how far it was pushed in, as it is, not as drawn
};
static_assert(sizeof(Surfel) == 9 * sizeof(float), "the vertex layout of renderer.cpp");

/// Keeps the discs of a body and bends them.
class Surfels {
public:
    /// Throws std::invalid_argument when the body's arrays differ in length. O(n log n).
    explicit Surfels(const Body& body);

    /// Moves the discs by `scale` times each dip vector and turns their normals with the slope of the dip.
    /// What was moved before goes back. Moves of points that do not exist are ignored. O(moved points).
    void bend(std::span<const Moved> dip, float scale);

    [[nodiscard]] std::span<const Surfel> discs() const { return discs_; }
    /// Dots at rest places of points that the last bend() moved, thinned to about `kDotsAcross` over the
    /// view; `shade` is how far the skin went, 1 for the farthest.
    [[nodiscard]] std::span<const Surfel> left_behind() const { return left_behind_; }
    /// Median over the points of the distance to the nearest neighbours that a disc must reach, m.
    [[nodiscard]] float spacing_m() const { return spacing_m_; }

private:
    static constexpr std::size_t kNeighbours = 8;
    static constexpr std::uint32_t kNone = 0xffffffffU;
    static constexpr float kDotsAcross = 40.0F;

    void find_neighbours(const Body& body);
    void thin_dots(const Body& body);
    void turn(std::uint32_t point, float scale);

    std::vector<Surfel> rest_;
    std::vector<Surfel> discs_;
    std::vector<Surfel> left_behind_;
    std::vector<std::array<std::uint32_t, kNeighbours>> neighbours_;
    std::vector<Eigen::Vector3f> moved_by_m_;  ///< per point, zero at rest
    std::vector<std::uint32_t> touched_;       ///< points whose disc differs from rest
    std::vector<bool> is_touched_;
    std::vector<bool> has_dot_;
    float dot_radius_m_ = 0.0F;
    float spacing_m_ = 0.0F;
};

}  // namespace palpate::view
