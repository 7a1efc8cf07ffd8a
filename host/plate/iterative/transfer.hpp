/// Between a grid and the one made of its every second node.
#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "host/plate/problem.hpp"
#include "host/plate/stencil.hpp"

namespace palpate::plate {

/// Node counts of the coarser grid: (n + 1)/2.
[[nodiscard]] constexpr Eigen::Index coarser(Eigen::Index n) {
    return (n + 1) / 2;
}
/// Both counts odd, and at least 5 nodes left.
[[nodiscard]] bool can_coarsen(Eigen::Index nx, Eigen::Index nz);

/// Full weighting, (1 2 1)/4 along each axis, (1 1)/2 at the ends: positive stays positive. Does not
/// allocate; `room` has the fine grid's size.
void weigh_fully(const Eigen::Ref<const Eigen::ArrayXXd>& fine, Eigen::Ref<Eigen::ArrayXXd> coarse,
                 Eigen::Ref<Eigen::ArrayXXd> room);

/// Cubic interpolation P and its transpose (MATH.md eq. 47). Beyond an edge the deflection is mirrored:
/// even at a clamped edge, odd at a supported one; at a free one the cubic goes on. Vectors in the layouts,
/// 0 where nothing moves. Not for two threads at once: it has memory of its own.
class Transfer {
public:
    Transfer(const Layout& fine, const Layout& coarse, const std::array<Edge, 4>& edges);
    /// fine += P coarse.
    void prolong(const double* coarse, double* fine);
    /// coarse = scale P' fine, 0 where nothing moves.
    void restrict_from(const double* fine, double scale, double* coarse);

private:
    /// What a fine row takes from four coarse ones.
    struct Taps {
        Eigen::Index first;
        std::array<double, 4> weight;
    };
    [[nodiscard]] Taps taps(Eigen::Index fine_row) const;

    Layout fine_, coarse_;
    Moving moving_;  ///< on the coarse grid
    std::array<Edge, 4> edges_;
    std::vector<Taps> taps_;
    std::vector<double> row_;
};

}  // namespace palpate::plate
