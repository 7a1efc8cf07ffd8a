/// The shared segment of common/link.h, attached by name. It is taken only when it belongs to this user and
/// lets nobody else in: who writes to it decides on forces.
#pragma once
#include "common/link.h"
#ifdef __cplusplus
extern "C" {
#endif

/// A segment whose loop is this process. Zero-initialise, file -1, when there is none.
typedef struct pal_segment {
    pal_link* link;
    int file;  ///< holds the lock on the loop's words, which ends with the process
} pal_segment;

/// Maps the POSIX shared memory object `name` ("/palpate-1234") that a host made. PAL_ERR_IO with errno when
/// the system refuses (ENOENT: no such object; EPERM: it belongs to another user; EACCES: its permissions are
/// not 0600), else what pal_link_check found wrong. The pages are touched here, not in the tick.
pal_err pal_segment_attach(const char* name, pal_link** link);
void pal_segment_detach(pal_link* link);

/// The same as the segment's loop: there is one at a time. PAL_ERR_IO with EBUSY while another lives, whose
/// process is then in `holder` (0: not known yet). Sets all words of pal_link_loop to 0 but pid.
pal_err pal_segment_take(const char* name, pal_segment* segment, uint32_t* holder);
void pal_segment_give(pal_segment* segment);
/// What an error of either says to a person; `why` is its errno.
const char* pal_segment_words(pal_err err, int why);

/// From now on a segment that somebody truncates does not end the process: at the first touch of a page that
/// is gone, private zeros take the place of the whole mapping, so no force and no table, and `*gone`
/// becomes 1. One segment in a process; a handler for SIGBUS.
void pal_segment_watch(pal_link* link, uint32_t* gone);

#ifdef __cplusplus
}
#endif
