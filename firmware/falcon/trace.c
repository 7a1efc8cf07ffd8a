#include "firmware/falcon/trace.h"

#include <string.h>

static pal_falcon_trace_record* next_record(pal_falcon_trace* trace, uint64_t now_us,
                                            pal_falcon_trace_kind kind) {
    pal_falcon_trace_record* record = &trace->records[trace->n_written % trace->n_records];
    trace->n_written += 1U;
    memset(record, 0, sizeof *record);
    record->time_us = now_us;
    record->kind = (uint8_t)kind;
    return record;
}

static void keep_bytes(pal_falcon_trace_record* record, const uint8_t* bytes, size_t n_bytes) {
    record->n_bytes = (uint8_t)(n_bytes < sizeof record->bytes ? n_bytes : sizeof record->bytes);
    memcpy(record->bytes, bytes, record->n_bytes);
}

void pal_trace_step(pal_falcon_trace* trace, uint64_t now_us, const pal_usb_step* step) {
    if (trace == NULL || step->kind == PAL_USB_IDLE) return;
    const pal_falcon_trace_kind kind = step->kind == PAL_USB_WRITE ? PAL_TRACE_WRITE : PAL_TRACE_CONTROL;
    pal_falcon_trace_record* record = next_record(trace, now_us, kind);
    record->request = step->request;
    record->value = step->value;
    record->index = step->index;
    if (kind == PAL_TRACE_WRITE) keep_bytes(record, step->bytes, step->n_bytes);
}

void pal_trace_read(pal_falcon_trace* trace, uint64_t now_us, const uint8_t* packet, size_t n_bytes) {
    if (trace == NULL || n_bytes <= PAL_FTDI_STATUS_BYTES)
        return;  // status alone comes every few milliseconds
    keep_bytes(next_record(trace, now_us, PAL_TRACE_READ), packet, n_bytes);
}

void pal_trace_stage(pal_falcon_trace* trace, uint64_t now_us, pal_falcon_stage stage,
                     pal_falcon_failure failure, uint32_t attempt) {
    if (trace == NULL) return;
    pal_falcon_trace_record* record = next_record(trace, now_us, PAL_TRACE_STAGE);
    record->request = (uint8_t)stage;
    record->value = (uint16_t)failure;
    record->index = (uint16_t)attempt;
}
