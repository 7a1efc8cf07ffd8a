/// The frames that other programs, devices and scans use, and the way from each to the workspace frame. One
/// table; docs/FRAMES.md says the same in words, and a test holds the two together.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace palpate::scene {

/// A right-handed frame in metres. A direction or a force v in it is turn v in the workspace frame, a place
/// is turn at_m + origin_m.
struct Convention {
    std::string_view name;
    Eigen::Matrix3d turn;      ///< entries 0, 1 and -1 only: exact
    Eigen::Vector3d origin_m;  ///< of this frame, in the workspace frame; zero for object axes
    bool is_object_axes;       ///< a value of object.axes: turns a file into the object's axes, moves nothing
};

[[nodiscard]] std::span<const Convention> conventions();
/// Throws std::out_of_range with the name for a convention that does not exist.
[[nodiscard]] const Convention& convention(std::string_view name);

[[nodiscard]] Eigen::Vector3d to_workspace_m(const Convention& from, const Eigen::Vector3d& at_m);
[[nodiscard]] Eigen::Vector3d from_workspace_m(const Convention& to, const Eigen::Vector3d& at_m);

/// What a scan says about its own axes, "SPACE=LPS" in a comment of a PLY or OBJ header; empty when it says
/// nothing. A file that cannot be read says nothing.
struct SpaceComment {
    std::string space;
    std::size_t line = 0;
};
[[nodiscard]] SpaceComment space_comment(const std::filesystem::path& points);

}  // namespace palpate::scene
