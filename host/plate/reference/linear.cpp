#include "host/plate/reference/linear.hpp"

#include "host/plate/reference/bending.hpp"

namespace palpate::reference {

Answer solve(const Plate& plate) {
    const Grid grid(plate);
    LeastSquares energy(grid.nodes());
    add_bending(energy, grid);
    const Unknown contact = grid.deflection(plate.contact_ix, plate.contact_iz);
    energy.values()[contact] = 1.0;
    const Minimum minimum = energy.minimise(contact);
    const double stiffness = 2.0 * minimum.energy * grid.rigidity_max_n_m / plate.size_x_m / plate.size_x_m;
    return {stiffness * plate.depth_m, 1.0 / stiffness, minimum.iterations};
}

}  // namespace palpate::reference
