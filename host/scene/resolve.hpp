/// A scene as text: every key, every default.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "host/scene/keys.hpp"

namespace palpate::scene {

/// All keys of `scene`; object.points as given here.
[[nodiscard]] std::string text_of(const Scene& scene, const std::string& points);
/// XXH64 of text_of with the name of the points' file alone.
[[nodiscard]] std::uint64_t hash_of(const Scene& scene);
/// A key's value as TOML; empty when there is nothing to write. Instantiated for Scene, Change, PathPoint and
/// Hand.
template <class Owner>
[[nodiscard]] std::string value_text(const Key<Owner>& key, const Owner& owner);
/// As a TOML string.
[[nodiscard]] std::string toml_string(const std::string& text);
/// The whole of `text` as a finite number; nullopt when it is something else.
[[nodiscard]] std::optional<double> number_from(std::string_view text);

}  // namespace palpate::scene
