/// Plates of every kind, from a seed.
#pragma once
#include <string>
#include <vector>

#include "host/plate/compliance.hpp"
#include "host/plate/field.hpp"

namespace palpate::plate::fields {

enum class Kind { smooth, jump, nodule, random, island, hole };
inline constexpr int N_KINDS = 6;

struct RandomCase {
    std::string words;  ///< enough to see what it is
    Kind kind;
    double contrast;
    Sheet sheet;
    Nodes nodes;  ///< 4 m + 1, at most 33 along either axis
    Load load;    ///< a point, where there is plate
};

/// The case of a seed: the kinds in turn, contrast log-uniform 1..1e6, nu -0.9..0.49, sides 1:1 to 1:10,
/// edges and foundations of all kinds.
[[nodiscard]] RandomCase random_case(std::uint64_t seed);

}  // namespace palpate::plate::fields
