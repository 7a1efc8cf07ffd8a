/// Collects what a reader finds, checks it, and makes the cloud.
#pragma once
#include <array>
#include <vector>

#include "host/cloud/cloud.hpp"
#include "host/cloud/text.hpp"

namespace palpate::cloud {

class Builder {
public:
    void reserve_points(std::size_t n) { points_m_.reserve(n); }
    [[nodiscard]] std::size_t n_points() const { return points_m_.size(); }
    /// Fails at `place` when a coordinate is not finite or absurdly large.
    void add_point(const std::array<double, 3>& xyz, const Place& place);
    /// A fan of triangles. Corners count from 0; the caller has checked them. Fails when there are fewer
    /// than 3.
    void add_polygon(const std::vector<Index>& corners, const Place& place);
    /// Merges exact repeats of a point, drops triangles that thereby lost a corner. Fails at `place` when
    /// fewer than 3 points remain. Leaves the builder empty.
    [[nodiscard]] Cloud finish(const Place& place);

private:
    std::vector<Eigen::Vector3d> points_m_;
    std::vector<std::array<Index, 3>> triangles_;
};

}  // namespace palpate::cloud
