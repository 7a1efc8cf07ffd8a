#include "host/latency/words.hpp"

#include <array>
#include <cstdio>

namespace palpate::latency {

std::string number_text(double value, int n_decimals) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.*f", n_decimals, value);
    return text.data();
}

std::string us_text(double ns) {
    const double us = ns / 1000.0;
    return number_text(us, us < 9.995 ? 2 : us < 999.95 ? 1 : 0);
}

std::string share_text(double share) {
    return number_text(100.0 * share, 2) + " %";
}

}  // namespace palpate::latency
