/// Ticks that nobody sees: they fetch the code and the tables of constants that a tick needs.
#pragma once
#include "firmware/core/step.h"
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_WARM_TICKS = 1000 };

/// PAL_WARM_TICKS ticks in contact with a flat skin, one of them with two tables, on a loop of its own: no
/// device, no ring. Returns how many felt a force. Uses 120 KB of stack.
uint32_t pal_warm_loop(const pal_loop_config* config);

#ifdef __cplusplus
}
#endif
