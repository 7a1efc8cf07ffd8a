/// Between the files of the USB device model.
#pragma once
#include "sim/falcon/usb_device.h"

/// Faults that begin, end or babble by `at_us` do so; plug, supply and encoders follow.
void pal_usb_faults_turn(pal_usb_device* device, uint64_t at_us);
/// Whether an active fault of this kind strikes now in one of the directions `dir`; `struck` may be NULL.
bool pal_usb_strikes(pal_usb_device* device, pal_usb_fault_kind kind, uint8_t dir, pal_usb_fault* struck);
/// Whether a fault cuts a payload of `n_bytes` now.
bool pal_usb_splits(pal_usb_device* device, uint32_t n_bytes, pal_usb_fault* struck);
/// Whether a fault refuses this control transfer.
bool pal_usb_control_stalls(pal_usb_device* device);
/// Whether bytes may change on the line now.
bool pal_usb_corrupts(const pal_usb_device* device);
/// The active boot-fail fault that the loader can come to with its next byte; NULL: none.
pal_usb_active_fault* pal_usb_boot_fault(pal_usb_device* device);
/// It has struck.
void pal_usb_struck(pal_usb_device* device, pal_usb_active_fault* fault);
/// Whether a bulk endpoint is halted.
bool pal_usb_halted(const pal_usb_device* device, pal_usb_fault_endpoint endpoint);

/// Bytes from PIC or DSP to the bridge, after what is on its way already.
void pal_usb_line_say(pal_usb_device* device, const uint8_t* bytes, size_t n_bytes, uint32_t clocks_per_bit,
                      uint64_t earliest_clock);

/// When a byte ends that may begin from `from_clock` on.
uint64_t pal_usb_line_end(const pal_usb_device* device, const pal_usb_line_byte* byte, uint64_t from_clock);
static inline uint64_t pal_usb_earlier(uint64_t a, uint64_t b) {
    return a < b ? a : b;
}
/// Configured and not halted.
bool pal_usb_usable(const pal_usb_device* device, pal_usb_fault_endpoint endpoint);

/// Strings and identity as an FT232R keeps them. False: the strings do not fit.
bool pal_usb_fill_eeprom(pal_usb_device* device);
int pal_usb_standard_request(pal_usb_device* device, const uint8_t setup[8], uint8_t* data, size_t n_bytes);
