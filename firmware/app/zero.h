/// palpate-loop --zero: takes the force away from a device whose loop has died.
#pragma once
#include "firmware/app/options.h"
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_LOOP_PATH_BYTES = 4096 };

/// The exit code: 0 when the device has answered requests of zero force, else 3 with a sentence on stderr. A
/// simulated device may hold the dead loop's connection a little longer: it is tried for a second. A Falcon
/// on the USB is left to palpate-falcon zero, which takes the place of this process.
int pal_loop_zero(const pal_loop_options* options);
/// The path of program `name` beside this one. False: it would be too long.
bool pal_loop_program_beside(const char* name, char path[PAL_LOOP_PATH_BYTES]);

#ifdef __cplusplus
}
#endif
