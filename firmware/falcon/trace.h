/// A record of all that went over the wire, as data in memory of the caller: no callback, no I/O.
#pragma once
#include <stddef.h>
#include <stdint.h>

#include "firmware/falcon/failure.h"
#include "firmware/falcon/ftdi.h"
#ifdef __cplusplus
extern "C" {
#endif

/// What a record is, and which of its members have a meaning.
typedef enum pal_falcon_trace_kind {
    PAL_TRACE_CONTROL = 1,  ///< request, value, index
    PAL_TRACE_WRITE,        ///< bytes
    PAL_TRACE_READ,         ///< a packet with a payload, status bytes included
    PAL_TRACE_STAGE         ///< request: a pal_falcon_stage, value: a pal_falcon_failure, index: attempt
} pal_falcon_trace_kind;

typedef struct pal_falcon_trace_record {
    uint64_t time_us;
    uint8_t kind;     ///< a pal_falcon_trace_kind
    uint8_t request;  ///< CONTROL; STAGE
    uint8_t n_bytes;  ///< of `bytes`
    uint8_t reserved;
    uint16_t value, index;
    uint8_t bytes[PAL_FTDI_PACKET_BYTES];
} pal_falcon_trace_record;

/// A ring: record k (from 0) is records[k % n_records], for the last n_records of n_written.
typedef struct pal_falcon_trace {
    pal_falcon_trace_record* records;
    uint32_t n_records;
    uint64_t n_written;
} pal_falcon_trace;

/// Each does nothing for NULL.
void pal_trace_step(pal_falcon_trace* trace, uint64_t now_us, const pal_usb_step* step);
void pal_trace_read(pal_falcon_trace* trace, uint64_t now_us, const uint8_t* packet, size_t n_bytes);
void pal_trace_stage(pal_falcon_trace* trace, uint64_t now_us, pal_falcon_stage stage,
                     pal_falcon_failure failure, uint32_t attempt);

#ifdef __cplusplus
}
#endif
