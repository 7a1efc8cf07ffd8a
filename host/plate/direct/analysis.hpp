/// Where everything goes in the Cholesky factor of a plate: depends on the grid and on
/// which edges can move, not on K.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "host/plate/stencil.hpp"

namespace palpate::plate {

/// One dense step of the elimination: the pivots [first, first + n_pivots) and the later unknowns they reach.
struct Front {
    std::size_t first;  ///< elimination number of the first pivot
    std::size_t n_pivots;
    std::vector<std::size_t> rows;       ///< elimination numbers: pivots, then border, ascending
    std::vector<std::size_t> children;   ///< fronts whose updates come in here
    std::vector<std::size_t> in_parent;  ///< place of each border row in the parent's rows
    std::size_t panel;                   ///< where its rows x n_pivots block of L starts, columns together
};

/// Geometric nested dissection with separators two nodes wide (the stencil's reach). The centre node (nx/2,
/// nz/2) is eliminated last, so its compliance is the reciprocal of the last pivot.
struct Analysis {
    static constexpr std::size_t EDGE = static_cast<std::size_t>(-1);

    Analysis(Eigen::Index nx, Eigen::Index nz, const Moving& moving);

    Layout layout;
    Moving moving;
    std::size_t n_unknowns;
    std::vector<std::size_t>
        number;                 ///< elimination number of each node, in the layout; EDGE if it cannot move
    std::vector<Front> fronts;  ///< in order of elimination
    std::size_t n_factor;       ///< entries of all panels
    std::size_t largest_front;  ///< rows
    std::size_t n_waiting;      ///< most entries of Schur complements that wait for their parents at one time

    /// Lower triangle of K by columns of elimination number; the diagonal comes first in each column.
    std::vector<std::size_t> column;     ///< first entry of each column; n_unknowns + 1
    std::vector<std::size_t> row;        ///< of each entry
    std::vector<std::size_t> front_row;  ///< of each entry: place in the rows of its column's front

    /// Where in a stencil each entry is.
    struct Source {
        Coupling coupling;
        std::size_t at;
    };
    std::vector<Source> source;

private:
    void connect_fronts();
    void make_pattern();
};

/// The analysis for one grid. Each thread keeps those it has made (a pure function's memory: results do
/// not depend on it).
[[nodiscard]] std::shared_ptr<const Analysis> analysis_for(const Layout& layout, const Moving& moving);

}  // namespace palpate::plate
