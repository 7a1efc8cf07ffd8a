/// Tables that are broken in one way each, and what the check calls it.
#pragma once
#include <functional>
#include <limits>
#include <vector>

#include "common/err.h"
#include "tests/common/tables.hpp"

namespace tables {

/// One thing that is wrong with tables::make().
struct Broken {
    const char* how;
    pal_err err;
    bool sealed;  // sealed again afterwards, so that only the number itself is wrong
    std::function<void(pal_table&)> breaking;
};

inline constexpr std::uint32_t SIDE = 35, PLANE = SIDE * SIDE;

inline std::vector<Broken> broken_tables() {
    return {
        {"magic", PAL_ERR_MAGIC, false, [](pal_table& t) { t.magic ^= 1U; }},
        {"byte order", PAL_ERR_ENDIAN, false, [](pal_table& t) { t.magic = 0x5441424CU; }},
        {"abi", PAL_ERR_ABI, false, [](pal_table& t) { t.abi = 2; }},
        {"too few nodes", PAL_ERR_SIZE, true, [](pal_table& t) { t.n_nodes = 3; }},
        {"even nodes", PAL_ERR_SIZE, true, [](pal_table& t) { t.n_nodes = 32; }},
        {"too many nodes", PAL_ERR_SIZE, true, [](pal_table& t) { t.n_nodes = 67; }},
        {"huge nodes", PAL_ERR_SIZE, false, [](pal_table& t) { t.n_nodes = 0x80000000U; }},
        {"n_bytes", PAL_ERR_SIZE, false, [](pal_table& t) { t.n_bytes += 4; }},
        {"crc", PAL_ERR_CRC, false, [](pal_table& t) { t.crc32c ^= 1U; }},
        {"a flipped bit", PAL_ERR_CRC, false, [](pal_table& t) { t.coef[7] += 1.0e-6F; }},
        {"id", PAL_ERR_RANGE, true, [](pal_table& t) { t.id = 0; }},
        {"law", PAL_ERR_RANGE, true, [](pal_table& t) { t.law = 2; }},
        {"no spacing", PAL_ERR_RANGE, true, [](pal_table& t) { t.spacing_m = 0.0F; }},
        {"negative spacing", PAL_ERR_RANGE, true, [](pal_table& t) { t.spacing_m = -1.0e-3F; }},
        {"valid beyond the nodes", PAL_ERR_RANGE, true, [](pal_table& t) { t.valid_radius_m = 0.0101F; }},
        {"no valid radius", PAL_ERR_RANGE, true, [](pal_table& t) { t.valid_radius_m = 0.0F; }},
        {"curvature", PAL_ERR_RANGE, true, [](pal_table& t) { t.kappa_per_m = 1.0e5F; }},
        {"error below zero", PAL_ERR_RANGE, true, [](pal_table& t) { t.error_k_relative = -0.1F; }},
        {"no depth scale", PAL_ERR_RANGE, true, [](pal_table& t) { t.depth_scale_m = 0.0F; }},
        {"psi with a pole", PAL_ERR_RANGE, true, [](pal_table& t) { t.psi[3] = -0.5F; }},
        {"psi with a pole far out", PAL_ERR_RANGE, true, [](pal_table& t) { t.psi[4] = -1.0e-3F; }},
        {"psi that pulls", PAL_ERR_RANGE, true, [](pal_table& t) { t.psi[0] = -0.5F; }},
        {"psi that pulls at 0.1 only", PAL_ERR_RANGE, true,
         [](pal_table& t) {
             t.psi[0] = -20.0F;
             t.psi[1] = 95.0F;
         }},
        {"place", PAL_ERR_RANGE, true, [](pal_table& t) { t.p0_m[1] = 5.0F; }},
        {"stretched axis", PAL_ERR_RANGE, true, [](pal_table& t) { t.axes[0] = 1.01F; }},
        {"skew axes", PAL_ERR_RANGE, true, [](pal_table& t) { t.axes[1] = 0.01F; }},
        {"no stiffness", PAL_ERR_RANGE, true, [](pal_table& t) { t.coef[PLANE + 40] = 0.0F; }},
        {"negative stiffness", PAL_ERR_RANGE, true, [](pal_table& t) { t.coef[PLANE + 40] = -1.0F; }},
        {"too stiff", PAL_ERR_RANGE, true, [](pal_table& t) { t.coef[2 * PLANE - 1] = 6001.0F; }},
        {"stiffness jumps", PAL_ERR_RANGE, true, [](pal_table& t) { t.coef[PLANE + 40] = 3000.0F; }},
        {"surface jumps", PAL_ERR_RANGE, true, [](pal_table& t) { t.coef[40] = 3.0e-3F; }},
        {"surface far away", PAL_ERR_RANGE, true,
         [](pal_table& t) {
             for (std::uint32_t i = 0; i < PLANE; ++i) t.coef[i] = 0.5F;
         }},
        {"stiffness that is no number at the end of its plane", PAL_ERR_NOT_FINITE, true,
         [](pal_table& t) { t.coef[2 * PLANE - 1] = std::numeric_limits<float>::quiet_NaN(); }},
        {"the last number of all infinite", PAL_ERR_NOT_FINITE, true,
         [](pal_table& t) { t.coef[3 * PLANE - 1] = std::numeric_limits<float>::infinity(); }},
        {"axis that is no number", PAL_ERR_NOT_FINITE, true,
         [](pal_table& t) { t.axes[8] = std::numeric_limits<float>::quiet_NaN(); }},
        {"negative depth scale at the end", PAL_ERR_RANGE, true,
         [](pal_table& t) { t.coef[3 * PLANE - 1] = -1.0F; }},
        {"negative depth scale", PAL_ERR_RANGE, true, [](pal_table& t) { t.coef[2 * PLANE + 3] = -1.0F; }},
    };
}

}  // namespace tables
