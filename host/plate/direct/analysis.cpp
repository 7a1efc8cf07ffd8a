#include "host/plate/direct/analysis.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <tuple>
#include <utility>

namespace palpate::plate {
namespace {

using Eigen::Index;

constexpr Index LEAF_NODES = 16;

/// Nodes x0 <= ix < x1, z0 <= iz < z1.
struct Box {
    Index x0, x1, z0, z1;
    [[nodiscard]] bool holds(Index ix, Index iz) const { return ix >= x0 && ix < x1 && iz >= z0 && iz < z1; }
};

struct Cut {
    std::vector<Box> children;
    Box pivots;
};

/// A leaf has no children and its own nodes as pivots.
Cut cut(const Box& box) {
    const Index length_x = box.x1 - box.x0;
    const Index length_z = box.z1 - box.z0;
    if (length_x * length_z <= LEAF_NODES) return {{}, box};
    if (length_x >= length_z) {
        const Index middle = box.x0 + length_x / 2;
        return {{{box.x0, middle - 1, box.z0, box.z1}, {middle + 1, box.x1, box.z0, box.z1}},
                {middle - 1, middle + 1, box.z0, box.z1}};
    }
    const Index middle = box.z0 + length_z / 2;
    return {{{box.x0, box.x1, box.z0, middle - 1}, {box.x0, box.x1, middle + 1, box.z1}},
            {box.x0, box.x1, middle - 1, middle + 1}};
}

/// Numbers the unknowns of a box and appends its fronts, children before parents. Depth: log2 of the box's
/// area.
class Dissection {
public:
    Dissection(Analysis& analysis, std::vector<Box>& boxes) : analysis_(analysis), boxes_(boxes) {}

    std::size_t eliminate(const Box& box) {
        const Cut pieces = cut(box);
        Front front{};
        for (const Box& child : pieces.children) front.children.push_back(eliminate(child));
        front.first = next_;
        number(pieces.pivots);
        front.n_pivots = next_ - front.first;
        analysis_.fronts.push_back(std::move(front));
        boxes_.push_back(box);
        return analysis_.fronts.size() - 1;
    }

private:
    void number(const Box& box) {
        const std::size_t centre = analysis_.layout.at(analysis_.layout.nx / 2, analysis_.layout.nz / 2);
        bool has_centre = false;
        for (Index ix = box.x0; ix < box.x1; ++ix) {
            for (Index iz = box.z0; iz < box.z1; ++iz) {
                const std::size_t node = analysis_.layout.at(ix, iz);
                if (node == centre) {
                    has_centre = true;
                } else {
                    analysis_.number[node] = next_++;
                }
            }
        }
        if (has_centre) analysis_.number[centre] = next_++;
    }

    Analysis& analysis_;
    std::vector<Box>& boxes_;
    std::size_t next_ = 0;
};

constexpr std::array<std::pair<Index, Index>, 12> REACH{
    {{-2, 0}, {-1, -1}, {-1, 0}, {-1, 1}, {0, -2}, {0, -1}, {0, 1}, {0, 2}, {1, -1}, {1, 0}, {1, 1}, {2, 0}}};

/// Calls visit(number) for each unknown within the 13-point stencil of (ix, iz), that node left out.
template <typename Visit>
void for_neighbours(const Analysis& analysis, Index ix, Index iz, Visit visit) {
    for (const auto& [dx, dz] : REACH) {
        const Index x = ix + dx;
        const Index z = iz + dz;
        if (!analysis.moving.holds(x, z)) continue;
        visit(x, z, analysis.number[analysis.layout.at(x, z)]);
    }
}

/// Elimination numbers of what lies outside `box` within the stencil's reach, ascending.
std::vector<std::size_t> border_of(const Analysis& analysis, const Box& box) {
    std::vector<std::size_t> border;
    for (Index ix = box.x0; ix < box.x1; ++ix) {
        for (Index iz = box.z0; iz < box.z1; ++iz) {
            for_neighbours(analysis, ix, iz, [&](Index x, Index z, std::size_t number) {
                if (!box.holds(x, z)) border.push_back(number);
            });
        }
    }
    std::sort(border.begin(), border.end());
    border.erase(std::unique(border.begin(), border.end()), border.end());
    return border;
}

std::size_t place_in(const std::vector<std::size_t>& rows, std::size_t number) {
    return static_cast<std::size_t>(
        std::distance(rows.begin(), std::lower_bound(rows.begin(), rows.end(), number)));
}

}  // namespace

Analysis::Analysis(Index nx, Index nz, const Moving& that_move)
    : layout{nx, nz},
      moving(that_move),
      n_unknowns(static_cast<std::size_t>(moving.count())),
      number(layout.size(), EDGE),
      n_factor(0),
      largest_front(0),
      n_waiting(0) {
    std::vector<Box> boxes;
    Dissection(*this, boxes).eliminate({moving.x0, moving.x1, moving.z0, moving.z1});
    for (std::size_t f = 0; f < fronts.size(); ++f) {
        Front& front = fronts[f];
        for (std::size_t k = 0; k < front.n_pivots; ++k) front.rows.push_back(front.first + k);
        for (const std::size_t number_outside : border_of(*this, boxes[f]))
            front.rows.push_back(number_outside);
    }
    connect_fronts();
    make_pattern();
}

void Analysis::connect_fronts() {
    std::size_t waiting = 0;
    for (Front& front : fronts) {
        front.panel = n_factor;
        n_factor += front.rows.size() * front.n_pivots;
        largest_front = std::max(largest_front, front.rows.size());
        for (const std::size_t c : front.children) {
            Front& child = fronts[c];
            for (std::size_t k = child.n_pivots; k < child.rows.size(); ++k) {
                child.in_parent.push_back(place_in(front.rows, child.rows[k]));
            }
            waiting -= child.in_parent.size() * child.in_parent.size();
        }
        const std::size_t n_border = front.rows.size() - front.n_pivots;
        waiting += n_border * n_border;
        n_waiting = std::max(n_waiting, waiting);
    }
}

void Analysis::make_pattern() {
    struct Entry {
        std::size_t row;
        Source source;
    };
    std::vector<std::vector<Entry>> columns(n_unknowns);
    for (Index ix = moving.x0; ix < moving.x1; ++ix) {
        for (Index iz = moving.z0; iz < moving.z1; ++iz) {
            const std::size_t at = layout.at(ix, iz);
            for (std::size_t c = CENTRE; c < N_COUPLINGS; ++c) {
                const Index x = ix + OFFSETS[c].dx, z = iz + OFFSETS[c].dz;
                if (!moving.holds(x, z)) continue;
                const auto [low, high] = std::minmax({number[at], number[layout.at(x, z)]});
                columns[low].push_back({high, {static_cast<Coupling>(c), at}});
            }
        }
    }
    column.push_back(0);
    for (const Front& front : fronts) {
        for (std::size_t k = 0; k < front.n_pivots; ++k) {
            std::vector<Entry>& entries = columns[front.first + k];
            std::sort(entries.begin(), entries.end(),
                      [](const Entry& a, const Entry& b) { return a.row < b.row; });
            for (const Entry& entry : entries) {
                row.push_back(entry.row);
                front_row.push_back(place_in(front.rows, entry.row));
                source.push_back(entry.source);
            }
            column.push_back(row.size());
        }
    }
}

std::shared_ptr<const Analysis> analysis_for(const Layout& layout, const Moving& moving) {
    thread_local std::map<std::tuple<Index, Index, Moving>, std::shared_ptr<const Analysis>> made;
    std::shared_ptr<const Analysis>& slot = made[{layout.nx, layout.nz, moving}];
    if (!slot) slot = std::make_shared<const Analysis>(layout.nx, layout.nz, moving);
    return slot;
}

}  // namespace palpate::plate
