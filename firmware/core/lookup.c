#include "firmware/core/lookup.h"

#include <math.h>

#include "common/atomic.h"

// What a look-up uses of a table besides its coefficients, copied once: the table lies in memory that another
// process may write, and what was checked must be what is used.
typedef struct header {
    uint32_t law, n_nodes;
    float spacing_m, valid_radius_m, kappa_per_m, error_k_relative, depth_scale_m;
    float psi[5], p0_m[3], made_for_m[3], axes[9];
} header;

// One run of bytes, so that one copy is all: the same order as in pal_table.
static_assert(sizeof(header) == offsetof(pal_table, reserved) - offsetof(pal_table, law), "as in pal_table");
static_assert(offsetof(header, n_nodes) == offsetof(pal_table, n_nodes) - offsetof(pal_table, law), "");
static_assert(offsetof(header, spacing_m) == offsetof(pal_table, spacing_m) - offsetof(pal_table, law), "");
static_assert(offsetof(header, kappa_per_m) == offsetof(pal_table, kappa_per_m) - offsetof(pal_table, law),
              "");
static_assert(offsetof(header, psi) == offsetof(pal_table, psi) - offsetof(pal_table, law), "");
static_assert(offsetof(header, axes) == offsetof(pal_table, axes) - offsetof(pal_table, law), "");

static const float Q_MIN = 0.2F;  // nearer to the sphere's centre, or past it, the chart has no meaning

// Four taps along one direction: weights of the value and of its derivative.
typedef struct taps {
    uint32_t first;
    float value[4], slope[4];
} taps;

// Value and derivatives along u and v of one field.
typedef struct field {
    float value, u, v;
} field;

// Chart and distance to the fitted sphere at the tool (MATH.md 1).
typedef struct chart {
    float u, v;
    float grad_u[3], grad_v[3], grad_height[3];
    float height;
} chart;

// Cubic B-spline between nodes i and i + 1; the ring of coefficients makes i the first tap.
static void taps_at(float along_nodes, float per_spacing, uint32_t n_nodes, taps* out) {
    const float last = (float)(n_nodes - 2);
    const float place = along_nodes > 0.0F ? along_nodes : 0.0F;
    const uint32_t cell = place < last ? (uint32_t)place : n_nodes - 2;
    const float t = along_nodes - (float)cell;
    const float r = 1.0F - t;
    out->first = cell;
    out->value[0] = r * r * r / 6.0F;
    out->value[1] = (4.0F + t * t * (3.0F * t - 6.0F)) / 6.0F;
    out->value[2] = (4.0F + r * r * (3.0F * r - 6.0F)) / 6.0F;
    out->value[3] = t * t * t / 6.0F;
    out->slope[0] = -0.5F * r * r * per_spacing;
    out->slope[1] = t * (1.5F * t - 2.0F) * per_spacing;
    out->slope[2] = -r * (1.5F * r - 2.0F) * per_spacing;
    out->slope[3] = 0.5F * t * t * per_spacing;
}

static field field_at(const float* plane, uint32_t side, const taps* along_u, const taps* along_v) {
    field out = {0.0F, 0.0F, 0.0F};
    for (uint32_t i = 0; i < 4; ++i) {
        const float* row = plane + (along_u->first + i) * side + along_v->first;
        float value = 0.0F;
        float slope = 0.0F;
        for (uint32_t j = 0; j < 4; ++j) {
            value += row[j] * along_v->value[j];
            slope += row[j] * along_v->slope[j];
        }
        out.value += along_u->value[i] * value;
        out.u += along_u->slope[i] * value;
        out.v += along_u->value[i] * slope;
    }
    return out;
}

static bool chart_at(const header* table, const float x[3], chart* out) {
    const float kappa = table->kappa_per_m;
    const float q = 1.0F + kappa * x[2];
    if (!(q >= Q_MIN)) return false;
    const float across2 = x[0] * x[0] + x[1] * x[1];
    const float rho = sqrtf(q * q + kappa * kappa * across2);
    out->u = x[0] / q;
    out->v = x[1] / q;
    const float radius2 = out->u * out->u + out->v * out->v;
    if (!(sqrtf(radius2) <= table->valid_radius_m)) return false;
    out->height = (2.0F * x[2] + kappa * (across2 + x[2] * x[2])) / (1.0F + rho);
    const float inverse = 1.0F / q;
    const float tilt = -kappa * inverse;
    out->grad_u[0] = out->grad_v[1] = inverse;
    out->grad_u[1] = out->grad_v[0] = 0.0F;
    out->grad_u[2] = tilt * out->u;
    out->grad_v[2] = tilt * out->v;
    out->grad_height[0] = kappa * x[0] / rho;
    out->grad_height[1] = kappa * x[1] / rho;
    out->grad_height[2] = q / rho;
    return true;
}

// psi and its derivative at x = H f.
static void depth_law(const float n[5], float x, float* psi, float* slope) {
    const float x2 = x * x;
    const float over = 1.0F + n[0] * x + n[1] * x2 + n[2] * x2 * x2;
    const float under = 1.0F + n[3] * x + n[4] * x2;
    const float over_slope = n[0] + 2.0F * n[1] * x + 4.0F * n[2] * x2 * x;
    const float under_slope = n[3] + 2.0F * n[4] * x;
    *psi = over / under;
    *slope = (over_slope - *psi * under_slope) / under;
}

static void gradient(const field* of, const chart* c, float out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = of->u * c->grad_u[i] + of->v * c->grad_v[i];
}

// Force in the contact frame for f > 0: minus the gradient of K f^2 psi(H f)/2, term by term.
static void press(const header* table, const chart* c, const field* k, const field* h, float f,
                  const float grad_f[3], float force_n[3], float* potential_j) {
    float psi = 1.0F;
    float slope = 0.0F;
    depth_law(table->psi, h->value * f, &psi, &slope);
    const float along_f = k->value * f * (psi + 0.5F * h->value * f * slope);
    *potential_j = 0.5F * k->value * f * f * psi;
    for (int i = 0; i < 3; ++i) force_n[i] = -along_f * grad_f[i];
    if (table->law != PAL_LAW_POTENTIAL) return;
    float grad_k[3];
    float grad_h[3];
    gradient(k, c, grad_k);
    gradient(h, c, grad_h);
    const float along_k = 0.5F * f * f * psi;
    const float along_h = 0.5F * k->value * f * f * f * slope;
    for (int i = 0; i < 3; ++i) force_n[i] -= along_k * grad_k[i] + along_h * grad_h[i];
}

void pal_table_touch(const pal_table* table, const float at_m[3], pal_touch* touch) {
    *touch = (pal_touch){.inside = false};
    header head;
    pal_copy_once(&head, (const char*)table + offsetof(pal_table, law), sizeof head);
    const float* axes = head.axes;
    float x[3];
    const float from_p0[3] = {at_m[0] - head.p0_m[0], at_m[1] - head.p0_m[1], at_m[2] - head.p0_m[2]};
    for (int i = 0; i < 3; ++i) {
        x[i] = axes[3 * i] * from_p0[0] + axes[3 * i + 1] * from_p0[1] + axes[3 * i + 2] * from_p0[2];
    }
    chart c;
    if (!chart_at(&head, x, &c)) return;
    const uint32_t n_nodes = head.n_nodes;
    if (n_nodes < PAL_TABLE_NODES_MIN || n_nodes > PAL_TABLE_NODES_MAX) return;
    const uint32_t side = n_nodes + 2;
    const float middle = 0.5F * (float)(n_nodes - 1);
    const float per_spacing = 1.0F / head.spacing_m;
    taps along_u;
    taps along_v;
    taps_at(middle + c.u * per_spacing, per_spacing, n_nodes, &along_u);
    taps_at(middle + c.v * per_spacing, per_spacing, n_nodes, &along_v);
    const field s = field_at(table->coef, side, &along_u, &along_v);
    const field k = field_at(table->coef + side * side, side, &along_u, &along_v);
    const float f = s.value - c.height;
    float grad_f[3];
    gradient(&s, &c, grad_f);
    for (int i = 0; i < 3; ++i) grad_f[i] -= c.grad_height[i];
    const float steep2 = grad_f[0] * grad_f[0] + grad_f[1] * grad_f[1] + grad_f[2] * grad_f[2];
    touch->inside = true;
    touch->depth_m = f / sqrtf(steep2);
    touch->k_n_per_m = k.value * steep2;
    if (f <= 0.0F) return;
    const field h = field_at(table->coef + 2 * side * side, side, &along_u, &along_v);
    float local_n[3];
    press(&head, &c, &k, &h, f, grad_f, local_n, &touch->potential_j);
    for (int i = 0; i < 3; ++i) {
        touch->force_n[i] = axes[i] * local_n[0] + axes[3 + i] * local_n[1] + axes[6 + i] * local_n[2];
    }
}
