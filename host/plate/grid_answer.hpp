/// The discrete answer on one grid, and the grid error of the uniform plate that stands for it.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/plate/compliance.hpp"
#include "host/plate/loads.hpp"

namespace palpate::plate {

/// A sheet and its loads on one grid.
struct OnGrid {
    Problem problem;
    GridLines lines;
    std::vector<double> unit_force;  ///< of the first load, 1 N; empty if that is a punch
    std::vector<double> pressure_n;  ///< of all loads but punches

    /// With the first load, if it is a point, on a node of this grid and of its `halvings` coarser ones.
    OnGrid(const Sheet& sheet, const Nodes& nodes, std::span<const Load> loads, int halvings);
};

struct GridAnswer {
    Report report;
    std::string kernel;
    double m_per_n = 0.0;  ///< at the first load, alone
    std::vector<double> points_m;
    std::vector<double> field_m;  ///< at all nodes
};

/// Solves on one grid by one method. Throws std::invalid_argument and Guard as make_solver and Solver do.
[[nodiscard]] GridAnswer answer_on(const OnGrid& grid, std::span<const Load> loads,
                                   std::span<const Eigen::Vector2d> points_m, Method method,
                                   const Options& options);

/// A uniform plate with D and k_f of the place of the first load, and its compliance in the continuum: the
/// same plate where a closed form exists (no free edge, no hole), else a clamped square about the load (point
/// loads only; nullopt for others). Its grid error has the same h^2 ln(1/h) as the real one's (MATH.md eq.
/// 8).
class Twin {
public:
    [[nodiscard]] static std::optional<Twin> of(const Sheet& sheet, const Load& load);
    /// Compliance of the twin on that grid less its continuum value.
    [[nodiscard]] double grid_error_m_per_n(const OnGrid& grid) const;

private:
    double rigidity_n_m_ = 1.0, foundation_n_per_m3_ = 0.0;
    Load load_;
    std::optional<double> exact_m_per_n_;  ///< none: the square about the load stands in
};

}  // namespace palpate::plate
