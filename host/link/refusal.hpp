/// Which table the loop would refuse, and why, before it is sent.
#pragma once
#include <optional>
#include <string>

#include "common/table.h"

namespace palpate::link {

/// "stiffness 6.3 kN/m at (1.0, -2.0, 3.1) mm is above what the loop accepts (6.0 kN/m)": why the loop would
/// refuse `table`, which is sealed; the place is the one that it was made for. nullopt: it will not. The
/// loop's own check with the loop's own limits.
[[nodiscard]] std::optional<std::string> refusal_of(const pal_table& table);

}  // namespace palpate::link
