/// The table of a plate file's keys: one place for names, types, units, ranges, words and meanings. Reading
/// and docs/PLATE_FILE.md are made from it.
#pragma once
#include <span>
#include <variant>

#include "host/scene/keys.hpp"
#include "host/scene/plate_file.hpp"

namespace palpate::scene {

/// Where a key's value lives. Edges are one word or four.
using PlateField =
    std::variant<double& (*)(PlateFile&), bool& (*)(PlateFile&), std::filesystem::path& (*)(PlateFile&),
                 plate::Sampling& (*)(PlateFile&), plate::Method& (*)(PlateFile&),
                 std::array<plate::Edge, 4>& (*)(PlateFile&), Vec2& (*)(PlateFile&),
                 std::array<Eigen::Index, 2>& (*)(PlateFile&), std::vector<Vec2>& (*)(PlateFile&)>;

struct PlateKey {
    const char* name;  ///< "section.key"
    PlateField field;
    const char* example;    ///< as TOML
    const char* otherwise;  ///< what holds when it is not given, for the reference; empty: it is required
    const char* about;
    const char* unit = "";
    Range range = {};          ///< of each number
    const char* choices = "";  ///< words, '|' between them; in the order of their enum
};

[[nodiscard]] std::span<const PlateKey> plate_keys();
/// "plate", "rigidity", ...
[[nodiscard]] std::vector<std::string> plate_sections();

/// Most nodes one way.
inline constexpr Eigen::Index PLATE_NODES_MAX = 4097;

}  // namespace palpate::scene
