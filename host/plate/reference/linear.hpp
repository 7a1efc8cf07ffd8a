/// The clamped plate as a least-squares problem for Ceres: shares no code with the plate that the renderer
/// uses.
#pragma once
#include <cstddef>
#include <vector>

namespace palpate::reference {

/// Fields by node, z fastest, edge nodes included.
struct Plate {
    double size_x_m = 0.0;
    double size_z_m = 0.0;
    std::size_t nx = 0;
    std::size_t nz = 0;
    double poisson = 0.2;
    std::vector<double> rigidity_n_m;
    std::vector<double> foundation_n_per_m3;  ///< empty: none
    std::size_t contact_ix = 0;
    std::size_t contact_iz = 0;
    double depth_m = 1e-3;  ///< at which the contact node is held
};

struct Answer {
    double reaction_n;
    double compliance_m_per_n;
    int iterations;
};

/// Minimises the energy with the contact node held at the depth; reaction = 2 energy/depth (MATH.md eq. 11).
/// Throws std::runtime_error when Ceres finds no solution.
[[nodiscard]] Answer solve(const Plate& plate);

}  // namespace palpate::reference
