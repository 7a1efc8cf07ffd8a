#include "host/scene/read.hpp"

#include <algorithm>
#include <type_traits>

namespace palpate::scene {

std::string Source::place(const std::string& name, std::uint32_t line) const {
    const auto under = [](const std::string& inner, const std::string& outer) {
        if (inner.compare(0, outer.size(), outer) != 0) return false;
        return inner.size() == outer.size() || inner[outer.size()] == '.' || inner[outer.size()] == '[';
    };
    for (const std::string& key : overridden) {
        const bool made_by_it = line == 0 && under(key, name);  // a section that is not in the file
        if (under(name, key) || made_by_it) return "--set " + key;
    }
    return file + ":" + std::to_string(std::max(line, 1U));
}

std::string nearest_place(const std::map<std::string, std::string>& places, std::string name) {
    while (!name.empty()) {
        if (const auto found = places.find(name); found != places.end()) return found->second;
        const std::size_t cut = name.find_last_of(".[");
        name.resize(cut == std::string::npos ? 0 : cut);
    }
    return name;
}

void refuse(const std::string& place, std::string words) {
    words = place + ": " + words;
    std::replace_if(
        words.begin(), words.end(), [](char c) { return (c >= 0 && c < 0x20) || c == 0x7F; }, ' ');
    throw Error(words);
}

void Source::fail(const std::string& name, std::uint32_t line, const std::string& words) const {
    refuse(place(name, line), words);
}

void Source::fail(const std::string& name, const toml::node& node, const std::string& words) const {
    fail(name, node.source().begin.line, words);
}

void Source::fail(const std::string& name, const std::string& words) const {
    const std::string nearest = nearest_place(places, name);
    refuse(nearest.empty() ? place(name, 0) : nearest, words);
}

std::optional<double> number_in(const toml::node& node) {
    if (const auto* real = node.as_floating_point()) return real->get();
    if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
    return std::nullopt;
}

std::string kind(const toml::node& node) {
    switch (node.type()) {
        case toml::node_type::table:
            return "a table";
        case toml::node_type::array:
            return "an array";
        case toml::node_type::string:
            return "a string";
        case toml::node_type::integer:
            return "an integer";
        case toml::node_type::floating_point:
            return "a number";
        case toml::node_type::boolean:
            return "a boolean";
        case toml::node_type::none:
            break;
        case toml::node_type::date:
        case toml::node_type::time:
        case toml::node_type::date_time:
            return "a date or time";
    }
    return "nothing";
}

void refuse_unknown(const Source& source, const toml::table& table, const std::string& prefix,
                    const std::string& plain, const std::vector<std::string>& names) {
    const toml::key* first = nullptr;
    for (const auto& [key, node] : table) {
        if (std::find(names.begin(), names.end(), key.str()) != names.end()) continue;
        if (first == nullptr || key.source().begin.line < first->source().begin.line) first = &key;
    }
    if (first == nullptr) return;
    const std::string name = prefix + std::string(first->str());
    const std::string plain_name = plain + std::string(first->str());
    const std::string nearest = nearest_name(plain_name);
    const std::string words = nearest == plain_name ? " does not belong here; " + either(names) + " would"
                                                    : " is unknown; the nearest known key is " + nearest;
    source.fail(name, first->source().begin.line, name + words);
}

namespace {

template <class T>
const char* noun() {
    if constexpr (std::is_same_v<T, double>) return "a number";
    if constexpr (std::is_same_v<T, std::uint32_t> || std::is_same_v<T, std::uint64_t>)
        return "a whole number";
    if constexpr (std::is_same_v<T, Vec3>) return "three numbers";
    if constexpr (std::is_same_v<T, std::array<double, 2>>) return "two numbers";
    if constexpr (std::is_same_v<T, std::vector<std::string>>) return "an array of strings";
    if constexpr (std::is_same_v<T, std::vector<PathPoint>>) return "an array of tables";
    if constexpr (std::is_same_v<T, Hand>) return "none, light, firm or a table";
    return "a string";
}

/// "; a number in Pa above 0 is expected, such as 0.4e6"
template <class T, class Owner>
std::string expected(const Key<Owner>& key, bool with_range) {
    const bool plural = std::is_same_v<T, Vec3> || std::is_same_v<T, std::array<double, 2>>;
    std::string out = "; ";
    if (*key.choices != '\0') {
        out += either(split(key.choices, '|'));
    } else {
        out += noun<T>();
        if (*key.unit != '\0') out += std::string(" in ") + key.unit;
    }
    if (const std::string range = key.range.words(); with_range && !range.empty()) out += " " + range;
    return out + (plural ? " are" : " is") + " expected, such as " + key.example;
}

/// One value on its way into a field.
template <class Owner>
struct Value {
    Source& source;
    const std::string& name;
    const toml::node& node;
    const Key<Owner>& key;

    template <class T>
    [[noreturn]] void wrong_type() const {
        source.fail(name, node, name + " is " + kind(node) + expected<T>(key, false));
    }

    template <class T>
    double number(const toml::node& from, const std::string& as) const {
        const std::optional<double> value = number_in(from);
        if (!value) source.fail(as, from, as + " is " + kind(from) + expected<T>(key, false));
        if (!key.range.holds(*value))
            source.fail(as, from, as + " is " + number_text(*value) + expected<T>(key, true));
        return *value;
    }

    void into(double& field) const { field = number<double>(node, name); }

    template <class Whole>
    void into_whole(Whole& field, std::int64_t most) const {
        const auto* whole = node.as_integer();
        if (whole == nullptr) wrong_type<Whole>();
        const std::int64_t value = whole->get();
        if (value < 0 || value > most || !key.range.holds(static_cast<double>(value))) {
            source.fail(name, node, name + " is " + std::to_string(value) + expected<Whole>(key, true));
        }
        field = static_cast<Whole>(value);
    }
    void into(std::uint32_t& field) const { into_whole(field, std::numeric_limits<std::uint32_t>::max()); }
    void into(std::uint64_t& field) const { into_whole(field, std::numeric_limits<std::int64_t>::max()); }

    template <class T>
    std::string text(const toml::node& from) const {
        const auto* string = from.as_string();
        if (string == nullptr) wrong_type<T>();
        const std::string& value = string->get();
        const auto control = [](char c) { return (c >= 0 && c < 0x20) || c == 0x7F; };
        if (std::any_of(value.begin(), value.end(), control)) {
            source.fail(name, from, name + " holds a control character; plain text is expected");
        }
        return value;
    }

    /// Index into the key's choices.
    template <class T>
    std::size_t choice() const {
        const std::string word = text<T>(node);
        const std::vector<std::string> words = split(key.choices, '|');
        const std::vector<std::string> later = split(key.unbuilt, '|');
        for (std::size_t i = 0; i < words.size(); ++i) {
            if (words[i] == word) return i;
        }
        if (!word.empty() && std::find(later.begin(), later.end(), word) != later.end()) {
            source.fail(name, node, name + " = \"" + word + "\" is not built yet: use " + either(words));
        }
        source.fail(name, node, name + " is \"" + word + "\"" + expected<T>(key, false));
    }

    void into(std::string& field) const {
        field =
            *key.choices == '\0' ? text<std::string>(node) : split(key.choices, '|')[choice<std::string>()];
    }
    void into(std::filesystem::path& field) const { field = text<std::filesystem::path>(node); }
    void into(Model& field) const { field = static_cast<Model>(choice<Model>()); }
    void into(Law& field) const { field = static_cast<Law>(choice<Law>()); }
    void into(Change::Shape& field) const { field = static_cast<Change::Shape>(choice<Change::Shape>()); }

    template <std::size_t N>
    void into(std::array<double, N>& field) const {
        using T = std::array<double, N>;
        const toml::array* array = node.as_array();
        if (array == nullptr) wrong_type<T>();
        if (array->size() != N) {
            const std::string n = std::to_string(array->size()) + (array->size() == 1 ? " value" : " values");
            source.fail(name, node, name + " has " + n + expected<T>(key, false));
        }
        for (std::size_t i = 0; i < N; ++i) {
            field[i] = number<T>(*array->get(i), name + "[" + std::to_string(i) + "]");
        }
    }

    void into(std::vector<std::string>& field) const {
        const toml::array* array = node.as_array();
        if (array == nullptr) wrong_type<std::vector<std::string>>();
        field.clear();
        for (const toml::node& item : *array) field.push_back(text<std::vector<std::string>>(item));
    }

    void into(std::vector<PathPoint>& field) const {
        const toml::array* array = node.as_array();
        if (array == nullptr) wrong_type<std::vector<PathPoint>>();
        field.clear();
        for (const toml::node& item : *array) {
            const std::string item_name = name + "[" + std::to_string(field.size()) + "]";
            if (!item.is_table()) {
                source.fail(item_name, item,
                            item_name + " is " + kind(item) +
                                "; a table is expected, such as { t_s = 0.0, at_m = "
                                "[0.0, 0.0, 0.0], depth_m = -0.01 }");
            }
            PathPoint point;
            read_table<PathPoint>(source, item_name, "hand.path", *item.as_table(), path_keys(), point);
            field.push_back(point);
        }
    }

    void into(Hand& field) const {
        if (const toml::table* table = node.as_table()) {
            read_table<Hand>(source, name, "hand.grip", *table, grip_keys(), field);
            field.grip = "custom";
            return;
        }
        const std::string word = text<Hand>(node);
        if (!grip_by_name(word, field)) {
            source.fail(name, node, name + " is \"" + word + "\"" + expected<Hand>(key, false));
        }
    }
};

}  // namespace

template <class Owner>
void read_value(Source& source, const std::string& name, const toml::node& node, const Key<Owner>& key,
                Owner& owner) {
    source.places[name] = source.place(name, node.source().begin.line);
    const Value<Owner> value{source, name, node, key};
    std::visit([&](auto field) { value.into(field(owner)); }, key.field);
}

template <class Owner>
void fail_missing(const Source& source, const std::string& name, std::uint32_t line, const Key<Owner>& key) {
    const std::string words = std::visit(
        [&](auto field) {
            return expected<std::remove_reference_t<decltype(field(std::declval<Owner&>()))>>(key, false);
        },
        key.field);
    source.fail(name, line, name + " is missing" + words);
}

template <class Owner>
void read_table(Source& source, const std::string& name, const std::string& plain, const toml::table& table,
                std::span<const Key<Owner>> keys, Owner& owner) {
    std::vector<std::string> names;
    for (const Key<Owner>& key : keys) names.emplace_back(key.name);
    refuse_unknown(source, table, name + ".", plain + ".", names);
    source.places[name] = source.place(name, table.source().begin.line);
    for (const Key<Owner>& key : keys) {
        const std::string full = name + "." + key.name;
        if (const toml::node* node = table.get(key.name)) {
            read_value(source, full, *node, key, owner);
        } else if (key.required) {
            fail_missing(source, full, table.source().begin.line, key);
        }
    }
}

template void read_value(Source&, const std::string&, const toml::node&, const Key<Scene>&, Scene&);
template void read_value(Source&, const std::string&, const toml::node&, const Key<Change>&, Change&);
template void read_table(Source&, const std::string&, const std::string&, const toml::table&,
                         std::span<const Key<Change>>, Change&);
template void fail_missing(const Source&, const std::string&, std::uint32_t, const Key<Scene>&);
template void fail_missing(const Source&, const std::string&, std::uint32_t, const Key<Change>&);

}  // namespace palpate::scene
