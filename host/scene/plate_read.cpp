// From TOML nodes to a plate file's fields, by the table of keys.
#include "host/scene/plate_read.hpp"

#include <algorithm>
#include <type_traits>

#include "host/scene/nearest.hpp"

namespace palpate::scene {
namespace {

template <class T>
const char* noun() {
    if constexpr (std::is_same_v<T, double>) return "a number";
    if constexpr (std::is_same_v<T, bool>) return "true or false";
    if constexpr (std::is_same_v<T, Vec2>) return "two numbers";
    if constexpr (std::is_same_v<T, std::array<Eigen::Index, 2>>) return "two whole numbers";
    if constexpr (std::is_same_v<T, std::vector<Vec2>>) return "an array of places";
    return "a string";
}

/// One value on its way into a field.
struct Value {
    Source& source;
    const toml::node& node;
    const PlateKey& key;

    /// "; two numbers in m above 0 are expected, such as [0.04, 0.04]"
    template <class T>
    [[nodiscard]] std::string expected() const {
        const bool plural = std::is_same_v<T, Vec2> || std::is_same_v<T, std::array<Eigen::Index, 2>>;
        std::string out = "; ";
        if (*key.choices != '\0') {
            out += either(split(key.choices, '|'));
            if (std::is_same_v<T, std::array<plate::Edge, 4>>)
                out += ", for all or for x low, x high, z low and z high,";
        } else {
            out += noun<T>();
            if (*key.unit != '\0') out += std::string(" in ") + key.unit;
            if (const std::string range = key.range.words(); !range.empty()) out += " " + range;
        }
        return out + (plural ? " are" : " is") + " expected, such as " + key.example;
    }

    template <class T>
    [[noreturn]] void fail(const std::string& name, const toml::node& from, const std::string& is) const {
        source.fail(name, from, name + " " + is + expected<T>());
    }

    template <class T>
    double number(const toml::node& from, const std::string& as) const {
        const std::optional<double> value = number_in(from);
        if (!value) fail<T>(as, from, "is " + kind(from));
        if (!key.range.holds(*value)) fail<T>(as, from, "is " + number_text(*value));
        return *value;
    }

    template <class T>
    const toml::array& array_of(const toml::node& from, const std::string& as, std::size_t n) const {
        const toml::array* array = from.as_array();
        if (array == nullptr) fail<T>(as, from, "is " + kind(from));
        if (array->size() != n)
            fail<T>(as, from,
                    "has " + std::to_string(array->size()) + (array->size() == 1 ? " value" : " values"));
        return *array;
    }

    template <class T>
    Vec2 pair(const toml::node& from, const std::string& as) const {
        const toml::array& array = array_of<T>(from, as, 2);
        return {number<T>(*array.get(0), as + "[0]"), number<T>(*array.get(1), as + "[1]")};
    }

    /// Index into the key's choices.
    template <class T>
    std::size_t choice(const toml::node& from, const std::string& as) const {
        const auto* word = from.as_string();
        if (word == nullptr) fail<T>(as, from, "is " + kind(from));
        const std::vector<std::string> words = split(key.choices, '|');
        const auto found = std::find(words.begin(), words.end(), word->get());
        if (found == words.end()) fail<T>(as, from, "is \"" + word->get() + "\"");
        return static_cast<std::size_t>(found - words.begin());
    }

    void into(double& field) const { field = number<double>(node, key.name); }
    void into(Vec2& field) const { field = pair<Vec2>(node, key.name); }
    void into(bool& field) const {
        if (!node.is_boolean()) fail<bool>(key.name, node, "is " + kind(node));
        field = node.as_boolean()->get();
    }
    void into(plate::Sampling& field) const {
        field = static_cast<plate::Sampling>(choice<plate::Sampling>(node, key.name));
    }
    void into(plate::Method& field) const {
        field = static_cast<plate::Method>(choice<plate::Method>(node, key.name));
    }

    void into(std::array<plate::Edge, 4>& field) const {
        using T = std::array<plate::Edge, 4>;
        if (node.is_string()) {
            field.fill(static_cast<plate::Edge>(choice<T>(node, key.name)));
            return;
        }
        const toml::array& array = array_of<T>(node, key.name, field.size());
        for (std::size_t i = 0; i < field.size(); ++i) {
            const std::string as = key.name + ("[" + std::to_string(i) + "]");
            field[i] = static_cast<plate::Edge>(choice<T>(*array.get(i), as));
        }
    }

    void into(std::array<Eigen::Index, 2>& field) const {
        using T = std::array<Eigen::Index, 2>;
        const toml::array& array = array_of<T>(node, key.name, field.size());
        for (std::size_t i = 0; i < field.size(); ++i) {
            const std::string as = key.name + ("[" + std::to_string(i) + "]");
            if (!array.get(i)->is_integer()) fail<T>(as, *array.get(i), "is " + kind(*array.get(i)));
            field[i] = static_cast<Eigen::Index>(number<T>(*array.get(i), as));
        }
    }

    void into(std::filesystem::path& field) const {
        using T = std::filesystem::path;
        const auto* text = node.as_string();
        if (text == nullptr) fail<T>(key.name, node, "is " + kind(node));
        const auto control = [](char c) { return (c >= 0 && c < 0x20) || c == 0x7F; };
        const std::string& value = text->get();
        if (std::any_of(value.begin(), value.end(), control))
            fail<T>(key.name, node, "holds a control character");
        if (value.empty()) fail<T>(key.name, node, "is empty");
        field = value;
    }

    void into(std::vector<Vec2>& field) const {
        using T = std::vector<Vec2>;
        const toml::array* array = node.as_array();
        if (array == nullptr) fail<T>(key.name, node, "is " + kind(node));
        field.clear();
        for (const toml::node& item : *array)
            field.push_back(pair<T>(item, key.name + ("[" + std::to_string(field.size()) + "]")));
    }
};

/// Keys of a section without their section.
std::vector<std::string> names_in(const std::string& section) {
    std::vector<std::string> out;
    for (const PlateKey& key : plate_keys()) {
        const std::vector<std::string> parts = split(key.name, '.');
        if (parts[0] == section) out.push_back(parts[1]);
    }
    return out;
}

/// The known name that is meant by an unknown one: the same word in another section, else the nearest.
std::string meant_by(const std::string& name) {
    std::vector<std::string> known;
    const std::string word = split(name, '.').back();
    for (const PlateKey& key : plate_keys()) {
        if (split(key.name, '.')[1] == word) return key.name;
        known.emplace_back(key.name);
    }
    for (std::string& section : plate_sections()) known.push_back(std::move(section));
    return nearest_among(name, known);
}

/// Refuses the first key of `table` (by line) that is not among `names`.
void refuse_others(const Source& source, const toml::table& table, const std::string& prefix,
                   const std::vector<std::string>& names) {
    const toml::key* first = nullptr;
    for (const auto& [key, node] : table) {
        if (std::find(names.begin(), names.end(), key.str()) != names.end()) continue;
        if (first == nullptr || key.source().begin.line < first->source().begin.line) first = &key;
    }
    if (first == nullptr) return;
    const std::string name = prefix + std::string(first->str());
    source.fail(name, first->source().begin.line,
                name + " is unknown; the nearest known key is " + meant_by(name));
}

void read_section(Source& source, const toml::table& tree, const std::string& name, PlateFile& file) {
    const toml::node* node = tree.get(name);
    if (node == nullptr) return;
    const toml::table* section = node->as_table();
    if (section == nullptr)
        source.fail(name, *node, name + " is " + kind(*node) + "; a section [" + name + "] is expected");
    refuse_others(source, *section, name + ".", names_in(name));
    const std::uint32_t line = section->source().begin.line;  // 0: a --set made it
    if (line != 0) source.places[name] = source.place(name, line);
    for (const PlateKey& key : plate_keys()) {
        const std::vector<std::string> parts = split(key.name, '.');
        const toml::node* value = parts[0] == name ? section->get(parts[1]) : nullptr;
        if (value == nullptr) continue;
        source.places[key.name] = source.place(key.name, value->source().begin.line);
        const Value one{source, *value, key};
        std::visit([&](auto field) { one.into(field(file)); }, key.field);
    }
}

}  // namespace

void read_plate_tree(Source& source, const toml::table& tree, PlateFile& file) {
    refuse_others(source, tree, "", plate_sections());
    for (const std::string& section : plate_sections()) {
        read_section(source, tree, section, file);
        if (section == "plate") file.load.at_m = {0.5 * file.plate.size_m[0], 0.5 * file.plate.size_m[1]};
    }
    for (const PlateKey& key : plate_keys()) {  // last: a misspelt key is better named than the one meant
        if (*key.otherwise == '\0' && !source.places.contains(key.name)) {
            const toml::table none;
            const std::string words = std::visit(
                [&](auto field) {
                    using T = std::remove_reference_t<decltype(field(file))>;
                    return Value{source, none, key}.expected<T>();
                },
                key.field);
            source.fail(key.name, std::string(key.name) + " is missing" + words);
        }
    }
}

}  // namespace palpate::scene
