#include "host/plate/analysis.hpp"

#include <algorithm>
#include <iterator>
#include <map>
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
        const std::size_t centre = analysis_.node(analysis_.nx / 2, analysis_.nz / 2);
        bool has_centre = false;
        for (Index ix = box.x0; ix < box.x1; ++ix) {
            for (Index iz = box.z0; iz < box.z1; ++iz) {
                const std::size_t node = analysis_.node(ix, iz);
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
        if (x < 1 || x > analysis.nx - 2 || z < 1 || z > analysis.nz - 2) continue;
        visit(x, z, analysis.number[analysis.node(x, z)]);
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

Analysis::Analysis(Index n_x, Index n_z)
    : nx(n_x),
      nz(n_z),
      n_unknowns(static_cast<std::size_t>((n_x - 2) * (n_z - 2))),
      number(static_cast<std::size_t>(n_x * n_z), EDGE),
      n_factor(0),
      largest_front(0),
      n_waiting(0) {
    std::vector<Box> boxes;
    Dissection(*this, boxes).eliminate({1, nx - 1, 1, nz - 1});
    for (std::size_t f = 0; f < fronts.size(); ++f) {
        Front& front = fronts[f];
        for (std::size_t k = 0; k < front.n_pivots; ++k) front.rows.push_back(front.first + k);
        for (const std::size_t number_outside : border_of(*this, boxes[f]))
            front.rows.push_back(number_outside);
    }
    connect_fronts();
    make_pattern();
    locate_entries();
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
    std::vector<std::vector<std::size_t>> columns(n_unknowns);
    for (Index ix = 1; ix < nx - 1; ++ix) {
        for (Index iz = 1; iz < nz - 1; ++iz) {
            std::vector<std::size_t>& rows = columns[number[node(ix, iz)]];
            rows.push_back(number[node(ix, iz)]);
            for_neighbours(*this, ix, iz, [&](Index, Index, std::size_t other) {
                if (other > rows.front()) rows.push_back(other);
            });
            std::sort(rows.begin(), rows.end());
        }
    }
    column.push_back(0);
    for (const Front& front : fronts) {
        for (std::size_t k = 0; k < front.n_pivots; ++k) {
            for (const std::size_t r : columns[front.first + k]) {
                row.push_back(r);
                front_row.push_back(place_in(front.rows, r));
            }
            column.push_back(row.size());
        }
    }
}

std::size_t Analysis::entry(std::size_t node_a, std::size_t node_b) const {
    const std::size_t a = number[node_a];
    const std::size_t b = number[node_b];
    if (a == EDGE || b == EDGE) return row.size();
    const auto begin = row.begin() + static_cast<std::ptrdiff_t>(column[std::min(a, b)]);
    const auto end = row.begin() + static_cast<std::ptrdiff_t>(column[std::min(a, b) + 1]);
    return static_cast<std::size_t>(std::distance(row.begin(), std::lower_bound(begin, end, std::max(a, b))));
}

void Analysis::locate_entries() {
    const auto pairs = [this](std::span<const std::size_t> nodes, std::span<std::size_t> entries) {
        std::size_t next = 0;
        for (std::size_t a = 0; a < nodes.size(); ++a) {
            for (std::size_t b = 0; b <= a; ++b) entries[next++] = entry(nodes[a], nodes[b]);
        }
    };
    node_entries.resize(number.size());
    for (Index ix = 0; ix < nx; ++ix) {
        for (Index iz = 0; iz < nz; ++iz) {
            // Beyond the edge any clamped node will do: the centre of an edge node is clamped itself.
            const std::array<std::size_t, 5> nodes{
                node(ix, iz), node(std::max<Index>(ix - 1, 0), iz), node(std::min(ix + 1, nx - 1), iz),
                node(ix, std::max<Index>(iz - 1, 0)), node(ix, std::min(iz + 1, nz - 1))};
            pairs(nodes, node_entries[node(ix, iz)]);
        }
    }
    for (Index ix = 0; ix + 1 < nx; ++ix) {
        for (Index iz = 0; iz + 1 < nz; ++iz) {
            const std::array<std::size_t, 4> nodes{node(ix, iz), node(ix + 1, iz), node(ix, iz + 1),
                                                   node(ix + 1, iz + 1)};
            pairs(nodes, cell_entries.emplace_back());
        }
    }
}

std::shared_ptr<const Analysis> analysis_for(Index nx, Index nz) {
    thread_local std::map<std::pair<Index, Index>, std::shared_ptr<const Analysis>> made;
    std::shared_ptr<const Analysis>& slot = made[{nx, nz}];
    if (!slot) slot = std::make_shared<const Analysis>(nx, nz);
    return slot;
}

}  // namespace palpate::plate
