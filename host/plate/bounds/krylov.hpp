/// Bounds from trials made for one D: conjugate gradients on deflections from below, on balanced stresses
/// from above, each preconditioned by a uniform plate (MATH.md section 17).
#pragma once
#include <span>
#include <vector>

#include "host/plate/bounds/member.hpp"
#include "host/plate/bounds/weights.hpp"

namespace palpate::plate::bounds {

/// Memory for one question at a time. No call allocates, as far as Plate::solve does not.
class Krylov {
public:
    explicit Krylov(const Setting& setting);

    /// The first trials are the uniform plates' own. `below` and `above` are anchors; `above` has a
    /// foundation only if k is positive everywhere.
    void start(const Member& below, const Member& above, const Weights& weights);
    /// One more trial on each side: two solutions of the uniform plates.
    void step();
    /// Bounds on c with D and k as they were given, valid whatever rounding did (MATH.md section 17).
    [[nodiscard]] double lower();
    [[nodiscard]] double upper();
    /// Of the deflection's energy, what each node holds through D and through k; their sum is 1. A cell's is
    /// its corners'. The nodes x fastest; `foundation` may be empty.
    void energy_shares(std::span<double> rigidity, std::span<double> foundation);

private:
    using Vector = std::vector<double>;

    void set_weights(const Weights& weights);
    void step_below();
    void step_above();
    void move_below();
    void solve(const Plate& plate, const Vector& force, Vector& deflection);
    [[nodiscard]] double dot(const Vector& a, const Vector& b) const;
    [[nodiscard]] double weighted_square(const Vector& a, const Vector& weight) const;

    const Setting* setting_;
    Strains<double> strains_;
    Vector row_sums_;
    Vector force_;
    Vector d_, inverse_d_;                                        ///< of the rows of B
    Vector deflection_, deflection_step_, residual_, product_;    ///< padded
    Vector stress_, stress_step_, stress_slope_, strain_, rows_;  ///< rows of B
    Vector nodes_force_, nodes_deflection_;
    const Member* below_ = nullptr;
    const Member* above_ = nullptr;
    const SumKernels* sums_ = nullptr;  ///< the question's
    double below_energy_ = 0.0, above_energy_ = 0.0, least_ratio_ = 0.0;
    bool above_begun_ = false;
};

}  // namespace palpate::plate::bounds
