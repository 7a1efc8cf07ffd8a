#include "host/study/text.hpp"

#include <array>
#include <cmath>
#include <cstdio>

namespace palpate::study {

std::string number_text(double value, int digits, std::string_view none) {
    if (!std::isfinite(value)) return std::string(none);
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "%.*g", digits, value);
    return text.data();
}

std::string time_text(double time_s) {
    if (!std::isfinite(time_s)) return "-";
    if (time_s >= 1.0) return number_text(time_s, 3) + " s";
    if (time_s >= 1e-3) return number_text(1e3 * time_s, 3) + " ms";
    return number_text(1e6 * time_s, 3) + " us";
}

Json number_json(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

std::string cell(std::string_view text) {
    if (text.find_first_of(",\"\n") == std::string_view::npos) return std::string(text);
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + "\"";
}

}  // namespace palpate::study
