/// The certified bracket of one question.
#pragma once
#include <optional>
#include <string>

#include "host/plate/bounds/bounds.hpp"
#include "host/plate/compliance.hpp"

namespace palpate::plate {

/// Bounds on the continuum's compliance under the load alone, from the ladder on `nodes` (at most 65 a side
/// are used). nullopt, and the reason in `why`, where there is no certificate.
[[nodiscard]] std::optional<Bracket> certificate(const Sheet& sheet, const Nodes& nodes, const Load& load,
                                                 double wanted_relative_error, std::string& why);

}  // namespace palpate::plate
