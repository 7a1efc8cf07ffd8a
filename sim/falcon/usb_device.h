/// A Novint Falcon at its USB wire: FT232R bridge, PIC, boot ROM, run-time firmware, mechanics. No I/O, no
/// heap, no clock: the caller tells the time in microseconds of one monotone clock. What happens depends on
/// the times of the transfers alone, never on how often advance is called. Written from facts, not from the
/// driver.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "sim/falcon/bridge.h"
#include "sim/falcon/falcon_sim.h"
#include "sim/falcon/faults.h"
#include "sim/falcon/loader.h"
#ifdef __cplusplus
extern "C" {
#endif

enum {
    PAL_USB_STALL = -1,  ///< the request or endpoint is refused
    PAL_USB_GONE = -2,   ///< the plug is out
    PAL_USB_PACKET_BYTES = 64,
    PAL_USB_EP_IN = 0x81,
    PAL_USB_EP_OUT = 0x02,
    PAL_USB_VENDOR_ID = 0x0403,
    PAL_USB_PRODUCT_ID = 0xCB48,
    PAL_USB_TEXT_BYTES = 32  ///< of a string with its 0
};

/// Who holds the grip. All members may be NULL or 0: nobody.
typedef struct pal_usb_hand {
    void* context;
    void (*advance)(void* context, bool homed, const double position_m[3]);  ///< once before each 1 ms
    pal_falcon_push push;                                                    ///< gets `context`
    double mass_kg;  ///< moves with the effector, weighs nothing
} pal_usb_hand;

typedef struct pal_usb_device_config {
    char manufacturer[PAL_USB_TEXT_BYTES];  ///< assumed
    char product[PAL_USB_TEXT_BYTES];
    char serial[PAL_USB_TEXT_BYTES];
    uint64_t start_us;  ///< of the caller's clock: the plug goes in
    uint64_t seed;      ///< of all that is random: garbled bytes, autobaud, faults, counters at each start
    bool instant;       ///< serial line, PIC and ROM take no time and data wait for no timer
    bool running;       ///< the firmware runs, at 1.5 Mbaud and 1 ms latency, as an earlier session left it
    bool unplug_keeps_firmware;  ///< DSP and motors have a supply of their own; no source tells
    uint8_t modem_lines;         ///< bits 4-7: CTS DSR RI DCD; no source tells, 0
    pal_loader_config loader;
    pal_falcon_sim_config falcon;
    pal_usb_hand hand;
    const pal_usb_fault* faults;  ///< copied; at most PAL_USB_FAULTS_MAX
    size_t n_faults;
} pal_usb_device_config;

typedef struct pal_usb_active_fault {
    pal_usb_fault fault;
    uint64_t begin_us, end_us;  ///< of the caller's clock; end_us counts when for_us is not 0
    uint64_t next_us;           ///< babble: the next burst
    uint64_t random;
    uint32_t n_struck;
    bool begun, ended;
} pal_usb_active_fault;

enum { PAL_USB_LINE_BYTES = 256 };

/// A byte that waits for the line from PIC or DSP to the bridge.
typedef struct pal_usb_line_byte {
    uint64_t earliest_clock;
    uint32_t clocks_per_bit;
    uint8_t byte;
} pal_usb_line_byte;

/// The caller owns it and looks at it through the functions below only.
typedef struct pal_usb_device {
    pal_usb_device_config config;
    pal_bridge bridge;
    pal_loader loader;
    pal_falcon_sim falcon;
    uint64_t now_us, clock, n_ticks, random;
    uint64_t run_clock;  ///< from when the firmware listens
    pal_usb_line_byte line[PAL_USB_LINE_BYTES];
    uint32_t n_line, line_at;
    uint64_t line_clock;  ///< when the byte at line_at ends
    pal_usb_active_fault faults[PAL_USB_FAULTS_MAX];
    uint32_t n_faults;
    uint64_t fault_us;  ///< when a fault begins, ends or babbles next
    uint64_t hold_us;   ///< a delayed IN packet is held until then; 0: none is
    uint64_t split_us;  ///< the rest of a split packet is held until then; 0: none is
    uint8_t again[PAL_USB_PACKET_BYTES];
    uint8_t n_again;  ///< a packet that comes once more
    uint8_t halted;   ///< pal_usb_fault_endpoint bits
    uint8_t configuration;
    bool remote_wakeup, plugged, powered;
    bool no_tokens;  ///< a slow host sends none to the bulk endpoints
    uint32_t n_requests, n_replies, n_strikes;
} pal_usb_device;

/// What is true inside, for tests and status.
typedef struct pal_usb_device_truth {
    uint64_t now_us;
    double position_m[3], velocity_m_per_s[3];
    double force_n[3];          ///< of the motors on the effector
    int16_t motor_counts[3];    ///< acting
    int16_t encoder_counts[3];  ///< as a reply would tell them now
    uint8_t homed;              ///< bit i: arm i
    uint8_t leds;               ///< 2 green, 4 blue, 8 red
    uint8_t buttons;
    uint8_t spare;  ///< byte 14 of the last request, minus 'A'
    bool homing;
    bool running;   ///< the run-time firmware
    bool watchdog;  ///< has switched the motors off
    bool present, powered, dtr;
    pal_dsp_state dsp;
    uint32_t n_boots, n_requests, n_replies;
    uint32_t n_strikes;  ///< of faults
    uint32_t baud;       ///< of the bridge, rounded down
    uint8_t latency_ms;
} pal_usb_device_truth;

pal_usb_device_config pal_usb_device_config_default(void);
/// False when a text is too long for the EEPROM, a fault or a parameter of the mechanics makes no sense.
bool pal_usb_device_init(pal_usb_device* device, const pal_usb_device_config* config);
/// Bridge timers, serial bytes, PIC, ROM, firmware, watchdog, mechanics, faults up to now. Times never
/// decrease; an earlier one does nothing. Cost: 1 ms of mechanics for each.
void pal_usb_device_advance(pal_usb_device* device, uint64_t now_us);
/// When an IN token is worth a trial: the time of the last advance when it would be answered now; else later,
/// never too late, seldom too early. UINT64_MAX: only after a write.
uint64_t pal_usb_device_next_us(const pal_usb_device* device);
/// A control transfer: standard requests and those of the FT232R. `n_bytes`: of data, at most wLength. >= 0:
/// bytes of data; PAL_USB_STALL; PAL_USB_GONE.
int pal_usb_device_control(pal_usb_device* device, const uint8_t setup[8], uint8_t* data, size_t n_bytes);
/// A bulk OUT packet of at most 64 bytes on endpoint 0x02: n_bytes; 0: NAK, the chip has no room, or a slow
/// host got nothing through; PAL_USB_STALL; PAL_USB_GONE.
int pal_usb_device_out(pal_usb_device* device, const uint8_t* bytes, size_t n_bytes);
/// A bulk IN packet on endpoint 0x81: bytes, two of status first; 0: NAK or a slow host; PAL_USB_STALL;
/// PAL_USB_GONE.
int pal_usb_device_in(pal_usb_device* device, uint8_t packet[PAL_USB_PACKET_BYTES]);
/// False while a fault has the plug out.
bool pal_usb_device_present(const pal_usb_device* device);
/// A fault, now or later: at_us counts from start_us, one in the past begins now. False: it makes no sense or
/// there are too many.
bool pal_usb_device_inject(pal_usb_device* device, const pal_usb_fault* fault);
/// The same with at_us counting from now.
bool pal_usb_device_inject_now(pal_usb_device* device, const pal_usb_fault* fault);
/// Ends all faults, also those to come: the plug and the supply are in again, and what a delay or a split
/// held back goes on.
void pal_usb_device_heal(pal_usb_device* device);
/// Grip buttons, 4 bits.
void pal_usb_device_press(pal_usb_device* device, uint8_t buttons);
pal_usb_device_truth pal_usb_device_read(const pal_usb_device* device);

#ifdef __cplusplus
}
#endif
