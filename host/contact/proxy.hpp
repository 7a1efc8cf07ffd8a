/// Contact following with a spherical proxy (Sreeni and Chaudhuri, Haptics Symposium 2012): the proxy goes to the tool
/// until points of the scan enter it; their radial overshoot gives the normal that keeps it on the surface.
#pragma once
#include <Eigen/Core>
#include <optional>

#include "host/cloud/neighbours.hpp"

namespace palpate::contact {

struct Contact {
    Eigen::Vector3d proxy_m;   ///< centre of the proxy
    Eigen::Vector3d normal;    ///< unit, from the overshoot; away from the object
    cloud::Index nearest;      ///< cloud point next to the proxy on the side that is touched
    bool touching;             ///< the normal and the way to the tool disagree: (v_n . v_h) < 0
};

class Proxy {
public:
    /// Borrowed; must outlive the proxy. `radius_m` is the tool's.
    Proxy(const cloud::Cloud& cloud, const cloud::Tree& tree, const cloud::Graph& graph, double radius_m);
    /// Follows the tool centre to `tool_m`; bounded number of steps. nullopt while nothing is within twice the radius.
    /// Once it touched one side it stays on that side until it is free again.
    [[nodiscard]] std::optional<Contact> follow(const Eigen::Vector3d& tool_m);
    void reset();

private:
    const cloud::Cloud* cloud_;
    const cloud::Tree* tree_;
    const cloud::Graph* graph_;
    double radius_m_;
    std::optional<Contact> last_;
};

}  // namespace palpate::contact
