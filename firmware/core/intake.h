/// Between the table ring and the tick: takes the newest table when no fade runs, has it checked before its
/// first use, refuses a bad one. The check may run elsewhere (a thread of the loop process) or in line
/// (virtual time).
#pragma once
#include <stdbool.h>
#include <stdint.h>

#include "common/table_ring.h"
#include "firmware/core/step.h"
#ifdef __cplusplus
extern "C" {
#endif

typedef enum pal_intake_state {
    PAL_INTAKE_IDLE = 0,     ///< nothing taken that is not in use
    PAL_INTAKE_PENDING = 1,  ///< taken, waiting for its check
    PAL_INTAKE_GOOD = 2,
    PAL_INTAKE_BAD = 3
} pal_intake_state;

/// Zero-initialise, then set ring and limits.
typedef struct pal_intake {
    pal_table_ring* ring;
    pal_table_limits limits;
    uint32_t state;            ///< a pal_intake_state; handed between tick and checker by acquire and release
    uint32_t last_err;         ///< -pal_err of the last refused table
    bool refused;              ///< the ring's current table was refused and not yet replaced
    const pal_table* pending;  ///< taken and not yet in use: the tick's, and the checker's while PENDING
    uint64_t pending_id, now_id;  ///< as checked; of the table in use, 0: none
    pal_loop_tables tables;
} pal_intake;

/// Tick: moves things on (never blocks) and gives the tables for this tick.
const pal_loop_tables* pal_intake_poll(pal_intake* intake, bool fading);
/// Checker: checks the pending table, if any; an id that is not newer than the one in use is refused. True
/// when it did.
bool pal_intake_check(pal_intake* intake);

#ifdef __cplusplus
}
#endif
