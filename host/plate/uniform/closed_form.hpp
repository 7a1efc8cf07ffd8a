/// The uniform rectangle in closed form: what any other method must agree with.
#pragma once
#include <Eigen/Core>
#include <array>
#include <complex>
#include <vector>

#include "host/plate/problem.hpp"

namespace palpate::plate {

/// Poisson's ratio is not asked for: on a straight edge with w = 0 the moment is -D w_nn, and the Gaussian
/// curvature's energy, all that nu multiplies, integrates to nothing.
struct UniformPlate {
    Eigen::Vector2d size_m{0.04, 0.04};
    double rigidity_n_m = 1.0;
    double foundation_n_per_m3 = 0.0;  ///< >= 0
    std::array<Edge, 4> edges{};       ///< x low, x high, z low, z high
};

/// 1 N at a point inside the plate, or spread evenly over a disc that lies inside it.
struct UniformLoad {
    Eigen::Vector2d at_m{0.02, 0.02};
    double radius_m = 0.0;  ///< 0: a point. At most 6 l, l = (D/k_f)^(1/4).
};

struct ClosedForm {
    double m_per_n;
    double relative_error;  ///< estimated: what the last doubling of the waves changed, and rounding
};

/// Simply supported plate (Levy's series, summed in closed form near the load) less what the moments along
/// the clamped edges, sine series up to 800 half waves per short side, take off it (MATH.md eq. 34-36).
/// Relative error of the compliance for a load in the middle below 1e-12, on a foundation of
/// a/l = 50 below 1e-10; at a distance d (short sides) from the corner of two clamped edges 1e-10 for d >
/// 0.05, 1e-8 for 0.01, 1e-6 for 0.005, none below 0.001; compliance() tells. Any aspect: of a plate longer
/// than 20 short sides the 10 on either side of the load are looked at; a/l to 400 was run.
/// Construction: 2 ms in the middle, 0.1 s near such a corner, longer on long plates (0.2 s at 1:10).
class UniformSolution {
public:
    /// Throws std::invalid_argument for a free edge, a size, rigidity or foundation out of range, a load not
    /// inside or so close to an edge that the series leave no digit.
    UniformSolution(const UniformPlate& plate, const UniformLoad& load);
    /// Deflection at the load (over a disc: its mean), and its error estimated from two truncations.
    [[nodiscard]] ClosedForm compliance() const;
    /// Deflection anywhere on the plate under the load.
    [[nodiscard]] double deflection_m_per_n(const Eigen::Vector2d& at_m) const;

    /// Lengths in short sides, D = 1.
    struct Plate {
        Eigen::Vector2d size;
        double epsilon;  ///< sqrt(k_f)
        std::array<Edge, 4> edges;
    };
    struct Load {
        Eigen::Vector2d at;
        double radius;
        std::complex<double>
            spread;  ///< mean over the disc of what solves lap f = i epsilon f, f(centre) = 1
    };
    /// A moment sin(wave t) on the low and the high edge across `axis`, with these weights.
    struct Mode {
        Eigen::Index axis;
        int half_waves;
        double low, high;
    };

private:
    Eigen::Vector2d corner_m_{0.0, 0.0};  ///< of what is looked at
    double unit_m_;
    double scale_m_per_n_;
    Plate plate_;
    Load load_;
    std::vector<Mode> modes_;
    Eigen::VectorXd moments_;
    ClosedForm compliance_{};
};

/// The widest disc whose series keep their digits: 6 l, l = (D/k_f)^(1/4). Infinite without a foundation.
[[nodiscard]] double disc_radius_max_m(double rigidity_n_m, double foundation_n_per_m3);

}  // namespace palpate::plate
