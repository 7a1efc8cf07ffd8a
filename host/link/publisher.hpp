/// Puts finished tables into the ring, numbered in the order of publication.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/link.h"

namespace palpate::link {

/// After so many ticks the last table is published again: well within the 100 after which the loop calls it
/// stale.
constexpr std::uint32_t REFRESH_TICKS = 40;

/// A table that the loop would have refused.
struct Refused {
    std::array<float, 3> made_for_m;  ///< tool centre, workspace frame
    std::string why;                  ///< in words, place included
};

class Publisher {
public:
    /// The only writer of `link`'s table ring. Its tables are numbered from `last_id` + 1 on: above all that
    /// an earlier publisher of this ring may have used, or the loop refuses them.
    explicit Publisher(pal_link& link, std::uint64_t last_id = 0) : link_(&link), last_id_(last_id) {}
    /// Numbers and seals `table` and makes a copy of it the newest. Returns what was published; nullptr when
    /// the loop would refuse it: then it is in refused() and the last one stays. About 20 us.
    const pal_table* publish(std::unique_ptr<pal_table> table, std::uint32_t now_tick);
    /// The last table again, with a new number, when it was published 40 ticks ago or more: a hand that rests
    /// needs no new one, and the loop knows that the host lives. Not to be called while a new one is late:
    /// the age that the loop sees would lie. nullptr when there is none or it is young enough.
    const pal_table* refresh(std::uint32_t now_tick);
    [[nodiscard]] const std::vector<Refused>& refused() const { return refused_; }

private:
    pal_link* link_;
    std::unique_ptr<pal_table> last_;
    std::uint64_t last_id_;
    std::uint32_t last_tick_ = 0;
    std::vector<Refused> refused_;
};

}  // namespace palpate::link
