/// Force of a table at a point: the exact gradient of its potential (docs/MATH.md §1).
#pragma once
#include <stdbool.h>

#include "common/table.h"
#ifdef __cplusplus
extern "C" {
#endif

typedef struct pal_touch {
    float force_n[3];   ///< on the hand, workspace frame
    float potential_j;  ///< U at the point
    float depth_m;      ///< g f: of the tool's lowest point below the skin; negative outside
    float k_n_per_m;    ///< linear stiffness K |grad f|^2 under the tool
    bool inside;        ///< q >= 0.2 and within the valid radius; otherwise all else is zero
} pal_touch;

/// Bounded: 16 taps of three fields, about 370 flops. `at_m` is the tool centre in the workspace frame. Reads
/// no byte outside `table` whatever is written there meanwhile: its header is copied once, what the copy says
/// is checked; what then comes out need not be finite.
void pal_table_touch(const pal_table* table, const float at_m[3], pal_touch* touch);

#ifdef __cplusplus
}
#endif
