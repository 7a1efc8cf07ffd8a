#include "host/scene/plate_keys.hpp"

namespace palpate::scene {

#define PAL_FIELD(member)            \
    +[](PlateFile & file) -> auto& { \
        return file.member;          \
    }

std::span<const PlateKey> plate_keys() {
    static const PlateKey keys[] = {
        {.name = "plate.size_m",
         .field = PAL_FIELD(plate.size_m),
         .example = "[0.04, 0.04]",
         .otherwise = "",
         .about = "along x and along z",
         .unit = "m",
         .range = {.above = 0, .at_most = 1000}},
        {.name = "plate.poisson",
         .field = PAL_FIELD(plate.poisson),
         .example = "0.3",
         .otherwise = "",
         .about = "Poisson's ratio",
         .range = {.above = -1, .below = 0.5}},
        {.name = "plate.edges",
         .field = PAL_FIELD(plate.edges),
         .example = "\"clamped\"",
         .otherwise = "`\"clamped\"`",
         .about = "one word for all, or four: x low, x high, z low, z high",
         .choices = "clamped|supported|free"},
        {.name = "plate.nodes",
         .field = PAL_FIELD(plate.nodes),
         .example = "[65, 65]",
         .otherwise = "`[65, 65]`",
         .about = "of the finest grid, along x and along z; 4 m + 1 each, from 9, when extrapolating",
         .range = {.at_least = 5, .at_most = PLATE_NODES_MAX}},
        {.name = "plate.foundation_n_per_m3",
         .field = PAL_FIELD(plate.foundation_n_per_m3),
         .example = "1e6",
         .otherwise = "`0.0`",
         .about = "pressure back per deflection, of what lies under the plate",
         .unit = "N/m3",
         .range = {.at_least = 0, .at_most = 1e15}},
        {.name = "plate.thickness_m",
         .field = PAL_FIELD(plate.thickness_m),
         .example = "0.001",
         .otherwise = "none",
         .about = "needed with curvature_per_m only",
         .unit = "m",
         .range = {.above = 0, .at_most = 1000}},
        {.name = "plate.curvature_per_m",
         .field = PAL_FIELD(plate.curvature_per_m),
         .example = "[20.0, 20.0]",
         .otherwise = "`[0.0, 0.0]`",
         .about = "of a shallow shell, along x and along z; its stretching counts as a foundation",
         .unit = "1/m",
         .range = {.at_least = -1e6, .at_most = 1e6}},
        {.name = "rigidity.value_n_m",
         .field = PAL_FIELD(rigidity.value_n_m),
         .example = "0.03",
         .otherwise = "in `file`",
         .about = "flexural rigidity D = E h^3 / (12 (1 - poisson^2)), the same everywhere",
         .unit = "N m",
         .range = {.above = 0, .at_most = 1e15}},
        {.name = "rigidity.file",
         .field = PAL_FIELD(rigidity.file),
         .example = "\"rigidity.csv\"",
         .otherwise = "`value_n_m`",
         .about =
             "D in N m, .csv or .npy of any resolution, corner to corner: row i is x_i, column j is z_j; "
             "relative to this file"},
        {.name = "rigidity.sampling",
         .field = PAL_FIELD(rigidity.sampling),
         .example = "\"linear\"",
         .otherwise = "`\"linear\"`",
         .about = "between the places of the file",
         .choices = "linear|nearest"},
        {.name = "load.at_m",
         .field = PAL_FIELD(load.at_m),
         .example = "[0.02, 0.02]",
         .otherwise = "the middle",
         .about = "(x, z) from the corner",
         .unit = "m",
         .range = {.at_least = 0, .at_most = 1000}},
        {.name = "load.force_n",
         .field = PAL_FIELD(load.force_n),
         .example = "1.0",
         .otherwise = "`1.0`",
         .about = "for deflections; the compliance does not depend on it",
         .unit = "N",
         .range = {.above = 0, .at_most = 1e9}},
        {.name = "load.radius_m",
         .field = PAL_FIELD(load.radius_m),
         .example = "0.002",
         .otherwise = "`0.0`",
         .about = "of the disc that the force is spread over evenly; 0: a point",
         .unit = "m",
         .range = {.at_least = 0, .at_most = 1000}},
        {.name = "solver.method",
         .field = PAL_FIELD(solver.method),
         .example = "\"auto\"",
         .otherwise = "`\"auto\"`",
         .about = "auto says which it took and why",
         .choices = "auto|cholesky|multigrid|closed-form|bounds|eigen|jacobi|damped-jacobi|eq7"},
        {.name = "solver.tolerance",
         .field = PAL_FIELD(solver.tolerance),
         .example = "1e-3",
         .otherwise = "`1e-3`",
         .about = "of the compliance, relative; what is reached is told as estimated_relative_error",
         .range = {.above = 0, .at_most = 1}},
        {.name = "solver.extrapolate",
         .field = PAL_FIELD(solver.extrapolate),
         .example = "true",
         .otherwise = "`true`",
         .about = "from this grid and coarser ones to the continuum"},
        {.name = "output.points_m",
         .field = PAL_FIELD(output.points_m),
         .example = "[[0.01, 0.02], [0.03, 0.02]]",
         .otherwise = "`[]`",
         .about = "places whose deflection is told",
         .unit = "m",
         .range = {.at_least = 0, .at_most = 1000}},
        {.name = "output.field",
         .field = PAL_FIELD(output.field),
         .example = "\"w.csv\"",
         .otherwise = "none",
         .about = "deflection in m at nodes, .csv or .npy, in the order of `rigidity.file`"},
        {.name = "output.plot",
         .field = PAL_FIELD(output.plot),
         .example = "\"w.png\"",
         .otherwise = "none",
         .about = "deflection as a map with contours, .png, by gnuplot"},
    };
    return keys;
}

#undef PAL_FIELD

std::vector<std::string> plate_sections() {
    std::vector<std::string> out;
    for (const PlateKey& key : plate_keys()) {
        std::string section = split(key.name, '.')[0];
        if (out.empty() || out.back() != section) out.push_back(std::move(section));
    }
    return out;
}

}  // namespace palpate::scene
