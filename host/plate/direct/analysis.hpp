/// Where everything goes in the Cholesky factor of a plate: depends on the grid and on which edges can move,
/// not on K.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "host/plate/stencil.hpp"

namespace palpate::plate {

/// One dense step of the elimination: pivots, and the later unknowns they reach (the border). Rows are kept
/// in slots: the pivots', then the border's, each group filled up with empty slots to a multiple of 8, so
/// that any vector kernel runs without remainders.
struct Front {
    std::uint32_t first;  ///< elimination number of the first pivot
    std::uint32_t n_pivots, n_border;
    std::uint32_t pivot_slots, n_slots;
    std::uint32_t parent;                   ///< NONE for the last front
    std::array<std::uint32_t, 2> children;  ///< NONE, NONE for a leaf
    std::uint32_t border;                   ///< where its border starts in Analysis::border
    std::uint32_t pull_blocks, pull_slots;  ///< where its map into the parent starts, by 8 slots and by slot
    std::uint32_t first_entry, n_entries;   ///< of K, in columns of its pivots
    std::uint32_t stride;                   ///< from one column of the panel to the next
    std::uint32_t border_slots() const { return n_slots - pivot_slots; }
    std::size_t panel;   ///< where its n_pivots columns of L start
    std::size_t update;  ///< where its Schur complement starts: border_slots() columns and rows
};

/// Geometric nested dissection with separators two nodes wide (the stencil's reach). The centre node (nx/2,
/// nz/2) is eliminated last, so its compliance is the reciprocal of the last pivot.
struct Analysis {
    static constexpr std::size_t EDGE = static_cast<std::size_t>(-1);
    static constexpr std::uint32_t NONE = static_cast<std::uint32_t>(-1);
    static constexpr std::uint32_t SLOTS = 8;  ///< in a block

    Analysis(Eigen::Index nx, Eigen::Index nz, const Moving& moving);

    Layout layout;
    Moving moving;
    std::size_t n_unknowns;
    std::vector<std::size_t>
        number;  ///< elimination number of each node, in the layout; EDGE if it cannot move
    std::vector<std::uint32_t> node;    ///< place in the layout of each unknown
    std::vector<std::uint32_t> owner;   ///< front in which each unknown is a pivot
    std::vector<Front> fronts;          ///< in order of elimination
    std::vector<std::uint32_t> border;  ///< elimination numbers, ascending in each front
    std::size_t n_factor;               ///< numbers in all panels
    std::size_t n_updates;    ///< numbers that Schur complements need: two places per depth of the tree
    std::size_t n_slots_max;  ///< largest front

    /// Of each child, by blocks of 8 slots of its parent: which of them it has (bit i: slot i), and its first
    /// row there.
    std::vector<std::uint8_t> pull_mask;
    std::vector<std::uint32_t> pull_row;
    /// Of each child, by slot of its parent: its row there, or NONE.
    std::vector<std::uint32_t> pull_column;
    /// Of each child, by its border: the slot in its parent. Starts like `border`.
    std::vector<std::uint32_t> parent_slot;

    /// Entries of K, the lower triangle by fronts: where in the stencil's couplings, and where in the panels.
    std::vector<std::uint32_t> entry_source;
    std::vector<std::uint32_t> entry_target;

private:
    void place_fronts();
    void connect(const Front& parent, Front& child);
    void make_entries();
};

/// The analysis for one grid. Each thread keeps those it has made (a pure function's memory: results do
/// not depend on it).
[[nodiscard]] std::shared_ptr<const Analysis> analysis_for(const Layout& layout, const Moving& moving);

}  // namespace palpate::plate
