/// Certified bounds on a plate's compliance, from uniform plates solved beforehand: no factorisation.
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/plate/problem.hpp"
#include "host/plate/solver.hpp"

namespace palpate::plate {

/// What a bound rests on, cheapest first: the extremes of D; one uniform plate; that and its answers to seven
/// patterns; conjugate gradients of two, three, four trials (MATH.md eq. 50-52).
enum class Rung { extremes, uniform, modes, krylov2, krylov3, krylov4 };
/// `extremes uniform modes krylov-2 krylov-3 krylov-4`
[[nodiscard]] const char* name_of(Rung rung);

/// The compliance lies in [lower, upper].
struct Bracket {
    double lower_m_per_n, upper_m_per_n;
    Rung rung;  ///< the dearest that was climbed
    [[nodiscard]] double middle_m_per_n() const {
        return std::sqrt(lower_m_per_n) * std::sqrt(upper_m_per_n);
    }
    /// The middle is that close to the compliance, surely.
    [[nodiscard]] double relative_error() const { return std::sqrt(upper_m_per_n / lower_m_per_n) - 1.0; }
};

/// When to stop climbing.
struct Climb {
    double relative_error = 0.0;  ///< enough is known once Bracket::relative_error() is this
    Rung last = Rung::krylov4;
};

/// sqrt(upper/lower) - 1 on Rung::uniform without a foundation, at most, whatever D between these looks like
/// (Kantorovich; MATH.md eq. 50).
[[nodiscard]] double uniform_rung_error(double d_least, double d_most);

/// Bounds on c = p'w for every D and k_f, of one grid, edges, Poisson's ratio and load p; exact statements
/// about the discrete plate (MATH.md eq. 51-52). Const calls may run in parallel, each with a
/// Scratch of its own.
class Bounds {
public:
    /// Uniform foundations to be ready for, as shorter side over l, l = (D/k_f)^(1/4), growing by `ratio`.
    /// The nearest serves; the farther off, the wider the bounds, never wrong.
    struct Foundations {
        double first = 1.0, last = 20.0, ratio = 1.1;
    };

    /// Why there can be no certificate for such a plate, in words; nullopt when there is one. Wants one
    /// Poisson's ratio, no mask, no laminate (jumps on grid lines), and edges that hold the plate without a
    /// foundation.
    [[nodiscard]] static std::optional<std::string> none_because(const Problem& problem);

    /// Of `grid_of` counts all but the values of D and k_f; with an empty k_f none can be asked for.
    /// `force_n`: load at the nodes, x fastest; the compliance is sum(force w) under these forces, the
    /// load-weighted mean deflection if they sum to 1. Throws std::invalid_argument with
    /// none_because(grid_of) or when no force acts on a node that moves. 33 x 33 nodes: 40 ms and 2 MB, with
    /// 33 foundations 0.4 s and 20 MB. Every kernel gives the same bits.
    Bounds(const Problem& grid_of, std::span<const double> force_n, Kernel kernel = Kernel::best);
    Bounds(const Problem& grid_of, std::span<const double> force_n, const Foundations& foundations,
           Kernel kernel = Kernel::best);
    ~Bounds();
    Bounds(Bounds&&) noexcept;

    /// Memory for one call at a time.
    class Scratch {
    public:
        explicit Scratch(const Bounds& bounds);
        ~Scratch();
        Scratch(Scratch&&) noexcept;

    private:
        friend class Bounds;
        struct Impl;
        std::unique_ptr<Impl> impl_;
    };

    /// D > 0 in N m and k_f >= 0 in N/m^3 at the nodes, x fastest; k_f may be empty. Throws
    /// std::invalid_argument for other values or sizes. Does not allocate, as far as Plate::solve does not.
    [[nodiscard]] Bracket bracket(std::span<const double> rigidity_n_m,
                                  std::span<const double> foundation_n_per_m3, const Climb& climb,
                                  Scratch& scratch) const;

    /// A uniform plate of D = 1 N m on the grid, under the same load.
    struct Uniform {
        double foundation_n_per_m3;  ///< per N m of D
        double m_per_n;
    };
    /// Which kernels add up: `baseline`, `x86-64-v3`, `x86-64-v4`.
    [[nodiscard]] const char* kernel() const;
    /// Those kept, from no foundation up.
    [[nodiscard]] std::vector<Uniform> uniforms() const;
    /// Where the plate of the last call holds its energy: shares at the nodes due to D and to k_f, summing to
    /// 1, from a deflection of two trials or more. `foundation` may be empty without one.
    void energy_shares(Scratch& scratch, std::span<double> rigidity, std::span<double> foundation) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// For one plate, its own D and k_f. Throws as Bounds does.
[[nodiscard]] Bracket bracket(const Problem& problem, std::span<const double> force_n,
                              const Climb& climb = {});

}  // namespace palpate::plate
