/// From TOML nodes to fields, by the table of keys; every refusal says where, what, and what would be right.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <toml++/toml.h>

#include "host/scene/keys.hpp"

namespace palpate::scene {

/// Of `name`, or of the nearest that it is in: "change[1].at_m", "change[1]", "change"; empty when there is
/// none.
[[nodiscard]] std::string nearest_place(const std::map<std::string, std::string>& places, std::string name);

/// Where values come from: a file's lines, or a --set.
struct Source {
    std::string file;
    std::vector<std::string> overridden;        ///< names that a --set replaced, "change[1].factor"
    std::map<std::string, std::string> places;  ///< of every value read, for later errors

    [[nodiscard]] std::string place(const std::string& name, std::uint32_t line) const;
    [[noreturn]] void fail(const std::string& name, std::uint32_t line, const std::string& words) const;
    [[noreturn]] void fail(const std::string& name, const toml::node& node, const std::string& words) const;
    /// For a name that was read, or one in a table or section that was.
    [[noreturn]] void fail(const std::string& name, const std::string& words) const;
};

/// "a string", "an integer", ...
[[nodiscard]] std::string kind(const toml::node& node);
/// A number, whole or not; nullopt for anything else.
[[nodiscard]] std::optional<double> number_in(const toml::node& node);

/// Refuses the first key of `table` (by line) that is not among `names`. `prefix` as shown ("change[1]."),
/// `plain` as in the reference ("change.").
void refuse_unknown(const Source& source, const toml::table& table, const std::string& prefix,
                    const std::string& plain, const std::vector<std::string>& names);

/// Reads one value into its field. Instantiated for Scene, Change, PathPoint and Hand.
template <class Owner>
void read_value(Source& source, const std::string& name, const toml::node& node, const Key<Owner>& key,
                Owner& owner);

/// Reads a table whose keys are all in `keys`; refuses unknown and missing ones. Instantiated likewise.
template <class Owner>
void read_table(Source& source, const std::string& name, const std::string& plain, const toml::table& table,
                std::span<const Key<Owner>> keys, Owner& owner);

/// Says that a required key is not there.
template <class Owner>
[[noreturn]] void fail_missing(const Source& source, const std::string& name, std::uint32_t line,
                               const Key<Owner>& key);

/// Parses the file's text, then puts each override ("section.key=value") in its place.
[[nodiscard]] toml::table read_tree(Source& source, std::string_view text,
                                    std::span<const std::string> overrides);

}  // namespace palpate::scene
