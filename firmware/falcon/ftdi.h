/// The FT232R bridge in front of the Falcon: its vendor requests as data and the status bytes of its packets.
/// No I/O. docs/PROTOCOL.md 4 has each request with its source.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

enum {
    PAL_FTDI_VENDOR = 0x0403,
    PAL_FTDI_FALCON = 0xCB48,     ///< Novint's product number
    PAL_FTDI_ENDPOINT_IN = 0x81,  ///< bulk
    PAL_FTDI_ENDPOINT_OUT = 0x02,
    PAL_FTDI_REQUEST_TYPE = 0x40,  ///< bmRequestType of every step of kind PAL_USB_CONTROL; no data stage
    PAL_FTDI_PACKET_BYTES = 64,    ///< of a full bulk IN packet
    PAL_FTDI_STATUS_BYTES = 2,     ///< at the head of every IN packet
    PAL_FTDI_PAYLOAD_BYTES = 62
};

typedef enum pal_usb_kind {
    PAL_USB_IDLE = 0,     ///< nothing to send: read until a packet comes or wake_us have passed
    PAL_USB_CONTROL = 1,  ///< control transfer PAL_FTDI_REQUEST_TYPE, request, value, index, no data
    PAL_USB_WRITE = 2     ///< bulk OUT of `bytes`, all of them
} pal_usb_kind;

/// What the port must do next: the whole port contract.
typedef struct pal_usb_step {
    pal_usb_kind kind;
    uint8_t request;       ///< CONTROL: bRequest
    uint16_t value;        ///< CONTROL: wValue
    uint16_t index;        ///< CONTROL: wIndex
    const uint8_t* bytes;  ///< WRITE: valid until the next step is asked for
    size_t n_bytes;        ///< WRITE: 1 to 62
    uint32_t wake_us;      ///< IDLE: ask again after at most this long, counted from now
} pal_usb_step;

typedef enum pal_ftdi_request {
    PAL_FTDI_RESET = 0x00,
    PAL_FTDI_MODEM_CONTROL = 0x01,
    PAL_FTDI_FLOW_CONTROL = 0x02,
    PAL_FTDI_BAUD_RATE = 0x03,
    PAL_FTDI_DATA_FORMAT = 0x04,
    PAL_FTDI_EVENT_CHAR = 0x06,
    PAL_FTDI_ERROR_CHAR = 0x07,
    PAL_FTDI_LATENCY_MS = 0x09
} pal_ftdi_request;

enum {
    PAL_FTDI_RESET_ALL = 0,       ///< of RESET: no flow control, event character off, DTR and RTS low
    PAL_FTDI_PURGE_OUT = 1,       ///< of RESET: bytes on their way to the device
    PAL_FTDI_PURGE_IN = 2,        ///< of RESET: bytes on their way to the host
    PAL_FTDI_DTR_LOW = 0x0100,    ///< of MODEM_CONTROL
    PAL_FTDI_DTR_HIGH = 0x0101,   ///< of MODEM_CONTROL
    PAL_FTDI_RTS_LOW = 0x0200,    ///< of MODEM_CONTROL
    PAL_FTDI_8N1 = 0x0008,        ///< of DATA_FORMAT
    PAL_FTDI_CHAR_ON = 0x0100,    ///< of EVENT_CHAR, with the character in the low byte
    PAL_FTDI_BAUD_MIN = 184,      ///< the divisor has 14 bits
    PAL_FTDI_BAUD_MAX = 3000000,  ///< the chip's clock
    PAL_FTDI_CHIP_HZ = 3000000
};

/// A control step.
pal_usb_step pal_ftdi_control(pal_ftdi_request request, uint16_t value);
/// A wait.
pal_usb_step pal_ftdi_idle(uint32_t wake_us);
/// The control step for the rate nearest to `baud`, clamped to BAUD_MIN..BAUD_MAX.
pal_usb_step pal_ftdi_baud(uint32_t baud);
/// The rate that pal_ftdi_baud(baud) gives, to the nearest integer.
uint32_t pal_ftdi_real_baud(uint32_t baud);

/// What the bridge says about the line in the second status byte of a packet.
enum {
    PAL_FTDI_OVERRUN = 0x02,
    PAL_FTDI_PARITY = 0x04,
    PAL_FTDI_FRAMING = 0x08,
    PAL_FTDI_BREAK = 0x10,
    PAL_FTDI_FIFO = 0x80,
    PAL_FTDI_LINE_ERRORS =
        PAL_FTDI_OVERRUN | PAL_FTDI_PARITY | PAL_FTDI_FRAMING | PAL_FTDI_BREAK | PAL_FTDI_FIFO
};

/// One packet without its status bytes.
typedef struct pal_ftdi_payload {
    const uint8_t* bytes;
    size_t n_bytes;       ///< 0 to 62
    uint8_t line_errors;  ///< PAL_FTDI_OVERRUN ...
} pal_ftdi_payload;

/// Takes the next packet off a transfer: packets of 64 bytes, the last one shorter. False when none is left.
/// A packet shorter than its status bytes has no payload. `*n_taken_bytes` starts at 0.
bool pal_ftdi_next_packet(const uint8_t* transfer, size_t n_bytes, size_t* n_taken_bytes,
                          pal_ftdi_payload* out);

#ifdef __cplusplus
}
#endif
