/// The Falcon's geometry as text, and as many mistakes in it as wanted.
#pragma once
#include <array>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace deltatext {

using Lines = std::vector<std::pair<std::string, std::string>>;

/// docs/PROTOCOL.md 4, lengths times `scale`: 15 lines without comments.
inline Lines lines(double scale = 1.0) {
    const auto length = [scale](double value_m) {
        std::ostringstream out;
        out.precision(12);
        out << scale * value_m;
        return out.str();
    };
    return {{"arm_m", length(0.060)},
            {"forearm_m", length(0.1025)},
            {"offset_m", length(0.0225)},
            {"platform_u_m", length(0.01443)},
            {"platform_v_m", length(-0.025)},
            {"base_u_m", length(0.0400)},
            {"base_v_m", length(-0.02309)},
            {"leg_deg", "[105, -15, -135]"},
            {"counts_per_rad", "1572.5625"},
            {"theta_zero_deg", "35"},
            {"theta_min_deg", "-25"},
            {"theta_max_deg", "90"},
            {"units_per_n_m", "4200"},
            {"motor_max_units", "4095"},
            {"centre_m", "[0, 0, " + length(0.12) + "]"}};
}

inline std::string text_of(const Lines& lines) {
    std::string text;
    for (const auto& [key, value] : lines) text += key + " = " + value + "\n";
    return text;
}

inline std::string nf1() {
    return text_of(lines());
}

inline std::string scaled(double scale) {
    return text_of(lines(scale));
}

/// The Falcon with another value.
inline std::string with(const std::string& key, const std::string& value) {
    Lines all = lines();
    for (auto& line : all) {
        if (line.first == key) line.second = value;
    }
    return text_of(all);
}

inline std::string without(const std::string& key) {
    Lines all = lines();
    std::erase_if(all, [&key](const auto& line) { return line.first == key; });
    return text_of(all);
}

inline std::vector<std::string> keys() {
    std::vector<std::string> all;
    for (const auto& line : lines()) all.push_back(line.first);
    return all;
}

}  // namespace deltatext
