/// What the preload library and the simulator say to each other: one message per URB each way over a
/// SOCK_SEQPACKET socket, native byte order, both ends on one machine and of one build.
///
/// A bus is a folder: sys/bus/usb/devices/1-1/... (what sysfs would show), dev/bus/usb/001/002 (a listening
/// socket in place of the device node), `events` (a listening socket for hot-plug), `control` (questions).
#pragma once
#include <stdint.h>

#define PAL_BUS_VARIABLE "PALPATE_FALCON_BUS" /* environment: the bus folder */
#define PAL_BUS_SYS "/sys/bus/usb/devices"
#define PAL_BUS_DEV "/dev/bus/usb"

enum { PAL_WIRE_VERSION = 1, PAL_WIRE_DATA_MAX = 128 * 1024, PAL_WIRE_PATIENCE_S = 5 };

/// Opening: the client sends pal_wire_hello with two descriptors, the read end of a one-page pipe and one end
/// of a socket pair for calls. The pipe tells "nothing to reap" by being full: the client fills it when it
/// found nothing, the simulator empties it after it sent something. Its read end closing is the unplug. The
/// simulator answers with pal_wire_welcome.
typedef struct pal_wire_hello {
    uint32_t version;
} pal_wire_hello;

typedef struct pal_wire_welcome {
    int32_t error;                         ///< 0, or errno: EPROTO another version
    uint16_t out_endpoints, in_endpoints;  ///< bit n: endpoint n is there
} pal_wire_welcome;

typedef enum pal_wire_kind {
    PAL_WIRE_SUBMIT = 1,  ///< the data of an OUT follow
    PAL_WIRE_DISCARD,     ///< by tag
    PAL_WIRE_DONE         ///< simulator to client: an URB ended; the data of an IN follow
} pal_wire_kind;

typedef struct pal_wire_urb {
    uint32_t kind;
    uint8_t endpoint;
    uint8_t short_is_error;
    uint8_t setup[8];  ///< of a control transfer; else zero
    uint64_t tag;
    int32_t status;    ///< of DONE
    uint32_t n_bytes;  ///< SUBMIT: wanted; DONE: moved
} pal_wire_urb;

/// Calls, over the socket pair: the client waits for the answer, an int32_t: >= 0, or a negative errno value.
typedef enum pal_wire_call_kind {
    PAL_WIRE_CLAIM = 1,      ///< interface number
    PAL_WIRE_RELEASE,        ///< interface number
    PAL_WIRE_CONFIGURATION,  ///< SET_CONFIGURATION
    PAL_WIRE_INTERFACE,      ///< SET_INTERFACE: interface << 8 | alternate setting
    PAL_WIRE_CLEAR_HALT,     ///< endpoint address
    PAL_WIRE_RESET           ///< of the port
} pal_wire_call_kind;

typedef struct pal_wire_call {
    uint32_t kind;
    uint32_t argument;
} pal_wire_call;

/// Hot-plug, simulator to client. On connecting, PAL_WIRE_PRESENT comes for each device that is there.
typedef enum pal_wire_event_kind { PAL_WIRE_PRESENT = 1, PAL_WIRE_ADD, PAL_WIRE_REMOVE } pal_wire_event_kind;

typedef struct pal_wire_event {
    uint32_t kind;
    uint32_t port;    ///< sysfs name "1-<port>"
    uint32_t number;  ///< node "001/<number>"
} pal_wire_event;
