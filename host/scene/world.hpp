/// A scene made concrete: the object in the workspace frame with a stiffness at every point, and the hand's
/// path.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/chart/patch.hpp"
#include "host/cloud/cloud.hpp"
#include "host/cloud/neighbours.hpp"
#include "host/contact/surface.hpp"
#include "host/scene/scene.hpp"

namespace palpate::scene {

/// Where the hand wants the tool centre to be.
struct Target {
    double t_s;
    Eigen::Vector3d tool_m;  ///< in the hand's workspace
    contact::Foot foot;      ///< of the place on the skin
};

/// Object metres (scaled, object's axes) to workspace metres: x -> turn x + shift_m.
struct Pose {
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
    [[nodiscard]] Eigen::Vector3d operator()(const Eigen::Vector3d& at_m) const {
        return turn * at_m + shift_m;
    }
};

/// A stiff or soft spot, as placed.
struct Nodule {
    Eigen::Vector3d at_m;  ///< on the scan, workspace frame
    double radius_m;
};

struct World {
    Scene scene;
    cloud::Cloud cloud;  ///< workspace frame; normals and young_pa filled
    std::unique_ptr<cloud::Tree> tree;
    std::unique_ptr<cloud::Graph> graph;
    std::unique_ptr<contact::Surface> surface;
    double spacing_m = 0.0;        ///< median, between points
    std::size_t n_other_side = 0;  ///< points of the scan left out by object.sides = "outer"
    Pose pose;
    std::vector<Nodule> nodules;
    std::vector<Target> path;  ///< every 10 ms
    chart::Material material;
    std::string object_name;        ///< the points file's name
    std::uint64_t object_hash = 0;  ///< XXH64 of the points as read
    std::uint64_t source_hash = 0;  ///< XXH64 of points, young_pa, skin, patch, solver, touch and scales

    /// Where a tool centre of the hand's workspace is on the object, m: the hand's metres times
    /// placement.position_scale.
    [[nodiscard]] Eigen::Vector3d on_object(const Eigen::Vector3d& hand_m) const {
        return scene.placement.position_scale * hand_m;
    }
    /// The smooth skin for another thread: same cloud and graph, caches of its own.
    [[nodiscard]] contact::Surface another_surface() const;
};

/// Reads the object, scales, places, applies the changes, resolves the path. Throws scene::Error or
/// cloud::Error (words for a person) for anything that cannot be: object too small for the patch, path beyond
/// the workspace, ...
[[nodiscard]] std::unique_ptr<World> build(const Scene& scene);

/// Likewise from a cloud in object metres that needs no file (tests, generated objects).
[[nodiscard]] std::unique_ptr<World> build(const Scene& scene, cloud::Cloud cloud);

/// XXH64 of all that a table of this world depends on: points, moduli, skin, patch, solver, touch and scales.
/// A difference of one ulp in one number is another source.
[[nodiscard]] std::uint64_t source_hash_of(const World& world);

}  // namespace palpate::scene
