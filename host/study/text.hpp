/// Numbers and cells as a study writes them.
#pragma once
#include <string>
#include <string_view>

#include "host/study/oracle.hpp"

namespace palpate::study {

/// `digits` significant ones; `none` when not finite.
[[nodiscard]] std::string number_text(double value, int digits = 6, std::string_view none = "");
/// Seconds with the unit that suits: `1.30 ms`.
[[nodiscard]] std::string time_text(double time_s);
/// Null when not finite.
[[nodiscard]] Json number_json(double value);
/// A CSV cell: quoted when it must be.
[[nodiscard]] std::string cell(std::string_view text);

}  // namespace palpate::study
