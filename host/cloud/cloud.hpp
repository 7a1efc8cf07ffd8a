/// A scanned object as points, with what is known at each of them.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace palpate::cloud {

using Index = std::uint32_t;  ///< of a point

struct Cloud {
    std::vector<Eigen::Vector3d> points_m;
    std::vector<Eigen::Vector3d> normals;         ///< unit, away from the object; empty until orient() ran
    std::vector<std::array<Index, 3>> triangles;  ///< as in the file; empty for a bare cloud
    std::vector<double> young_pa;                 ///< empty until the scene gave it
    std::size_t n_duplicates = 0;                 ///< points dropped because they repeat an earlier one
};

/// Bad input, worded `file:line: what, and what would be right`.
struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Reads OBJ or PLY (ascii, binary little and big endian), by extension. Coordinates in the file's own unit;
/// faces of more than three corners become fans. Exact repeats of a point are merged. Throws Error: missing,
/// empty or truncated file, a vertex that is not finite, an index out of range, fewer than 3 points. O(n log
/// n); nothing is allocated by a count that the file's size cannot hold.
[[nodiscard]] Cloud read(const std::filesystem::path& file);

}  // namespace palpate::cloud
