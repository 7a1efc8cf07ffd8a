/// The plate that the skin around one point forms, and how stiff the point is.
#pragma once
#include <Eigen/Core>
#include <stdexcept>
#include <vector>

#include "host/chart/chart.hpp"
#include "host/contact/surface.hpp"
#include "host/plate/plate.hpp"

namespace palpate::chart {

/// What the skin is made of, besides Young's modulus at the points, and how a patch is cut from it.
struct Material {
    double thickness_m = 0.0015;
    double poisson = 0.45;
    double foundation_n_per_m3 = 0.0;  ///< what lies under the skin (Winkler)
    bool shell = true;                 ///< k_f = E h max(kappa1 kappa2, 0) on top
    double patch_size_m = 0.016;
    Projection projection = Projection::azimuthal;
    double spacing_m = 0.001;  ///< between the scan's points, median
    double tolerance = 1e-3;   ///< of the point stiffness, relative
};

/// A place that has no plate: too little skin around it, or a plate that no guard can vouch for.
struct NoPatch : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A scan point near a patch, in plate coordinates about the contact.
struct PlatePoint {
    cloud::Index point;
    Eigen::Vector2d at_m;
};

struct Patch {
    Frame frame;             ///< origin at the contact, e3 from the fitted sphere's centre
    plate::Problem problem;  ///< centred on the contact
    std::vector<PlatePoint> points;
    double covered;       ///< share of the nodes that have skin
    double gauss_per_m2;  ///< kappa1 kappa2
    bool saddle;          ///< clearly gauss < 0: no local foundation exists, the edge decides (MATH.md)
};

/// The square patch around `foot`, `nodes` along each side (4 m + 1). Neighbourhood grown along the surface,
/// weighted Pratt fit, chart, E interpolated to the nodes; nodes without skin are a free edge (D = 1e-6 Dmax,
/// k_f = 0). Throws NoPatch when less than half is covered or the scan is too sparse for it. About 0.4 ms.
[[nodiscard]] Patch cut_patch(const contact::Surface& surface, const contact::Foot& foot,
                              const Material& material, Eigen::Index nodes);

struct Stiffness {
    double n_per_m;         ///< 1 / centre compliance under a point load
    double relative_error;  ///< estimated, of the plate's solution
    double covered;
    bool saddle;
};

/// The stiffness felt at `foot` on the coarsest of 33, 65 and 129 nodes whose estimated error meets the
/// material's tolerance; on 129 when none does. Throws NoPatch.
[[nodiscard]] Stiffness point_stiffness(const contact::Surface& surface, const contact::Foot& foot,
                                        const Material& material);
/// Cut, solve, extrapolate: the stiffness felt at `foot` for small depths. `nodes` on the finer of the two
/// grids. Throws NoPatch.
[[nodiscard]] Stiffness point_stiffness(const contact::Surface& surface, const contact::Foot& foot,
                                        const Material& material, Eigen::Index nodes);

/// How far each scan point near `foot` moves along the inward normal under `force_n` there (paper eq. 9: P' =
/// P + w n). Throws NoPatch.
struct Displaced {
    cloud::Index point;
    Eigen::Vector3d by_m;
};
[[nodiscard]] std::vector<Displaced> dip(const contact::Surface& surface, const contact::Foot& foot,
                                         const Material& material, double force_n, Eigen::Index nodes = 33);

}  // namespace palpate::chart
