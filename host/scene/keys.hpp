/// The table of scene keys: one place for names, types, units, ranges, words and meanings. Reading, the
/// resolved scene and docs/SCENE.md are made from it.
#pragma once
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host/scene/scene.hpp"

namespace palpate::scene {

/// What a number may be; NaN and infinity never pass.
struct Range {
    double above = -std::numeric_limits<double>::infinity();
    double at_least = -std::numeric_limits<double>::infinity();
    double at_most = std::numeric_limits<double>::infinity();
    double below = std::numeric_limits<double>::infinity();
    [[nodiscard]] bool holds(double value) const;
    [[nodiscard]] std::string words() const;  ///< "above 0 and at most 8.9"; empty without a limit
};

/// Where a key's value lives in its owner. `Hand&` is the grip: a word or a table.
template <class Owner>
using Field = std::variant<double& (*)(Owner&), std::uint32_t& (*)(Owner&), std::uint64_t& (*)(Owner&),
                           std::string& (*)(Owner&), std::filesystem::path& (*)(Owner&), Vec3& (*)(Owner&),
                           std::array<double, 2>& (*)(Owner&), std::vector<std::string>& (*)(Owner&),
                           Model& (*)(Owner&), Law& (*)(Owner&), Change::Shape& (*)(Owner&),
                           std::vector<PathPoint>& (*)(Owner&), Hand& (*)(Owner&)>;

template <class Owner>
struct Key {
    const char* name;  ///< in a Scene "section.key", elsewhere "key"
    Field<Owner> field;
    const char* example;  ///< as TOML
    const char* about;
    const char* unit = "";
    bool required = false;
    Range range = {};
    const char* choices = "";  ///< words, '|' between them; for an enum in its order
    const char* unbuilt = "";  ///< words that a later version will know
};

[[nodiscard]] std::span<const Key<Scene>> scene_keys();
[[nodiscard]] std::span<const Key<Change>> nodule_keys();
[[nodiscard]] std::span<const Key<Change>> gradient_keys();
[[nodiscard]] std::span<const Key<PathPoint>> path_keys();
[[nodiscard]] std::span<const Key<Hand>> grip_keys();

/// Sections in the order of the reference: "object", "skin", ...
[[nodiscard]] std::vector<std::string> sections();
/// Every dotted name that a scene may hold, sections included.
[[nodiscard]] std::vector<std::string> known_names();
/// The known name with the fewest typing errors between it and `name`; the first of several.
[[nodiscard]] std::string nearest_name(std::string_view name);

[[nodiscard]] std::vector<std::string> split(std::string_view words, char separator);
/// "linear", "potential or normal", "m, cm or inch".
[[nodiscard]] std::string either(const std::vector<std::string>& words);
/// Shortest text that reads back to the same double.
[[nodiscard]] std::string number_text(double value);

/// Grip of that name; false when there is none.
[[nodiscard]] bool grip_by_name(const std::string& name, Hand& hand);

}  // namespace palpate::scene
