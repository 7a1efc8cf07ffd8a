/// From bounds on the discrete plate to bounds on the plate itself.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "host/plate/bounds/bounds.hpp"

namespace palpate::plate {

/// Compliance in m/N of the plate of D = 1 N m everywhere, on a uniform foundation in N/m^3 (0: none), under
/// the same load, of the continuum: uniform_square_compliance or a UniformSolution.
using UniformCompliance = std::function<double(double foundation_n_per_m3)>;

/// Bounds on the continuum: those of the grid over the grid's compliance of the uniform plate times the
/// continuum's, widened by what the grid may still do to that ratio. Two grids tell: the given one and every
/// second node of it (MATH.md eq. 53). Unlike Bounds not a theorem: the widening is an estimate with a
/// safety factor.
class ContinuumBounds {
public:
    /// What Bounds::none_because says, or node counts that are not 2 m + 1, at least 9.
    [[nodiscard]] static std::optional<std::string> none_because(const Problem& problem);

    /// Nodes of odd number share their force among their even neighbours on the coarse grid. Throws as Bounds
    /// does. Costs what two Bounds cost, and one `exact` per foundation.
    ContinuumBounds(const Problem& grid_of, std::span<const double> force_n, const UniformCompliance& exact,
                    const Bounds::Foundations& foundations);
    ContinuumBounds(const Problem& grid_of, std::span<const double> force_n, const UniformCompliance& exact);
    ~ContinuumBounds();
    ContinuumBounds(ContinuumBounds&&) noexcept;

    /// Memory for one call at a time.
    class Scratch {
    public:
        explicit Scratch(const ContinuumBounds& bounds);
        ~Scratch();
        Scratch(Scratch&&) noexcept;

    private:
        friend class ContinuumBounds;
        struct Impl;
        std::unique_ptr<Impl> impl_;
    };

    /// As Bounds::bracket; `climb` is about the discrete plate, the widening comes on top. nullopt, and the
    /// reason in `why` (may be null), where neighbours' D differ by more than a factor of 100, or l under the
    /// load is shorter than the spacing.
    [[nodiscard]] std::optional<Bracket> bracket(std::span<const double> rigidity_n_m,
                                                 std::span<const double> foundation_n_per_m3,
                                                 const Climb& climb, Scratch& scratch,
                                                 std::string* why = nullptr) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// For one plate. nullopt, and the reason in `why` (may be null), where there is no certificate. Throws
/// std::invalid_argument when the load is none.
[[nodiscard]] std::optional<Bracket> continuum_bracket(const Problem& problem,
                                                       std::span<const double> force_n,
                                                       const UniformCompliance& exact, const Climb& climb,
                                                       std::string* why);

/// What one plate is likely to need of Bounds::Foundations: some around k_f/D of its nodes.
[[nodiscard]] Bounds::Foundations foundations_for(const Problem& problem);

}  // namespace palpate::plate
