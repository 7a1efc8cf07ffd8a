#include <algorithm>
#include <charconv>
#include <cmath>

#include "host/scene/keys.hpp"
#include "host/scene/nearest.hpp"

namespace palpate::scene {

bool Range::holds(double value) const {
    return std::isfinite(value) && value > above && value >= at_least && value <= at_most && value < below;
}

std::string Range::words() const {
    std::string out;
    const auto add = [&out](const char* words, double limit) {
        if (std::isinf(limit)) return;
        if (!out.empty()) out += " and ";
        out += words + number_text(limit);
    };
    add("above ", above);
    add("at least ", at_least);
    add("at most ", at_most);
    add("below ", below);
    return out;
}

std::string number_text(double value) {
    const double size = std::fabs(value);
    const bool plain = size == 0.0 || (size >= 1e-4 && size < 1e9);
    char text[64];
    const auto end = std::to_chars(text, text + sizeof text, value,
                                   plain ? std::chars_format::fixed : std::chars_format::scientific);
    return {text, end.ptr};
}

std::vector<std::string> split(std::string_view words, char separator) {
    std::vector<std::string> out;
    std::size_t begin = 0;
    while (begin <= words.size()) {
        const std::size_t end = std::min(words.find(separator, begin), words.size());
        out.emplace_back(words.substr(begin, end - begin));
        begin = end + 1;
    }
    return out;
}

std::string either(const std::vector<std::string>& words) {
    std::string out;
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (i > 0) out += i + 1 == words.size() ? " or " : ", ";
        out += words[i];
    }
    return out;
}

bool grip_by_name(const std::string& name, Hand& hand) {
    struct Grip {
        const char* name;
        double mass_kg, stiffness_n_per_m, damping_n_s_per_m;
    };
    static constexpr Grip GRIPS[] = {
        // assumed, not measured
        {"none", 0.0, 0.0, 0.0},
        {"light", 0.05, 150.0, 2.0},
        {"firm", 0.15, 500.0, 8.0},
    };
    for (const Grip& grip : GRIPS) {
        if (name != grip.name) continue;
        hand.grip = name;
        hand.mass_kg = grip.mass_kg;
        hand.stiffness_n_per_m = grip.stiffness_n_per_m;
        hand.damping_n_s_per_m = grip.damping_n_s_per_m;
        return true;
    }
    return false;
}

std::vector<std::string> sections() {
    std::vector<std::string> out;
    for (const Key<Scene>& key : scene_keys()) {
        const std::vector<std::string> parts = split(key.name, '.');
        if (parts.size() == 2 && (out.empty() || out.back() != parts[0])) out.push_back(parts[0]);
    }
    return out;
}

std::vector<std::string> known_names() {
    std::vector<std::string> out = {"scene"};
    for (const Key<Scene>& key : scene_keys()) out.emplace_back(key.name);
    for (const auto& keys : {nodule_keys(), gradient_keys()}) {
        for (const Key<Change>& key : keys) out.push_back(std::string("change.") + key.name);
    }
    for (const Key<PathPoint>& key : path_keys()) out.push_back(std::string("hand.path.") + key.name);
    for (const Key<Hand>& key : grip_keys()) out.push_back(std::string("hand.grip.") + key.name);
    for (std::string& section : sections()) out.push_back(std::move(section));
    out.emplace_back("change");
    out.emplace_back("expect");
    return out;
}

std::string nearest_name(std::string_view name) {
    return nearest_among(name, known_names());
}

}  // namespace palpate::scene
