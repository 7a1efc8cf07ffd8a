/// Many plates of one grid and different D at once, one in each SIMD lane: only the centre's compliance.
#pragma once
#include <Eigen/Core>
#include <memory>
#include <span>

#include "host/plate/problem.hpp"
#include "host/plate/solver.hpp"

namespace palpate::plate {

/// The constructor allocates, nothing else does. On 33 x 33 nodes a plate of four or more costs less than
/// half of what Plate takes from a new D to the centre's compliance.
class Batch {
public:
    /// All but D is the problem's: edges, grid lines, Poisson's ratio, foundation, mask. No jumps of D on
    /// grid lines. Node counts must be odd. Throws std::invalid_argument.
    explicit Batch(const Problem& problem, Kernel kernel = Kernel::best);
    ~Batch();
    Batch(Batch&&) noexcept;
    /// How many plates one call solves: 2, 4 or 8, with the kernel.
    [[nodiscard]] std::size_t lanes() const;
    /// D in N m of a plate, as Plate::set_rigidity. A D that is not positive and finite fails in that lane.
    void set_rigidity(std::size_t lane, const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m);
    /// Deflection in m at each plate's centre under 1 N there; NaN for one without a rigidity, or whose
    /// smallest pivot ratio is not above 1e-8 (MATH.md eq. 5). The same as Plate's up to rounding.
    void centre_compliances_m_per_n(std::span<double> by_lane);
    [[nodiscard]] const char* kernel() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::plate
