/// Follows the tool over the object and says when the loop needs a new table, and which.
#pragma once
#include <memory>

#include "common/tick.h"
#include "host/contact/proxy.hpp"
#include "host/scene/world.hpp"
#include "host/table/builder.hpp"

namespace palpate::table {

/// Node count, spacing and the rest for a scene: a table 9.6 of the scan's spacings wide, with
/// solver.table_nodes along each side; where that is 0, with 17 for a tolerance of 1e-3 and more for less.
[[nodiscard]] BuildOptions build_options(const scene::World& world);

/// The scan points that the scene's path can reach: what to bake.
[[nodiscard]] std::vector<cloud::Index> reachable_points(const scene::World& world,
                                                         const StiffnessField& field,
                                                         const BuildOptions& options);

/// One per run. Deterministic: its answers depend on the records alone.
class Server {
public:
    /// Borrowed; must outlive the server.
    Server(const scene::World& world, const StiffnessField& field, const BuildOptions& options);
    /// A new table to publish after `record`, or nullptr: when the tool has moved on by 1.2 spacings of the
    /// scan or a quarter of the last one's valid radius, or in or out by 0.5 mm. None before the first start
    /// ramp is over and the tool has been clear of the object once: homing may leave it inside or behind, and
    /// a skin that appears around a tool would throw it. After that in every state: the ramp after a stop
    /// needs the table of where the tool is now.
    [[nodiscard]] std::unique_ptr<pal_table> update(const pal_tick& record);
    /// The tracking of update() alone: for records of before this server, so that it goes on in the contact
    /// that an earlier one was following.
    void follow(const pal_tick& record) { (void)track(record); }
    /// Where the tool touches, as last seen.
    [[nodiscard]] const std::optional<contact::Contact>& contact() const { return contact_; }
    [[nodiscard]] std::size_t n_built() const { return n_built_; }
    [[nodiscard]] std::size_t n_refused() const {
        return n_refused_;
    }  ///< places where no table could be built

private:
    /// A place of the tool and the surface under it, once the tool is engaged.
    struct Place {
        Eigen::Vector3d tool_m;  ///< object frame
        contact::Foot foot;
    };
    [[nodiscard]] std::optional<Place> track(const pal_tick& record);
    [[nodiscard]] bool moved_on(const Eigen::Vector3d& tool_m, const contact::Foot& foot) const;

    const scene::World* world_;
    const StiffnessField* field_;
    BuildOptions options_;
    contact::Proxy proxy_;
    std::optional<contact::Contact> contact_;
    bool engaged_ = false, given_ = false;
    Eigen::Vector3d last_tool_m_ = Eigen::Vector3d::Zero();
    double last_depth_m_ = 0.0, last_serves_m_ = 0.0;  ///< the move after which the last one no longer does
    std::size_t n_built_ = 0, n_refused_ = 0;
};

}  // namespace palpate::table
