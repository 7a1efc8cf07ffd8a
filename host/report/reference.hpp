/// The force that should have been: straight from the cloud, without table, cache or link.
#pragma once
#include <Eigen/Core>
#include <optional>

#include "host/contact/surface.hpp"
#include "host/scene/world.hpp"

namespace palpate::report {

struct ReferenceForce {
    Eigen::Vector3d force_n;  ///< on the hand; zero without contact
    double depth_m;           ///< of the tool's lowest point below the skin
    double k_n_per_m;         ///< NaN without contact
};

/// Minus the gradient of U(x) = k(foot of x) d(x)^2 / 2, with the stiffness k of a patch cut and solved anew
/// (33 and 65 nodes, extrapolated) centred at the foot of each place asked for. Across the skin dU/dn = -k d
/// exactly (the foot stays); along it central differences of U over 0.2 mm, second order. Five solves, about
/// 50 ms.
class Reference {
public:
    explicit Reference(const scene::World& world);
    /// nullopt where the skin has no foot or no plate: such a place has no reference.
    [[nodiscard]] std::optional<ReferenceForce> at(const Eigen::Vector3d& tool_m, cloud::Index seed) const;

private:
    struct Energy {
        double joule, depth_m, k_n_per_m;
        contact::Foot foot;
    };
    [[nodiscard]] std::optional<Energy> energy(const Eigen::Vector3d& tool_m, cloud::Index seed) const;

    const scene::World* world_;
    contact::Surface surface_;
};

}  // namespace palpate::report
