/// The shared segment of common/link.h, attached by name.
#pragma once
#include "common/link.h"
#ifdef __cplusplus
extern "C" {
#endif

/// Maps the POSIX shared memory object `name` ("/palpate-1234") that a host made. PAL_ERR_IO with errno when
/// the system refuses, else what pal_link_check found wrong. The pages are touched here, not in the tick.
pal_err pal_segment_attach(const char* name, pal_link** link);
void pal_segment_detach(pal_link* link);

#ifdef __cplusplus
}
#endif
