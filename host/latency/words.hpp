/// Numbers as people read them.
#pragma once
#include <string>

namespace palpate::latency {

/// With that many decimals.
[[nodiscard]] std::string number_text(double value, int n_decimals);
/// Nanoseconds in microseconds, three digits or so: "0.21", "34.5", "1042".
[[nodiscard]] std::string us_text(double ns);
/// 0.9512: "95.12 %".
[[nodiscard]] std::string share_text(double share);

}  // namespace palpate::latency
