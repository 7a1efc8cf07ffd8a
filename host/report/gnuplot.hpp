/// Pictures by the program gnuplot, which may not be there.
#pragma once
#include <string>

namespace palpate::report {

/// Text as gnuplot reads it: a quote inside single quotes is doubled.
[[nodiscard]] std::string gnuplot_quoted(const std::string& text);

/// Runs a script. `pictures` names what it makes, for the words. Words for a person when they were not made
/// and why (gnuplot is not installed, failed); empty when it ended well.
[[nodiscard]] std::string run_gnuplot(const std::string& script, const std::string& pictures);

/// Viridis, dark to bright.
inline constexpr const char* GNUPLOT_PALETTE =
    "set palette defined (0 '#440154', 0.25 '#3b528b', 0.5 '#21918c', 0.75 '#5ec962', 1 '#fde725')\n";

}  // namespace palpate::report
