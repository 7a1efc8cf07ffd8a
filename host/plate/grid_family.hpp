/// One question on a grid and on those made of its every second node, and what they say of the continuum.
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "host/plate/compliance.hpp"
#include "host/plate/grid_answer.hpp"

namespace palpate::plate {

/// A grid that halves: 4 m + 1 nodes, at least 9.
[[nodiscard]] bool halves(const Nodes& nodes);
[[nodiscard]] Nodes half(const Nodes& nodes);
/// Whether a grid of so many nodes can see every value that the sheet's fields were given.
[[nodiscard]] bool sees_all(const Sheet& sheet, const Nodes& nodes);

class GridFamily {
public:
    /// What is asked; borrowed.
    GridFamily(const Sheet& sheet, std::span<const Load> loads, const Accuracy& accuracy,
               const Wanted& wanted);
    /// Whether the load can be a node of this grid and of its coarser ones. Close to an edge it cannot.
    [[nodiscard]] bool has(const Nodes& nodes) const;
    /// On `nodes` and up to two coarser grids by a method that works on grids (MATH.md eq. 8-10, 33). Throws
    /// as make_solver and Solver do, std::invalid_argument when not has(nodes).
    [[nodiscard]] Compliance on(const Nodes& nodes, Method method) const;

private:
    struct Level {
        GridAnswer answer;
        double corrected;  ///< compliance less the twin's grid error
        double step;       ///< largest ratio of D between neighbours
    };
    [[nodiscard]] Level level(const Nodes& nodes, Method method, int halvings) const;
    [[nodiscard]] Compliance joined(const std::vector<Level>& levels, const Nodes& nodes,
                                    Method method) const;
    void read_deflections(const std::vector<Level>& levels, Compliance& result) const;
    void estimate(const std::vector<Level>& levels, Compliance& result) const;
    [[nodiscard]] double error_of(const std::vector<Level>& levels, double limit, const Nodes& nodes) const;
    [[nodiscard]] double sampling_error(const Nodes& nodes) const;
    [[nodiscard]] double unseen_error(const Nodes& nodes) const;
    [[nodiscard]] double punch_error(const Nodes& nodes) const;

    const Sheet& sheet_;
    std::span<const Load> loads_;
    const Accuracy& accuracy_;
    const Wanted& wanted_;
    std::optional<Twin> twin_;
};

}  // namespace palpate::plate
