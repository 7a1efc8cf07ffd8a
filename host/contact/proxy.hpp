/// Contact following with a spherical proxy (Sreeni and Chaudhuri, Haptics Symposium 2012): the proxy goes to
/// the tool until points of the scan enter it; their radial overshoot gives the normal that keeps it on the
/// surface.
#pragma once
#include <Eigen/Core>
#include <optional>

#include "host/cloud/neighbours.hpp"

namespace palpate::contact {

struct Contact {
    Eigen::Vector3d proxy_m;  ///< centre of the proxy; the tool itself while nothing is touched
    Eigen::Vector3d normal;   ///< unit, from the overshoot; away from the object
    cloud::Index nearest;     ///< cloud point next to the proxy on the side that is touched
    bool touching;            ///< the normal and the way to the tool disagree: (v_n . v_h) < 0
};

/// The proxy rests a radius above the points. Overshoot is counted in a sphere a quarter larger, so that a
/// resting proxy has points inside it: 17 of them where the spacing is a third of the radius. Only points
/// whose normal faces the proxy count, so that a wall of no thickness at all has two sides.
class Proxy {
public:
    /// Borrowed; must outlive the proxy. `radius_m` is the tool's. The cloud needs normals.
    Proxy(const cloud::Cloud& cloud, const cloud::Tree& tree, const cloud::Graph& graph, double radius_m);
    /// Follows the tool centre to `tool_m`; bounded number of steps (a proxy left behind goes on at the next
    /// call). nullopt while nothing is within twice the radius. Once it touched one side it stays on that
    /// side until it is free again. A first tool position inside the object is put out through the nearest
    /// point.
    [[nodiscard]] std::optional<Contact> follow(const Eigen::Vector3d& tool_m);
    void reset();

private:
    /// What the proxy feels at a place.
    struct Touch {
        Eigen::Vector3d normal;  ///< unit
        cloud::Index nearest;    ///< of the points that face the place
        double height_m;         ///< distance to it
    };
    [[nodiscard]] std::optional<Touch> feel(const Eigen::Vector3d& centre_m) const;
    [[nodiscard]] Eigen::Vector3d start(const Eigen::Vector3d& tool_m) const;
    [[nodiscard]] Eigen::Vector3d free_move(const Eigen::Vector3d& way_m) const;
    [[nodiscard]] cloud::Index walk(const Eigen::Vector3d& to_m, cloud::Index from) const;
    [[nodiscard]] Contact contact_at(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& tool_m,
                                     const std::optional<Touch>& touch) const;

    const cloud::Cloud* cloud_;
    const cloud::Tree* tree_;
    const cloud::Graph* graph_;
    double radius_m_;
    std::optional<Contact>
        last_;  ///< also while free and far: the sweep to the next tool position begins there
};

}  // namespace palpate::contact
