#include "common/table.h"

#include "common/atomic.h"
#include "common/crc32c.h"

static const uint32_t MAGIC_SWAPPED = 0x5441424CU;  // PAL_TABLE_MAGIC as the other byte order sees it

// Bounds that no sensible table comes near; they keep the arithmetic of the tick far from overflow.
static const float SPACING_MIN_M = 1.0e-5F, SPACING_MAX_M = 0.05F;
static const float PLACE_MAX_M = 1.0F;         // |component| of p0 and made_for
static const float HEIGHT_MAX_M = 0.2F;        // |s|
static const float KAPPA_MAX_PER_M = 2000.0F;  // a fitted sphere of half a millimetre
static const float DEPTH_SCALE_MAX_PER_M = 1.0e6F;
static const float PSI_MAX = 1.0e4F;
static const float AXES_TOLERANCE = 1.0e-4F;
enum { PSI_CELLS = 32, PSI_CELLS_PER_UNIT = 4 };  // depth up to eight times the thickness

enum { STAGE_BEGIN = 0, STAGE_CRC, STAGE_FINITE, STAGE_FIELDS, STAGE_END };  // of a check
enum { WORD_BYTES = 4 };

static bool within(float x, float low, float high) {
    return x >= low && x <= high;  // false for NaN
}

static bool finite(float x) {
    return within(x, -3.0e38F, 3.0e38F);
}

static float magnitude(float x) {
    return x < 0.0F ? -x : x;
}

pal_table_limits pal_table_limits_default(void) {
    const pal_table_limits limits = {
        .stiffness_max_n_per_m = 6000.0F,
        .stiffness_slope_max_n_per_m2 = 3.0e6F,
        .surface_slope_max = 4.0F,
    };
    return limits;
}

uint32_t pal_table_bytes(uint32_t n_nodes) {
    if (n_nodes < PAL_TABLE_NODES_MIN || n_nodes > PAL_TABLE_NODES_MAX) return 0;
    const uint32_t side = n_nodes + 2;
    return (uint32_t)offsetof(pal_table, coef) + 3U * side * side * (uint32_t)sizeof(float);
}

static uint32_t crc_of(const pal_table* table, uint32_t n_bytes) {
    return pal_crc32c(&table->id, n_bytes - (uint32_t)offsetof(pal_table, id));
}

void pal_table_seal(pal_table* table) {
    const uint32_t n_bytes = pal_table_bytes(table->n_nodes);
    table->magic = PAL_TABLE_MAGIC;
    table->abi = PAL_TABLE_ABI;
    table->n_bytes = n_bytes;
    table->crc32c = n_bytes == 0 ? 0 : crc_of(table, n_bytes);
}

bool pal_table_header_ok(const pal_table* table) {
    const uint32_t n_nodes = pal_atomic_load_relaxed(&table->n_nodes);
    return table->magic == PAL_TABLE_MAGIC && table->abi == PAL_TABLE_ABI && n_nodes % 2 == 1 &&
           pal_table_bytes(n_nodes) != 0 && table->n_bytes == pal_table_bytes(n_nodes) && table->id != 0 &&
           table->law <= PAL_LAW_NORMAL;
}

static uint32_t coefs_of(uint32_t n_nodes) {
    return 3U * (n_nodes + 2U) * (n_nodes + 2U);
}

static pal_err check_identity(const pal_table* table, uint32_t n_nodes) {
    if (table->magic == MAGIC_SWAPPED) return PAL_ERR_ENDIAN;
    if (table->magic != PAL_TABLE_MAGIC) return PAL_ERR_MAGIC;
    if (table->abi != PAL_TABLE_ABI) return PAL_ERR_ABI;
    const uint32_t n_bytes = pal_table_bytes(n_nodes);
    return n_bytes == 0 || n_nodes % 2 == 0 || table->n_bytes != n_bytes ? PAL_ERR_SIZE : PAL_OK;
}

static bool header_finite(const pal_table* table) {
    bool ok = finite(table->spacing_m) && finite(table->valid_radius_m) && finite(table->kappa_per_m) &&
              finite(table->error_k_relative) && finite(table->depth_scale_m);
    for (int i = 0; i < 5; ++i) ok = ok && finite(table->psi[i]);
    for (int i = 0; i < 3; ++i) ok = ok && finite(table->p0_m[i]) && finite(table->made_for_m[i]);
    for (int i = 0; i < 9; ++i) ok = ok && finite(table->axes[i]);
    return ok;
}

static bool axes_orthonormal(const float axes[9]) {
    for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) {
            float dot = 0.0F;
            for (int c = 0; c < 3; ++c) dot += axes[3 * i + c] * axes[3 * j + c];
            if (!(magnitude(dot - (i == j ? 1.0F : 0.0F)) <= AXES_TOLERANCE)) return false;
        }
    }
    return true;
}

// psi's numerator over the cell that begins at x: positive when its Bernstein coefficients there are, for
// they hold it in their hull. (Samples let a dip between two of them pass: 1 - 20 x + 95 x^2 is negative at
// 0.1.)
static bool numerator_positive(const float psi[5], float x) {
    static const float H = 1.0F / (float)PSI_CELLS_PER_UNIT;
    const float x2 = x * x;
    const float c0 = 1.0F + x * (psi[0] + x * (psi[1] + x2 * psi[2]));  // Taylor at x, in steps of H
    const float c1 = H * (psi[0] + x * (2.0F * psi[1] + 4.0F * x2 * psi[2]));
    const float c2 = H * H * (psi[1] + 6.0F * x2 * psi[2]);
    const float c3 = H * H * H * 4.0F * x * psi[2];
    const float c4 = H * H * H * H * psi[2];
    return c0 > 0.0F && c0 + 0.25F * c1 > 0.0F && c0 + 0.5F * c1 + c2 / 6.0F > 0.0F &&
           c0 + 0.75F * c1 + 0.5F * c2 + 0.25F * c3 > 0.0F && c0 + c1 + c2 + c3 + c4 > 0.0F;
}

// Denominator positive for every depth, and psi positive to eight thicknesses: the skin never pulls.
static bool depth_law_ok(const float psi[5]) {
    for (int i = 0; i < 5; ++i) {
        if (!within(psi[i], -PSI_MAX, PSI_MAX)) return false;
    }
    const float m1 = psi[3];
    const float m2 = psi[4];
    if (!(m2 >= 0.0F) || !(m1 >= 0.0F || m1 * m1 < 4.0F * m2)) return false;
    for (int i = 0; i < PSI_CELLS; ++i) {
        if (!numerator_positive(psi, (float)i / (float)PSI_CELLS_PER_UNIT)) return false;
    }
    return true;
}

static pal_err check_numbers(const pal_table* table, uint32_t n_nodes) {
    const float half_m = 0.5F * (float)(n_nodes - 1) * table->spacing_m;
    bool ok = within(table->spacing_m, SPACING_MIN_M, SPACING_MAX_M) && table->valid_radius_m > 0.0F &&
              table->valid_radius_m <= half_m * 1.000001F &&
              within(table->kappa_per_m, -KAPPA_MAX_PER_M, KAPPA_MAX_PER_M) &&
              table->error_k_relative >= 0.0F && table->depth_scale_m > 0.0F && depth_law_ok(table->psi) &&
              axes_orthonormal(table->axes);
    for (int i = 0; i < 3; ++i) {
        ok = ok && within(table->p0_m[i], -PLACE_MAX_M, PLACE_MAX_M) &&
             within(table->made_for_m[i], -PLACE_MAX_M, PLACE_MAX_M);
    }
    return ok ? PAL_OK : PAL_ERR_RANGE;
}

// What the coefficients of one plane must obey: all in [low, high], neighbours at most `step_max` apart.
typedef struct plane_limits {
    float low, high, step_max;
} plane_limits;

static plane_limits limits_of(const pal_table* table, uint32_t plane, const pal_table_limits* limits) {
    static const float SMALLEST = 1.0e-6F;  // K > 0
    const float step_m = table->spacing_m;
    if (plane == 0) return (plane_limits){-HEIGHT_MAX_M, HEIGHT_MAX_M, limits->surface_slope_max * step_m};
    if (plane == 1)
        return (plane_limits){SMALLEST, limits->stiffness_max_n_per_m,
                              limits->stiffness_slope_max_n_per_m2 * step_m};
    return (plane_limits){0.0F, DEPTH_SCALE_MAX_PER_M, DEPTH_SCALE_MAX_PER_M};
}

// `n` coefficients of row `i` from column `j` on; `at` is the first.
static bool row_ok(const float* at, uint32_t n, uint32_t i, uint32_t j, uint32_t side,
                   const plane_limits* limits) {
    for (uint32_t k = 0; k < n; ++k) {
        const float* c = at + k;
        if (!within(*c, limits->low, limits->high)) return false;
        if (i > 0 && !(magnitude(*c - *(c - side)) <= limits->step_max)) return false;
        if (j + k > 0 && !(magnitude(*c - *(c - 1)) <= limits->step_max)) return false;
    }
    return true;
}

static uint32_t least(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

static void next_stage(pal_table_checking* checking, uint32_t stage) {
    checking->stage = stage;
    checking->place = 0;
}

// Once: a broken writer in another process must not move the sizes between check and use.
static pal_err begin(pal_table_checking* checking, const pal_table* table) {
    checking->n_nodes = pal_atomic_load_relaxed(&table->n_nodes);
    checking->crc = 0;
    next_stage(checking, STAGE_CRC);
    return check_identity(table, checking->n_nodes);
}

static pal_err slice_crc(pal_table_checking* checking, const pal_table* table, uint32_t* n_left) {
    const uint32_t n_bytes = pal_table_bytes(checking->n_nodes) - (uint32_t)offsetof(pal_table, id);
    const uint32_t n = least(*n_left, n_bytes / WORD_BYTES - checking->place);
    const unsigned char* at = (const unsigned char*)&table->id + (size_t)checking->place * WORD_BYTES;
    checking->crc = pal_crc32c_more(checking->crc, at, (size_t)n * WORD_BYTES);
    checking->place += n;
    *n_left -= n;
    if (checking->place * WORD_BYTES < n_bytes) return PAL_OK;
    if (table->crc32c != checking->crc) return PAL_ERR_CRC;
    if (table->id == 0 || table->law > PAL_LAW_NORMAL) return PAL_ERR_RANGE;
    next_stage(checking, STAGE_FINITE);
    return header_finite(table) ? PAL_OK : PAL_ERR_NOT_FINITE;
}

static pal_err slice_finite(pal_table_checking* checking, const pal_table* table, uint32_t* n_left) {
    const uint32_t n_coefs = coefs_of(checking->n_nodes);
    const uint32_t n = least(*n_left, n_coefs - checking->place);
    const float* at = table->coef + checking->place;
    bool ok = true;
    for (uint32_t i = 0; i < n; ++i) ok = ok && finite(at[i]);
    checking->place += n;
    *n_left -= n;
    if (!ok) return PAL_ERR_NOT_FINITE;
    if (checking->place < n_coefs) return PAL_OK;
    next_stage(checking, STAGE_FIELDS);
    return check_numbers(table, checking->n_nodes);
}

static pal_err slice_fields(pal_table_checking* checking, const pal_table* table,
                            const pal_table_limits* limits, uint32_t* n_left) {
    const uint32_t side = checking->n_nodes + 2U;
    const uint32_t n_coefs = coefs_of(checking->n_nodes);
    while (*n_left > 0 && checking->place < n_coefs) {
        const uint32_t i = checking->place / side % side;
        const uint32_t j = checking->place % side;
        const plane_limits of_plane = limits_of(table, checking->place / (side * side), limits);
        const uint32_t n = least(*n_left, side - j);
        if (!row_ok(table->coef + checking->place, n, i, j, side, &of_plane)) return PAL_ERR_RANGE;
        checking->place += n;
        *n_left -= n;
    }
    if (checking->place == n_coefs) next_stage(checking, STAGE_END);
    return PAL_OK;
}

bool pal_table_check_slice(pal_table_checking* checking, const pal_table* table,
                           const pal_table_limits* limits, uint32_t n_words_max, pal_err* err) {
    uint32_t n_left = n_words_max > 0 ? n_words_max : 1U;
    *err = checking->stage == STAGE_BEGIN ? begin(checking, table) : PAL_OK;
    if (*err == PAL_OK && checking->stage == STAGE_CRC) *err = slice_crc(checking, table, &n_left);
    if (*err == PAL_OK && checking->stage == STAGE_FINITE) *err = slice_finite(checking, table, &n_left);
    if (*err == PAL_OK && checking->stage == STAGE_FIELDS)
        *err = slice_fields(checking, table, limits, &n_left);
    if (*err == PAL_OK && checking->stage != STAGE_END) return false;
    *checking = (pal_table_checking){.stage = STAGE_BEGIN};
    return true;
}

pal_err pal_table_check(const pal_table* table, const pal_table_limits* limits) {
    pal_table_checking checking = {.stage = STAGE_BEGIN};
    pal_err err;
    (void)pal_table_check_slice(&checking, table, limits, UINT32_MAX, &err);
    return err;
}
