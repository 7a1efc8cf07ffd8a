/// The local stiffness-response table: a potential U(x) near one contact point, as cubic B-spline
/// coefficients. Mathematics: docs/MATH.md §1. Layout and checks: docs/PROTOCOL.md §2.
#pragma once
#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/err.h"
#ifdef __cplusplus
extern "C" {
#endif

enum {
    PAL_TABLE_MAGIC = 0x4C424154,  // "TABL"
    PAL_TABLE_ABI = 1,
    PAL_TABLE_NODES_MIN = 5,
    PAL_TABLE_NODES_MAX = 65,
    PAL_TABLE_SIDE_MAX = PAL_TABLE_NODES_MAX + 2,  ///< one ring of coefficients outside the nodes
    PAL_TABLE_COEFS_MAX = 3 * PAL_TABLE_SIDE_MAX * PAL_TABLE_SIDE_MAX
};

typedef enum pal_law {
    PAL_LAW_POTENTIAL = 0,  ///< F = -grad U: the default, conserves energy
    PAL_LAW_NORMAL = 1      ///< the paper's direction: no lateral term, creates energy where k varies
} pal_law;

/// Contact frame: origin p0 on the surface that the tool centre meets, e3 away from the object. For a tool
/// centre x in that frame: q = 1 + kappa x3, (u, v) = (x1, x2)/q, f = s(u, v) - height(x), U = K f^2 psi(H
/// f)/2 for f > 0.
typedef struct pal_table {
    uint32_t magic;        ///< PAL_TABLE_MAGIC
    uint32_t abi;          ///< PAL_TABLE_ABI
    uint32_t n_bytes;      ///< bytes in use: header and 3 (n_nodes + 2)^2 coefficients
    uint32_t crc32c;       ///< of the bytes from `id` to n_bytes
    uint64_t id;           ///< 1, 2, 3, ... in the order of publication; never 0
    uint64_t source_hash;  ///< XXH64 of the object, its material and the settings the table was made from
    uint32_t tick;         ///< tick of the record that it was made for
    uint32_t law;          ///< a pal_law
    uint32_t n_nodes;      ///< nodes along u and along v, PAL_TABLE_NODES_MIN..MAX, odd
    float spacing_m;       ///< between nodes in u and v; node (i, j) is at ((i, j) - (n_nodes - 1)/2) spacing
    float valid_radius_m;  ///< the table answers while sqrt(u^2 + v^2) is within this
    float kappa_per_m;     ///< signed curvature of the fitted sphere, convex > 0; never its radius
    float error_k_relative;  ///< estimated relative error of k
    float depth_scale_m;     ///< thickness h of the skin; H = g/h
    float psi[5];            ///< depth law (1 + n1 x + n2 x^2 + n4 x^4)/(1 + m1 x + m2 x^2): n1 n2 n4 m1 m2
    float p0_m[3];           ///< workspace frame
    float made_for_m[3];     ///< tool centre that it was made for, workspace frame
    float axes[9];           ///< e1, e2, e3 as rows, orthonormal, in the workspace frame
    float reserved[3];
    /// Three planes s [m], K [N/m], H [1/m] of (n_nodes + 2)^2 coefficients each, u slowest:
    /// coef[plane * side * side + (i + 1) * side + (j + 1)], side = n_nodes + 2, belongs to node (i, j).
    float coef[PAL_TABLE_COEFS_MAX];
} pal_table;

static_assert(offsetof(pal_table, magic) == 0, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, abi) == 4, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, n_bytes) == 8, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, crc32c) == 12, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, id) == 16, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, source_hash) == 24, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, tick) == 32, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, law) == 36, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, n_nodes) == 40, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, spacing_m) == 44, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, valid_radius_m) == 48, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, kappa_per_m) == 52, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, error_k_relative) == 56, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, depth_scale_m) == 60, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, psi) == 64, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, p0_m) == 84, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, made_for_m) == 96, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, axes) == 108, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, reserved) == 144, "PROTOCOL.md 2");
static_assert(offsetof(pal_table, coef) == 156, "PROTOCOL.md 2");
static_assert(sizeof(pal_table) == 54024, "PROTOCOL.md 2");

/// What a table may ask of a device. The convex hull of a B-spline's coefficients bounds the field
/// everywhere, so these hold for every point of a checked table, not just for its nodes.
typedef struct pal_table_limits {
    float stiffness_max_n_per_m;         ///< every K coefficient lies in (0, this]
    float stiffness_slope_max_n_per_m2;  ///< |difference of neighbouring K coefficients| / spacing
    float surface_slope_max;             ///< |difference of neighbouring s coefficients| / spacing
} pal_table_limits;

/// What the loop accepts: up to 6 kN/m and 3 (N/m)/um of stiffness gradient, surfaces up to 76 degrees steep.
pal_table_limits pal_table_limits_default(void);
/// Bytes in use by a table of n_nodes; 0 when n_nodes is out of range.
uint32_t pal_table_bytes(uint32_t n_nodes);
/// Fills magic, abi, n_bytes and crc32c. The last thing its writer does.
void pal_table_seal(pal_table* table);
/// Everything that makes a table safe to use: header, CRC, finite, ranges, orthonormal axes, limits. Reads
/// `n_nodes` once. Cost: about 0.8 ns a byte, half of it the CRC (tests/bench, "arrival/whole check"): 40 us
/// for the largest table, so never in the tick.
pal_err pal_table_check(const pal_table* table, const pal_table_limits* limits);

/// How far a check in slices has come. Zero-initialise; zero again when it has ended.
typedef struct pal_table_checking {
    uint32_t stage;
    uint32_t n_nodes;  ///< as read once, at the start
    uint32_t place;    ///< next word of this stage
    uint32_t crc;      ///< of the words before it
} pal_table_checking;

/// pal_table_check in slices, where there is no second thread to run it in: looks at up to `n_words_max` (at
/// least 1) words of the table, a word once in each of its three passes (the third looks back at two
/// neighbours), and at the header. True when it has ended, *err then being what pal_table_check gives; false:
/// *err is PAL_OK so far. A table of c coefficients takes 3 c + 35 words. One that is rewritten between two
/// slices may be passed though no moment's bytes were good: no worse than one that is rewritten after its
/// check, which the tick's own copy and clamp answer (docs/PROTOCOL.md §2).
bool pal_table_check_slice(pal_table_checking* checking, const pal_table* table,
                           const pal_table_limits* limits, uint32_t n_words_max, pal_err* err);
/// Header only, for the tick: magic, abi, sizes in range. A table that passed pal_table_check passes.
bool pal_table_header_ok(const pal_table* table);

#ifdef __cplusplus
}
#endif
