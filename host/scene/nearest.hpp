/// What somebody who mistyped a name may have meant.
#pragma once
#include <span>
#include <string>
#include <string_view>

namespace palpate::scene {

/// The dotted name among `known` with the fewest typing errors (insertions, deletions, replacements, swaps of
/// neighbours) between it and `name`; among equals one with the same parent, then the first. Only the first
/// 64 characters of `name` count. Empty when nothing is known.
[[nodiscard]] std::string nearest_among(std::string_view name, std::span<const std::string> known);

}  // namespace palpate::scene
