/// Answers of the control socket about devices on USB: "status", "fault TEXT", "fault N TEXT", "heal", "press
/// N".
#pragma once
#include <stdint.h>

#include "sim/usb/bus.h"

enum { PAL_STATUS_BYTES = 8192 };

typedef struct pal_status_source {
    pal_bus* bus;
    uint32_t (*n_open)(const void* context, uint32_t port);  ///< programs that have it open
    const void* context;
} pal_status_source;

/// One line of JSON into `out`; {"error":"..."} for what is not understood.
void pal_status_answer(const pal_status_source* source, const char* question, char out[PAL_STATUS_BYTES]);
