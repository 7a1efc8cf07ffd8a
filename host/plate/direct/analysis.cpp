#include "host/plate/direct/analysis.hpp"

#include <algorithm>
#include <cassert>
#include <iterator>
#include <map>
#include <tuple>
#include <utility>

namespace palpate::plate {
namespace {

using Eigen::Index;

constexpr Index LEAF_NODES = 16;  // 9 to 25 cost the same

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

std::uint32_t u32(std::size_t n) {
    assert(n < Analysis::NONE);
    return static_cast<std::uint32_t>(n);
}

std::uint32_t whole_blocks(std::uint32_t n) {
    return (n + Analysis::SLOTS - 1) / Analysis::SLOTS * Analysis::SLOTS;
}

/// Numbers the unknowns of a box and appends its fronts, children before parents. Depth: log2 of the box's
/// area.
class Dissection {
public:
    Dissection(Analysis& analysis, std::vector<Box>& boxes, std::vector<std::uint32_t>& depths)
        : analysis_(analysis), boxes_(boxes), depths_(depths) {}

    std::uint32_t eliminate(const Box& box, std::uint32_t depth) {
        const Cut pieces = cut(box);
        Front front{};
        front.children = {Analysis::NONE, Analysis::NONE};
        for (std::size_t k = 0; k < pieces.children.size(); ++k)
            front.children[k] = eliminate(pieces.children[k], depth + 1);
        front.first = u32(analysis_.node.size());
        number(pieces.pivots);
        front.n_pivots = u32(analysis_.node.size()) - front.first;
        front.parent = Analysis::NONE;
        const std::uint32_t place = u32(analysis_.fronts.size());
        for (std::size_t k = 0; k < pieces.children.size(); ++k)
            analysis_.fronts[front.children[k]].parent = place;
        analysis_.fronts.push_back(front);
        boxes_.push_back(box);
        depths_.push_back(depth);
        return place;
    }

private:
    /// Along the longer side, so that what a smaller box reaches of a separator is one run of numbers.
    void number(const Box& box) {
        const std::size_t centre = analysis_.layout.at(analysis_.layout.nx / 2, analysis_.layout.nz / 2);
        const bool along_z = box.z1 - box.z0 > box.x1 - box.x0;
        const Index n_outer = along_z ? box.z1 - box.z0 : box.x1 - box.x0;
        const Index n_inner = along_z ? box.x1 - box.x0 : box.z1 - box.z0;
        bool has_centre = false;
        for (Index outer = 0; outer < n_outer; ++outer) {
            for (Index inner = 0; inner < n_inner; ++inner) {
                const std::size_t at = along_z ? analysis_.layout.at(box.x0 + inner, box.z0 + outer)
                                               : analysis_.layout.at(box.x0 + outer, box.z0 + inner);
                if (at == centre) {
                    has_centre = true;
                } else {
                    append(at);
                }
            }
        }
        if (has_centre) append(centre);
    }
    void append(std::size_t at) {
        analysis_.number[at] = analysis_.node.size();
        analysis_.node.push_back(u32(at));
        analysis_.owner.push_back(u32(analysis_.fronts.size()));
    }

    Analysis& analysis_;
    std::vector<Box>& boxes_;
    std::vector<std::uint32_t>& depths_;
};

constexpr std::array<std::pair<Index, Index>, 12> COUPLED{
    {{-2, 0}, {-1, -1}, {-1, 0}, {-1, 1}, {0, -2}, {0, -1}, {0, 1}, {0, 2}, {1, -1}, {1, 0}, {1, 1}, {2, 0}}};

/// Elimination numbers of what lies outside `box` within the 13-point stencil's reach, ascending.
std::vector<std::uint32_t> border_of(const Analysis& analysis, const Box& box) {
    std::vector<std::uint32_t> border;
    for (Index ix = box.x0; ix < box.x1; ++ix) {
        for (Index iz = box.z0; iz < box.z1; ++iz) {
            if (ix >= box.x0 + 2 && ix + 2 < box.x1 && iz >= box.z0 + 2 && iz + 2 < box.z1) continue;
            for (const auto& [dx, dz] : COUPLED) {
                const Index x = ix + dx, z = iz + dz;
                if (analysis.moving.holds(x, z) && !box.holds(x, z))
                    border.push_back(u32(analysis.number[analysis.layout.at(x, z)]));
            }
        }
    }
    std::sort(border.begin(), border.end());
    border.erase(std::unique(border.begin(), border.end()), border.end());
    return border;
}

/// Slot of an unknown in a front, which must have it.
std::uint32_t slot_of(const Analysis& analysis, const Front& front, std::size_t number) {
    if (number < front.first + front.n_pivots) return u32(number - front.first);
    const auto begin = analysis.border.begin() + front.border;
    const auto found = std::lower_bound(begin, begin + front.n_border, number);
    assert(found != begin + front.n_border && *found == number);
    return front.pivot_slots + u32(static_cast<std::size_t>(std::distance(begin, found)));
}

}  // namespace

Analysis::Analysis(Index nx, Index nz, const Moving& that_move)
    : layout{nx, nz},
      moving(that_move),
      n_unknowns(static_cast<std::size_t>(moving.count())),
      number(layout.size(), EDGE),
      n_factor(0),
      n_updates(0),
      n_slots_max(0) {
    place_fronts();
    for (Front& front : fronts) {
        if (front.parent != NONE) connect(fronts[front.parent], front);
    }
    make_entries();
    assert(n_unknowns == node.size() && node.back() == layout.at(nx / 2, nz / 2));
}

void Analysis::place_fronts() {
    std::vector<Box> boxes;
    std::vector<std::uint32_t> depths;
    Dissection(*this, boxes, depths).eliminate({moving.x0, moving.x1, moving.z0, moving.z1}, 0);
    const std::size_t n_places = 2 * (1 + *std::max_element(depths.begin(), depths.end()));
    std::vector<std::size_t> size(n_places, 0), start(n_places, 0);
    const auto place_of = [&](std::size_t f) {
        const Front& front = fronts[f];
        const bool second = front.parent != NONE && fronts[front.parent].children[1] == f;
        return 2 * depths[f] + (second ? 1U : 0U);
    };
    for (std::size_t f = 0; f < fronts.size(); ++f) {
        Front& front = fronts[f];
        const std::vector<std::uint32_t> outside = border_of(*this, boxes[f]);
        front.border = u32(border.size());
        front.n_border = u32(outside.size());
        border.insert(border.end(), outside.begin(), outside.end());
        front.pivot_slots = whole_blocks(front.n_pivots);
        front.n_slots = front.pivot_slots + whole_blocks(front.n_border);
        front.stride = front.n_slots;
        front.panel = n_factor;
        n_factor += std::size_t{front.stride} * front.n_pivots;
        n_slots_max = std::max<std::size_t>(n_slots_max, front.n_slots);
        const std::size_t n_update = std::size_t{front.border_slots()} * front.border_slots();
        size[place_of(f)] = std::max(size[place_of(f)], n_update);
    }
    for (std::size_t k = 0; k < n_places; ++k) {
        start[k] = n_updates;
        n_updates += size[k];
    }
    n_updates += SLOTS;  // kernels read whole blocks from any row on
    for (std::size_t f = 0; f < fronts.size(); ++f) fronts[f].update = start[place_of(f)];
    parent_slot.resize(border.size(), NONE);
}

void Analysis::connect(const Front& parent, Front& child) {
    child.pull_slots = u32(pull_column.size());
    child.pull_blocks = u32(pull_mask.size());
    pull_column.resize(pull_column.size() + parent.n_slots, NONE);
    for (std::uint32_t row = 0; row < child.n_border; ++row) {
        const std::uint32_t slot = slot_of(*this, parent, border[child.border + row]);
        parent_slot[child.border + row] = slot;
        pull_column[child.pull_slots + slot] = row;
    }
    for (std::uint32_t block = 0; block < parent.n_slots; block += SLOTS) {
        unsigned mask = 0;
        std::uint32_t first_row = 0;
        for (std::uint32_t k = SLOTS; k-- > 0;) {
            const std::uint32_t row = pull_column[child.pull_slots + block + k];
            if (row == NONE) continue;
            mask |= 1U << k;
            first_row = row;
        }
        pull_mask.push_back(static_cast<std::uint8_t>(mask));
        pull_row.push_back(first_row);
    }
}

void Analysis::make_entries() {
    struct Entry {
        std::uint32_t target, source;
    };
    std::vector<std::vector<Entry>> of_front(fronts.size());
    for (Index ix = moving.x0; ix < moving.x1; ++ix) {
        for (Index iz = moving.z0; iz < moving.z1; ++iz) {
            const std::size_t at = layout.at(ix, iz);
            for (std::size_t c = CENTRE; c < N_COUPLINGS; ++c) {
                const Index x = ix + OFFSETS[c].dx, z = iz + OFFSETS[c].dz;
                if (!moving.holds(x, z)) continue;
                const auto [low, high] = std::minmax({number[at], number[layout.at(x, z)]});
                const Front& front = fronts[owner[low]];
                const std::size_t target =
                    front.panel + (low - front.first) * front.stride + slot_of(*this, front, high);
                of_front[owner[low]].push_back({u32(target), u32(c * layout.size() + at)});
            }
        }
    }
    for (std::size_t f = 0; f < fronts.size(); ++f) {
        std::vector<Entry>& entries = of_front[f];
        std::sort(entries.begin(), entries.end(),
                  [](const Entry& a, const Entry& b) { return a.target < b.target; });
        fronts[f].first_entry = u32(entry_source.size());
        fronts[f].n_entries = u32(entries.size());
        for (const Entry& entry : entries) {
            entry_source.push_back(entry.source);
            entry_target.push_back(entry.target);
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
