// Faults at work on the device.
#include <string.h>

#include "sim/falcon/random.h"
#include "sim/falcon/usb_device_private.h"

enum { MILLION = 1000000, ALL_AXES = 7 };

static bool is_active(const pal_usb_active_fault* f) {
    return f->begun && !f->ended;
}

void pal_usb_struck(pal_usb_device* device, pal_usb_active_fault* fault) {
    ++device->n_strikes;
    ++fault->n_struck;
    const bool once = fault->fault.n == 0 && fault->fault.for_us == 0;
    if (once || (fault->fault.n > 0 && fault->n_struck >= fault->fault.n)) fault->ended = true;
}

/// Throws the dice of an active fault.
static bool strikes(pal_usb_device* d, pal_usb_active_fault* f) {
    if (pal_sim_random(&f->random) % MILLION >= f->fault.per_million) return false;
    pal_usb_struck(d, f);
    return true;
}

bool pal_usb_strikes(pal_usb_device* device, pal_usb_fault_kind kind, uint8_t dir, pal_usb_fault* struck) {
    for (uint32_t i = 0; i < device->n_faults; ++i) {
        pal_usb_active_fault* f = &device->faults[i];
        if (f->fault.kind != kind || !is_active(f) || !(f->fault.dir & dir)) continue;
        if (!strikes(device, f)) continue;
        if (struck) *struck = f->fault;
        return true;
    }
    return false;
}

bool pal_usb_splits(pal_usb_device* device, uint32_t n_bytes, pal_usb_fault* struck) {
    for (uint32_t i = 0; i < device->n_faults; ++i) {
        pal_usb_active_fault* f = &device->faults[i];
        if (f->fault.kind != PAL_USB_FAULT_SPLIT || !is_active(f) || n_bytes <= f->fault.byte) continue;
        if (!strikes(device, f)) continue;
        *struck = f->fault;
        return true;
    }
    return false;
}

bool pal_usb_control_stalls(pal_usb_device* device) {
    for (uint32_t i = 0; i < device->n_faults; ++i) {
        pal_usb_active_fault* f = &device->faults[i];
        if (f->fault.kind != PAL_USB_FAULT_STALL || !is_active(f)) continue;
        if ((f->fault.endpoints & PAL_USB_FAULT_EP_CONTROL) && strikes(device, f)) return true;
    }
    return false;
}

bool pal_usb_corrupts(const pal_usb_device* device) {
    for (uint32_t i = 0; i < device->n_faults; ++i) {
        const pal_usb_active_fault* f = &device->faults[i];
        if (f->fault.kind == PAL_USB_FAULT_CORRUPT && is_active(f)) return true;
    }
    return false;
}

/// Whether the loader, as it is, may come to this place with its next byte.
static bool is_next(const pal_loader* loader, const pal_usb_fault* fault) {
    switch (fault->stage) {
        case PAL_BOOT_FAIL_PIC_SILENT:
        case PAL_BOOT_FAIL_PIC_WRONG:
            return loader->dtr;
        case PAL_BOOT_FAIL_AUTOBAUD_SILENT:
        case PAL_BOOT_FAIL_AUTOBAUD_WRONG:
            return !loader->dtr && loader->dsp == PAL_DSP_AUTOBAUD;
        case PAL_BOOT_FAIL_ECHO_WRONG:
        case PAL_BOOT_FAIL_ECHO_SILENT:
            return !loader->dtr && loader->dsp == PAL_DSP_LOAD && loader->container.n_bytes == fault->byte;
        default:
            return !loader->dtr && loader->dsp == PAL_DSP_LOAD;
    }
}

pal_usb_active_fault* pal_usb_boot_fault(pal_usb_device* device) {
    pal_usb_active_fault* found = NULL;
    for (uint32_t i = 0; i < device->n_faults; ++i) {
        pal_usb_active_fault* f = &device->faults[i];
        if (f->fault.kind != PAL_USB_FAULT_BOOT_FAIL || !is_active(f) || !is_next(&device->loader, &f->fault))
            continue;
        // The end of a container is any byte of it: a fault of this one byte comes first.
        if (!found || found->fault.stage == PAL_BOOT_FAIL_NO_START) found = f;
    }
    return found;
}

bool pal_usb_halted(const pal_usb_device* device, pal_usb_fault_endpoint endpoint) {
    if (device->halted & endpoint) return true;
    for (uint32_t i = 0; i < device->n_faults; ++i) {
        const pal_usb_active_fault* f = &device->faults[i];
        if (f->fault.kind == PAL_USB_FAULT_STALL && is_active(f) && (f->fault.endpoints & endpoint))
            return true;
    }
    return false;
}

static void jump(pal_usb_device* d, const pal_usb_fault* fault) {
    for (int i = 0; i < 3; ++i) {
        if (fault->axis == 0 || fault->axis == i + 1) d->falcon.offset_counts[i] += fault->counts;
    }
}

static void begin(pal_usb_device* d, pal_usb_active_fault* f) {
    const pal_usb_fault* fault = &f->fault;
    f->begun = true;
    f->next_us = f->begin_us;
    const uint8_t bulk = fault->endpoints & (PAL_USB_FAULT_EP_IN | PAL_USB_FAULT_EP_OUT);
    switch (fault->kind) {
        case PAL_USB_FAULT_JUMP:
            jump(d, fault);
            pal_usb_struck(d, f);
            break;
        case PAL_USB_FAULT_STALL:
            d->halted |= bulk;
            if (!bulk) break;  // a control endpoint does not stay halted: it strikes request by request
            ++d->n_strikes;
            f->ended = fault->for_us == 0;
            break;
        case PAL_USB_FAULT_UNPLUG:
        case PAL_USB_FAULT_POWER_OUT:
        case PAL_USB_FAULT_FREEZE:
            ++d->n_strikes;
            break;
        case PAL_USB_FAULT_SLOW_HOST:  // its end is that of for_us, not that of a strike
            ++d->n_strikes;
            ++f->n_struck;
            break;
        default:
            break;
    }
}

/// One burst of bytes that nobody asked for, at the speed that the DSP speaks.
static void babble(pal_usb_device* d, pal_usb_active_fault* f) {
    uint8_t bytes[PAL_USB_PACKET_BYTES];
    f->next_us += f->fault.every_us;
    for (uint32_t i = 0; i < f->fault.length; ++i) bytes[i] = (uint8_t)pal_sim_random(&f->random);
    pal_usb_struck(d, f);
    if (d->loader.dsp == PAL_DSP_OFF) return;
    const uint32_t known = d->loader.clocks_per_bit;
    pal_usb_line_say(d, bytes, f->fault.length, known ? known : PAL_UART_PIC_CLOCKS_PER_BIT, 0);
}

static uint64_t due_us(const pal_usb_active_fault* f) {
    uint64_t due = UINT64_MAX;
    if (f->ended) return due;
    if (!f->begun) return f->begin_us;
    if (f->fault.for_us > 0) due = f->end_us;
    if (f->fault.kind == PAL_USB_FAULT_BABBLE && f->next_us < due) due = f->next_us;
    return due;
}

/// The time of a fault is over: it ends, or begins once more later.
static void end(pal_usb_active_fault* f) {
    const bool again = f->fault.kind == PAL_USB_FAULT_SLOW_HOST && f->fault.every_us > 0 &&
                       (f->fault.n == 0 || f->n_struck < f->fault.n);
    f->ended = !again;
    if (!again) return;
    f->begun = false;
    f->begin_us += f->fault.every_us;
    f->end_us = f->begin_us + f->fault.for_us;
}

static void turn_one(pal_usb_device* d, pal_usb_active_fault* f, uint64_t at_us) {
    if (!f->begun && f->begin_us <= at_us) begin(d, f);
    if (!is_active(f)) return;
    if (f->fault.for_us > 0 && f->end_us <= at_us) {
        end(f);
    } else if (f->fault.kind == PAL_USB_FAULT_BABBLE && f->next_us <= at_us) {
        babble(d, f);
    }
}

static void set_plugged(pal_usb_device* d, bool plugged, uint64_t at_us) {
    if (plugged == d->plugged) return;
    d->plugged = plugged;
    pal_bridge_reset(&d->bridge, at_us);
    pal_loader_set_dtr(&d->loader, false);
    d->n_line = 0;
    d->n_again = d->halted = 0;
    d->hold_us = d->split_us = 0;
    d->remote_wakeup = false;
    d->configuration = 1;
}

static void set_dsp_power(pal_usb_device* d, bool on) {
    if (on == (d->loader.dsp != PAL_DSP_OFF)) return;
    pal_loader_power(&d->loader, on);
    pal_falcon_sim_restart(&d->falcon, d->config.falcon.start_offset_counts);
    d->n_line = 0;
}

/// Plug, supply, tokens and encoders as the active faults want them.
static void follow(pal_usb_device* d, uint64_t at_us) {
    bool plugged = true;
    bool powered = true;
    bool tokens = true;
    uint8_t frozen = 0;
    for (uint32_t i = 0; i < d->n_faults; ++i) {
        const pal_usb_active_fault* f = &d->faults[i];
        if (!is_active(f)) continue;
        if (f->fault.kind == PAL_USB_FAULT_UNPLUG) plugged = false;
        if (f->fault.kind == PAL_USB_FAULT_POWER_OUT) powered = false;
        if (f->fault.kind == PAL_USB_FAULT_SLOW_HOST) tokens = false;
        if (f->fault.kind != PAL_USB_FAULT_FREEZE) continue;
        const int axis = f->fault.axis;
        frozen = (uint8_t)(frozen | (axis ? 1 << (axis - 1) : ALL_AXES));
    }
    set_plugged(d, plugged, at_us);
    d->powered = powered;
    d->no_tokens = !tokens;
    set_dsp_power(d, powered && (plugged || d->config.unplug_keeps_firmware));
    if (frozen != d->falcon.frozen) pal_falcon_sim_freeze(&d->falcon, frozen);
}

void pal_usb_faults_turn(pal_usb_device* device, uint64_t at_us) {
    for (uint32_t i = 0; i < device->n_faults; ++i) turn_one(device, &device->faults[i], at_us);
    follow(device, at_us);
    device->fault_us = UINT64_MAX;
    for (uint32_t i = 0; i < device->n_faults; ++i) {
        const uint64_t due = due_us(&device->faults[i]);
        if (due < device->fault_us) device->fault_us = due;
    }
}

/// A place that no fault needs any more.
static pal_usb_active_fault* free_place(pal_usb_device* d) {
    for (uint32_t i = 0; i < d->n_faults; ++i) {
        if (d->faults[i].ended) return &d->faults[i];
    }
    return d->n_faults < PAL_USB_FAULTS_MAX ? &d->faults[d->n_faults++] : NULL;
}

static bool inject_from(pal_usb_device* device, const pal_usb_fault* fault, uint64_t from_us) {
    if (pal_usb_fault_problem(fault)) return false;
    pal_usb_active_fault* place = free_place(device);
    if (!place) return false;
    memset(place, 0, sizeof *place);
    place->fault = *fault;
    place->begin_us = from_us + fault->at_us;
    if (place->begin_us < device->now_us) place->begin_us = device->now_us;
    place->end_us = place->begin_us + fault->for_us;
    place->random = pal_sim_random(&device->random);
    pal_usb_faults_turn(device, device->now_us);
    pal_usb_device_advance(device, device->now_us);  // an instant line says at once what there is
    return true;
}

bool pal_usb_device_inject(pal_usb_device* device, const pal_usb_fault* fault) {
    return inject_from(device, fault, device->config.start_us);
}

bool pal_usb_device_inject_now(pal_usb_device* device, const pal_usb_fault* fault) {
    return inject_from(device, fault, device->now_us);
}

void pal_usb_device_heal(pal_usb_device* device) {
    const uint64_t now_us = device->now_us;
    for (uint32_t i = 0; i < device->n_faults; ++i) device->faults[i].ended = true;
    device->halted = 0;
    device->hold_us = 0;
    if (device->split_us > now_us) device->split_us = now_us;  // the rest may go
    pal_bridge_release(&device->bridge, pal_uart_clock(now_us));
    pal_usb_faults_turn(device, now_us);
    pal_usb_device_advance(device, now_us);  // what an instant line had to wait with
}
