/// Between the table ring and the tick: takes the newest table when no fade runs, has it checked before its
/// first use, refuses a bad one. The check runs elsewhere (a thread of the loop process) or, where there is
/// no second thread (virtual time, a microcontroller), in slices, one a tick.
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

enum {
    /// Words of a table that a slice of its check looks at: tables of up to 27 nodes are checked in one
    /// slice,
    /// the largest, of 65, in 5. A table that waits for such a check, its fade and its own check is still in
    /// use
    /// within 10 ticks and a fade (docs/PROTOCOL.md). A processor on which that is too much for a tick takes
    /// less.
    PAL_INTAKE_SLICE_WORDS = 8192
};

/// Zero-initialise, then set ring and limits.
typedef struct pal_intake {
    pal_table_ring* ring;
    pal_table_limits limits;
    uint32_t state;            ///< a pal_intake_state; handed between tick and checker by acquire and release
    uint32_t last_err;         ///< -pal_err of the last refused table
    bool refused;              ///< the ring's current table was refused and not yet replaced
    const pal_table* pending;  ///< taken and not yet in use: the tick's, and the checker's while PENDING
    uint64_t pending_id, now_id;  ///< as checked; of the table in use, 0: none
    pal_table_checking checking;  ///< the checker's alone; zero between two tables
    uint64_t checking_id;         ///< the checker's alone: as read when the check began
    pal_loop_tables tables;
} pal_intake;

/// Tick: moves things on (never blocks) and gives the tables for this tick.
const pal_loop_tables* pal_intake_poll(pal_intake* intake, bool fading);
/// Checker: checks the pending table, if any, or what slices have left of it; an id that is not newer than
/// the one in use is refused. True when it did.
bool pal_intake_check(pal_intake* intake);
/// Checker: the same in slices, each of at most `n_words_max` words (pal_table_check_slice). True when the
/// pending table's check ended with this one; the next poll then acts on it. A writer that rewrites a table
/// between two slices gets no further than one that does so after the check.
bool pal_intake_check_slice(pal_intake* intake, uint32_t n_words_max);

#ifdef __cplusplus
}
#endif
