/// The command line of palpate-loop.
#pragma once
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "firmware/port/linux/realtime.h"
#ifdef __cplusplus
extern "C" {
#endif

typedef struct pal_loop_options {
    const char* link_name;
    const char* device_path;  ///< of `link:PATH`; NULL: a Falcon on the USB
    const char* serial;       ///< of `usb:SERIAL`; NULL: the first
    const char* firmware;     ///< NULL: the usual places
    const char* delta;        ///< file of geometry and gains; NULL: the built-in Falcon NF1
    bool usb;
    bool zero;  ///< only take the force away
    float force_max_n;
    uint32_t ramp_ticks;
    pal_realtime_choice realtime;
    bool help;
} pal_loop_options;

/// Reads argv. What is wrong goes to `complaint`, one line, and false is returned.
bool pal_loop_options_read(int argc, char** argv, pal_loop_options* options, FILE* complaint);
void pal_loop_options_help(FILE* out);

#ifdef __cplusplus
}
#endif
