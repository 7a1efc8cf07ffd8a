#include <algorithm>

#include "host/scene/resolve.hpp"

namespace palpate::scene {
namespace {

constexpr const char* HEAD = R"(# Every key of a scene

Generated from the table of keys in `host/scene/keys.cpp`; a test holds the two together (`test_scene "[.write]"` writes it).

A scene is a TOML file. Every number carries its unit in its key; lengths are metres of the object after scaling, in the
object's own axes, unless it says workspace. Only what nobody but the user can know has no default. Any other key is
refused, with the nearest known one named; errors read `file:line: what is wrong; what would be right`.

`--set section.key=value` replaces or adds one value, read as TOML; a bare word is a string. Items of a list are
counted from 0: `--set change.1.factor=3`, `--set hand.path.0.depth_m=-0.02`, `--set "expect.stop=== none"`.

| key | default | meaning |
|---|---|---|
| `scene` | `1` | the format; a newer one is refused |
)";

constexpr const char* EXPECT = R"(
## [expect]

`NAME = "<= X"`, `">= X"` or `"== X"`: a bound for a number, or `"== word"` for a word, of `summary.json`. The verdict
fails when one does not hold.
)";

std::string bars_escaped(const std::string& text) {
    std::string out;
    for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
    return out;
}

/// "above 0 Pa"; "m, cm or mm"; "".
template <class Owner>
std::string limits(const Key<Owner>& key) {
    if (*key.choices != '\0') return either(split(key.choices, '|'));
    const std::string range = key.range.words();
    return range.empty() || *key.unit == '\0' ? range + key.unit : key.unit + std::string(", ") + range;
}

template <class Owner>
std::string row(const std::string& name, const Key<Owner>& key, const Owner& defaults) {
    const std::string value = value_text(key, defaults);
    std::string cell = "`" + value + "`";
    if (key.required) cell = "required, such as `" + std::string(key.example) + "`";
    if (value.empty()) cell = "none";
    const std::string limit = limits(key);
    return "| `" + name + "` | " + cell + " | " +
           bars_escaped(key.about + (limit.empty() ? "" : " (" + limit + ")")) + " |\n";
}

constexpr const char* ROWS = "\n| key | default | meaning |\n|---|---|---|\n";

std::string changes() {
    std::string out = "\n## [[change]]\n\nIn order, each times what is there. The keys of a nodule:\n";
    out += ROWS;
    for (const Key<Change>& key : nodule_keys()) out += row(key.name, key, Change{});
    out += "\nThe keys of a gradient:\n";
    out += ROWS;
    for (const Key<Change>& key : gradient_keys()) out += row(key.name, key, Change{});
    return out;
}

std::string hand_tables() {
    std::string out = "\nA point of `hand.path`:\n";
    out += ROWS;
    for (const Key<PathPoint>& key : path_keys()) out += row(key.name, key, PathPoint{});
    out +=
        "\nA grip of one's own, `grip = { mass_kg = 0.15, stiffness_n_per_m = 500.0, damping_n_s_per_m = 8.0 "
        "}`:\n";
    out += ROWS;
    for (const Key<Hand>& key : grip_keys()) out += row(key.name, key, Hand{});
    return out;
}

}  // namespace

std::string scene_markdown() {
    std::string out = HEAD;
    std::string section;
    const Scene defaults;
    for (const Key<Scene>& key : scene_keys()) {
        const std::vector<std::string> parts = split(key.name, '.');
        if (parts.size() == 2 && parts[0] != section) {
            if (section == "skin") out += changes();
            if (section == "hand") out += hand_tables();
            section = parts[0];
            out += "\n## [" + section + "]\n";
            out += ROWS;
        }
        out += row(parts.back(), key, defaults);
    }
    return out + EXPECT;
}

}  // namespace palpate::scene
