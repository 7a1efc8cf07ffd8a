/// Thin plates and shallow shells of varying rigidity: how far a point gives way under a load. Needs Eigen
/// only.
#pragma once
#include <Eigen/Core>
#include <memory>
#include <span>

#include "host/plate/problem.hpp"
#include "host/plate/solver.hpp"

namespace palpate::plate {

/// Plate, energy form K = B'CB (13-point pattern, symmetric positive definite for every D > 0;
/// MATH.md eq. 2-4), multifrontal Cholesky. One factor, many questions. The sparsity analysis is kept between
/// plates of one grid size. With portable kernels the same bits from every compiler and level. Const calls
/// may run in parallel. Where a call says that it does not allocate, it does when two threads ask at the same
/// time.
class Plate {
public:
    /// Throws std::invalid_argument with problem_with(problem), Guard when the factor cannot be trusted:
    /// smallest pivot ratio, residual, energy identity and sign of the centre's compliance are checked
    /// (MATH.md eq. 5).
    explicit Plate(const Problem& problem, Kernel kernel = Kernel::portable);
    ~Plate();
    Plate(Plate&&) noexcept;
    /// Another D in N m on the same grid, all else as before; no jumps on grid lines. Does not allocate.
    /// Throws Guard as the constructor does, and when D is not positive and finite; every question then does
    /// the same until a good D is set. O(n^3) for n x n nodes: 0.09 ms at 33 x 33 with AVX-512, 0.2 ms
    /// portable.
    void set_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& rigidity_n_m);
    /// Deflection in m at the centre node under 1 N there. The node counts must be odd. Second-order in the
    /// spacing with a logarithm (h^2 ln 1/h).
    [[nodiscard]] double centre_compliance_m_per_n() const;
    /// Deflection in m at a node under 1 N there. O(nodes), the centre's O(1). Does not allocate.
    [[nodiscard]] double compliance_m_per_n(const Node& node) const;
    /// The same at each of many nodes. Does not allocate.
    void compliances_m_per_n(std::span<const Node> nodes, std::span<double> m_per_n) const;
    /// Deflection at the nodes, (ix, iz), under 1 N at a node.
    [[nodiscard]] Eigen::ArrayXXd deflection_m(Eigen::Index ix, Eigen::Index iz) const;
    /// The same into a field of one number per node, ix fastest. Does not allocate.
    void deflection_m(const Node& loaded, std::span<double> deflection_m) const;
    /// Deflection in m at all nodes under forces in N at all nodes; both (ix, iz), ix fastest. Forces on
    /// nodes that cannot move do nothing. Does not allocate.
    void solve(std::span<const double> force_n, std::span<double> deflection_m) const;
    /// Stiffness matrix on the nodes that can move, x slowest; for tests and references.
    [[nodiscard]] Eigen::MatrixXd dense_stiffness_n_per_m() const;
    /// Which kernels run: `baseline`, `x86-64-v3`, `x86-64-v4`.
    [[nodiscard]] const char* kernel() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Uniform clamped square plate of side 1, D = 1, point load at its centre, on a foundation with a/l =
/// `side_over_l` >= 0 (l = (D/k_f)^(1/4)): continuum centre deflection. 0.005612024 without a foundation,
/// 1/(8 (a/l)^2) for a/l large. Relative error below 1e-9 up to a/l = 24, 1e-7 beyond (MATH.md eq. 6-7).
[[nodiscard]] double uniform_square_compliance(double side_over_l);

/// A compliance and how wrong it may be.
struct Estimate {
    double m_per_n;
    double relative_error;  ///< estimated, about the continuum; within a factor of 2 where it matters, else
                            ///< pessimistic
};

/// Compliance at a node extrapolated to the continuum from two grids, the finer `fine` and the coarser made
/// of its every second node: c* = [4 (c_fine - delta_fine/D0) - (c_coarse - delta_coarse/D0)]/3, delta the
/// uniform square's own grid error at the local l (MATH.md eq. 8-10). Exact at the centre of a uniform
/// square; other places, proportions and spacings cost no order, as delta then comes from a square of the
/// mean spacing. Node counts 4 m + 1, at least 9; the node's numbers even. Smooth in D and k_f. Throws as
/// Plate does. About 0.25 ms at 33 x 33; a thread's first call with a new grid and range of a/l some 20 times
/// that.
[[nodiscard]] Estimate extrapolated_compliance(const Problem& fine, const Node& load);
[[nodiscard]] Estimate extrapolated_centre_compliance(const Problem& fine);

}  // namespace palpate::plate
