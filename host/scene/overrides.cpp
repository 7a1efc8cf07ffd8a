#include <algorithm>
#include <charconv>
#include <optional>

#include "host/scene/read.hpp"
#include "host/scene/resolve.hpp"

namespace palpate::scene {
namespace {

std::string trimmed(const std::string& text) {
    const std::size_t begin = text.find_first_not_of(" \t\r\n");
    return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(" \t\r\n") - begin + 1);
}

/// The value as TOML, or, when it is none, as the string that it is.
toml::table parse_value(const std::string& name, const std::string& text) {
    try {
        toml::table table = toml::parse("value = " + text);
        if (table.size() == 1 && table.contains("value")) return table;
    } catch (const toml::parse_error& error) {
        if (!text.empty() && std::string("[{\"'").find(text[0]) != std::string::npos) {
            refuse("--set " + name, std::string(error.description()));
        }
    }
    try {
        return toml::parse("value = " + toml_string(text));
    } catch (const toml::parse_error& error) {
        refuse("--set " + name, std::string(error.description()));
    }
}

/// Position in an array when `part` is a number within it.
std::optional<std::size_t> index_in(const toml::array& array, const std::string& part) {
    std::size_t index = 0;
    const auto end = std::from_chars(part.data(), part.data() + part.size(), index);
    if (end.ec != std::errc{} || end.ptr != part.data() + part.size() || index >= array.size()) return {};
    return index;
}

/// The node that `part` names in `node`; makes a table where a key of a table is missing.
toml::node& child(toml::node& node, const std::string& part, const std::string& name) {
    if (toml::table* table = node.as_table()) {
        if (!table->contains(part)) table->insert(part, toml::table{});
        return *table->get(part);
    }
    if (toml::array* array = node.as_array()) {
        if (const auto index = index_in(*array, part)) return *array->get(*index);
        refuse("--set " + name, "there is no item " + part + "; the array has " +
                                    std::to_string(array->size()) + ", counted from 0");
    }
    refuse("--set " + name, part + " is looked for in " + kind(node) + "; a table is expected there");
}

void put(toml::node& node, const std::string& part, toml::node& value, const std::string& name) {
    toml::table* table = node.as_table();
    toml::array* array = node.as_array();
    value.visit([&](auto& concrete) {
        if (table != nullptr) {
            table->insert_or_assign(part, std::move(concrete));
        } else if (const auto index = array != nullptr ? index_in(*array, part) : std::nullopt) {
            array->erase(array->cbegin() + static_cast<std::ptrdiff_t>(*index));
            array->insert(array->cbegin() + static_cast<std::ptrdiff_t>(*index), std::move(concrete));
        } else {
            refuse("--set " + name, "there is no " + part + " in " + kind(node));
        }
    });
}

/// Puts one "section.key=value" into the tree; returns the name as errors show it, "change[1].factor".
std::string override_one(toml::table& tree, const std::string& text) {
    const std::size_t equals = text.find('=');
    const std::string name = trimmed(text.substr(0, equals));
    const std::vector<std::string> parts = split(name, '.');
    const bool whole =
        std::none_of(parts.begin(), parts.end(), [](const auto& part) { return part.empty(); });
    constexpr std::size_t DEEPEST = 4;  // hand.path.3.at_m
    if (equals == std::string::npos || !whole || parts.size() > DEEPEST) {
        refuse("--set " + text, "KEY=VALUE is expected, such as skin.young_pa=0.4e6");
    }
    toml::table value = parse_value(name, trimmed(text.substr(equals + 1)));
    toml::node* at = &tree;
    std::string shown;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const bool in_array = at->is_array();
        shown += in_array ? "[" + parts[i] + "]" : (i == 0 ? "" : ".") + parts[i];
        if (i + 1 < parts.size()) {
            at = &child(*at, parts[i], name);
        } else {
            put(*at, parts[i], *value.get("value"), name);
        }
    }
    return shown;
}

}  // namespace

toml::table read_tree(Source& source, std::string_view text, std::span<const std::string> overrides) {
    toml::table tree;
    try {
        tree = toml::parse(text);
    } catch (const toml::parse_error& error) {
        refuse(source.file + ":" + std::to_string(std::max(error.source().begin.line, 1U)),
               std::string(error.description()));
    }
    for (const std::string& text_of : overrides) source.overridden.push_back(override_one(tree, text_of));
    return tree;
}

}  // namespace palpate::scene
