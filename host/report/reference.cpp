#include "host/report/reference.hpp"

#include <Eigen/Geometry>

#include <limits>

#include "host/chart/patch.hpp"

namespace palpate::report {
namespace {

constexpr Eigen::Index NODES = 65;
constexpr double STEP_M = 1e-4;

}  // namespace

Reference::Reference(const scene::World& world) : world_(&world), surface_(world.another_surface()) {}

std::optional<Reference::Energy> Reference::energy(const Eigen::Vector3d& tool_m, cloud::Index seed) const {
    const auto foot = surface_.foot(tool_m, seed);
    if (!foot) return std::nullopt;
    const double depth_m = world_->scene.touch.tool_radius_m - foot->distance_m;
    if (!(depth_m > 0.0)) return Energy{0.0, depth_m, std::numeric_limits<double>::quiet_NaN(), *foot};
    try {
        const double k = chart::point_stiffness(surface_, *foot, world_->material, NODES).n_per_m;
        return Energy{0.5 * k * depth_m * depth_m, depth_m, k, *foot};
    } catch (const chart::NoPatch&) {
        return std::nullopt;
    }
}

std::optional<ReferenceForce> Reference::at(const Eigen::Vector3d& tool_m, cloud::Index seed) const {
    const auto here = energy(tool_m, seed);
    if (!here) return std::nullopt;
    if (!(here->depth_m > 0.0))
        return ReferenceForce{Eigen::Vector3d::Zero(), here->depth_m, here->k_n_per_m};
    const Eigen::Vector3d& n = here->foot.normal;
    const Eigen::Vector3d t1 = n.unitOrthogonal(), t2 = n.cross(t1);
    Eigen::Vector3d force = here->k_n_per_m * here->depth_m * n;
    for (const Eigen::Vector3d& t : {t1, t2}) {
        const auto ahead = energy(tool_m + STEP_M * t, here->foot.nearest);
        const auto behind = energy(tool_m - STEP_M * t, here->foot.nearest);
        if (!ahead || !behind) return std::nullopt;
        force -= (ahead->joule - behind->joule) / (2.0 * STEP_M) * t;
    }
    return ReferenceForce{force, here->depth_m, here->k_n_per_m};
}

}  // namespace palpate::report
