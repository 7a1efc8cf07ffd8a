#include "sim/falcon/usb_device.h"

#include <string.h>

#include "sim/falcon/random.h"
#include "sim/falcon/usb_device_private.h"

enum {
    REQUEST_TYPE = 0x60,
    TYPE_STANDARD = 0x00,
    TYPE_VENDOR = 0x40,
    ALL_HOMED = 7,
    TICK_US = 1000,
    REQUEST_RESET = 0,
    PURGE_OUT = 1,
    REPLY_BYTES = 16,
    CLOCKS_PER_S = 24000000
};

pal_usb_device_config pal_usb_device_config_default(void) {
    pal_usb_device_config config;
    memset(&config, 0, sizeof config);
    memcpy(config.manufacturer, "FTDI", sizeof "FTDI");
    memcpy(config.product, "FALCON HAPTIC", sizeof "FALCON HAPTIC");
    memcpy(config.serial, "PALSIM01", sizeof "PALSIM01");
    config.seed = 1;
    config.loader.autobaud_sure_baud = 100000;
    config.loader.autobaud_max_baud = 1000000;
    config.falcon = pal_falcon_sim_config_default();
    return config;
}

/// A firmware begins: each time but the first the counters begin somewhere else.
static void start_firmware(pal_usb_device* d, uint64_t listens_clock) {
    pal_falcon_sim_config counters = d->config.falcon;
    if (d->loader.n_boots > 1) pal_falcon_sim_seed(&counters, pal_sim_random(&d->random));
    pal_falcon_sim_restart(&d->falcon, counters.start_offset_counts);
    d->run_clock = listens_clock;
}

bool pal_usb_device_init(pal_usb_device* device, const pal_usb_device_config* config) {
    memset(device, 0, sizeof *device);
    device->config = *config;
    device->random = config->seed;
    device->now_us = config->start_us;
    device->clock = pal_uart_clock(config->start_us);
    device->fault_us = UINT64_MAX;
    device->configuration = 1;  // as a host leaves it
    device->plugged = device->powered = true;
    device->bridge.modem_lines = config->modem_lines;
    device->bridge.instant = config->instant;
    if (!pal_usb_fill_eeprom(device) || !pal_falcon_sim_init(&device->falcon, &config->falcon)) return false;
    if (!(config->hand.mass_kg >= 0.0) || config->n_faults > PAL_USB_FAULTS_MAX) return false;
    pal_bridge_reset(&device->bridge, config->start_us);
    pal_loader_init(&device->loader, &config->loader, pal_sim_random(&device->random));
    if (config->running) {
        device->loader.dsp = PAL_DSP_RUN;
        device->loader.clocks_per_bit = device->bridge.clocks_per_bit = PAL_UART_RUN_CLOCKS_PER_BIT;
        device->bridge.latency_ms = 1;
        device->loader.n_boots = 1;
        start_firmware(device, device->clock);
    }
    for (size_t i = 0; i < config->n_faults; ++i) {
        if (!pal_usb_device_inject(device, &config->faults[i])) return false;
    }
    device->config.faults = NULL;
    device->config.n_faults = 0;
    return true;
}

void pal_usb_line_say(pal_usb_device* device, const uint8_t* bytes, size_t n_bytes, uint32_t clocks_per_bit,
                      uint64_t earliest_clock) {
    for (size_t i = 0; i < n_bytes && device->n_line < PAL_USB_LINE_BYTES; ++i) {
        pal_usb_line_byte* last = &device->line[(device->line_at + device->n_line) % PAL_USB_LINE_BYTES];
        *last = (pal_usb_line_byte){earliest_clock, clocks_per_bit, bytes[i]};
        if (device->n_line++ == 0) device->line_clock = pal_usb_line_end(device, last, device->clock);
    }
}

static bool firmware_listens(const pal_usb_device* d) {
    return d->loader.dsp == PAL_DSP_RUN && d->clock >= d->run_clock;
}

static void firmware_receive(pal_usb_device* d, pal_line_byte in) {
    if (!firmware_listens(d)) return;
    const bool heard = in.frame_ok && pal_uart_same_baud(in.clocks_per_bit, PAL_UART_RUN_CLOCKS_PER_BIT);
    const uint8_t byte = heard ? in.byte : pal_uart_garbled(in.byte, &d->random);
    uint8_t reply[REPLY_BYTES];
    pal_falcon_sim_receive(&d->falcon, &byte, 1);
    if (!pal_falcon_sim_reply(&d->falcon, reply)) return;
    ++d->n_requests;
    ++d->n_replies;
    pal_usb_line_say(d, reply, sizeof reply, PAL_UART_RUN_CLOCKS_PER_BIT, 0);
}

static void loader_receive(pal_usb_device* d, pal_line_byte in) {
    pal_usb_active_fault* fail = pal_usb_boot_fault(d);
    const pal_loader_answer answer = pal_loader_receive(&d->loader, in, fail ? &fail->fault : NULL);
    const bool instant = d->config.instant;
    if (answer.struck) pal_usb_struck(d, fail);
    if (answer.reset) {
        d->n_line = 0;  // what the DSP was about to say
        pal_falcon_sim_restart(&d->falcon, d->config.falcon.start_offset_counts);
    }
    pal_usb_line_say(d, answer.bytes, answer.n_bytes, answer.clocks_per_bit,
                     d->clock + (instant ? 0 : pal_uart_clock(answer.after_us)));
    if (answer.started)
        start_firmware(d, d->clock + (instant ? 0 : pal_uart_clock(d->config.loader.start_us)));
}

/// A byte from the bridge has ended on the line.
static void line_out(pal_usb_device* d) {
    pal_line_byte in = pal_bridge_sent(&d->bridge);
    if (pal_usb_strikes(d, PAL_USB_FAULT_DROP, PAL_USB_FAULT_OUT, NULL)) return;
    if (pal_usb_strikes(d, PAL_USB_FAULT_CORRUPT, PAL_USB_FAULT_OUT, NULL)) {
        in.byte = pal_uart_garbled(in.byte, &d->random);
    }
    if (d->loader.dsp == PAL_DSP_RUN && !d->loader.dtr) {
        firmware_receive(d, in);
    } else {
        loader_receive(d, in);
    }
}

/// A byte from PIC or DSP has ended on the line.
static void line_in(pal_usb_device* d) {
    const pal_usb_line_byte out = d->line[d->line_at];
    uint8_t byte = out.byte;
    d->line_at = (d->line_at + 1) % PAL_USB_LINE_BYTES;
    if (--d->n_line > 0) d->line_clock = pal_usb_line_end(d, &d->line[d->line_at], d->line_clock);
    if (!d->plugged || pal_usb_strikes(d, PAL_USB_FAULT_DROP, PAL_USB_FAULT_IN, NULL)) return;
    if (pal_usb_strikes(d, PAL_USB_FAULT_CORRUPT, PAL_USB_FAULT_IN, NULL)) {
        byte = pal_uart_garbled(byte, &d->random);
    }
    const bool heard = pal_uart_same_baud(out.clocks_per_bit, d->bridge.clocks_per_bit);
    if (!heard) byte = pal_uart_garbled(byte, &d->random);
    pal_bridge_receive(&d->bridge, byte, heard, d->clock);
}

static void tick(pal_usb_device* d) {
    const pal_usb_hand* hand = &d->config.hand;
    ++d->n_ticks;
    if (hand->advance) hand->advance(hand->context, d->falcon.homed == ALL_HOMED, d->falcon.position_m);
    pal_falcon_sim_advance(&d->falcon, hand->push, hand->context, hand->mass_kg);
}

static uint64_t tick_clock(const pal_usb_device* d) {
    return pal_uart_clock(d->config.start_us + (d->n_ticks + 1) * TICK_US);
}

/// All that happens up to `now_us`, in order; at one time faults first, then the line, then the mechanics.
static void run_to(pal_usb_device* d, uint64_t now_us) {
    for (;;) {
        const uint64_t fault = d->fault_us == UINT64_MAX ? UINT64_MAX : pal_uart_clock(d->fault_us);
        const uint64_t sent = pal_bridge_sent_clock(&d->bridge);
        const uint64_t said = d->n_line > 0 ? d->line_clock : UINT64_MAX;
        const uint64_t moved = tick_clock(d);
        const uint64_t next = pal_usb_earlier(pal_usb_earlier(fault, sent), pal_usb_earlier(said, moved));
        if (next > pal_uart_clock(now_us)) break;
        if (next > d->clock) d->clock = next;
        if (next == fault) {
            pal_usb_faults_turn(d, d->fault_us);
        } else if (next == sent) {
            line_out(d);
        } else if (next == said) {
            line_in(d);
        } else {
            tick(d);
        }
    }
    d->clock = pal_uart_clock(now_us);
}

void pal_usb_device_advance(pal_usb_device* device, uint64_t now_us) {
    if (now_us < device->now_us) return;
    run_to(device, now_us);
    device->now_us = now_us;
}

int pal_usb_device_control(pal_usb_device* device, const uint8_t setup[8], uint8_t* data, size_t n_bytes) {
    if (!device->plugged) return PAL_USB_GONE;
    if (pal_usb_control_stalls(device)) return PAL_USB_STALL;
    const unsigned type = setup[0] & REQUEST_TYPE;
    if (type == TYPE_STANDARD) return pal_usb_standard_request(device, setup, data, n_bytes);
    if (type != TYPE_VENDOR || device->configuration == 0) return PAL_USB_STALL;
    const int n = pal_bridge_request(&device->bridge, device->now_us, setup, data, n_bytes);
    pal_loader_set_dtr(&device->loader, device->bridge.dtr);
    if (n >= 0 && setup[1] == REQUEST_RESET &&
        setup[2] != PURGE_OUT) {  // what a fault holds back is purged too
        device->n_again = 0;
        device->hold_us = device->split_us = 0;
    }
    run_to(device, device->now_us);
    return n;
}

int pal_usb_device_out(pal_usb_device* device, const uint8_t* bytes, size_t n_bytes) {
    if (!device->plugged) return PAL_USB_GONE;
    if (device->no_tokens) return 0;
    if (!pal_usb_usable(device, PAL_USB_FAULT_EP_OUT) || n_bytes > PAL_USB_PACKET_BYTES) return PAL_USB_STALL;
    if (n_bytes > PAL_BRIDGE_OUT_BYTES - device->bridge.n_out) return 0;
    pal_usb_fault fault;
    if (pal_usb_strikes(device, PAL_USB_FAULT_DELAY, PAL_USB_FAULT_OUT, &fault)) {
        device->bridge.not_before_clock = pal_uart_clock(device->now_us + fault.by_us);
    }
    const uint64_t now_clock = pal_uart_clock(device->now_us);
    const int n = pal_bridge_out(&device->bridge, bytes, n_bytes, now_clock);
    if (pal_usb_strikes(device, PAL_USB_FAULT_DUPLICATE, PAL_USB_FAULT_OUT, NULL)) {
        (void)pal_bridge_out(&device->bridge, bytes, n_bytes, now_clock);
    }
    run_to(device, device->now_us);
    return n;
}

/// False: a fault holds the packet back.
static bool let_go(pal_usb_device* d) {
    if (d->now_us < d->split_us || d->now_us < d->hold_us) return false;
    if (d->split_us > 0) {
        d->split_us = 0;
        d->bridge.n_flush = d->bridge.n_in;
    }
    if (!pal_bridge_in_ready(&d->bridge, d->now_us)) return false;
    pal_usb_fault fault;
    if (d->hold_us == 0 && d->bridge.n_in > 0 &&
        pal_usb_strikes(d, PAL_USB_FAULT_DELAY, PAL_USB_FAULT_IN, &fault) && fault.by_us > 0) {
        d->hold_us = d->now_us + fault.by_us;
        return false;
    }
    d->hold_us = 0;
    return true;
}

/// A packet is cut when a fault wants it.
static int take_packet(pal_usb_device* d, uint8_t packet[PAL_USB_PACKET_BYTES]) {
    pal_usb_fault fault;
    if (!pal_usb_splits(d, d->bridge.n_in, &fault)) {
        return pal_bridge_in(&d->bridge, d->now_us, PAL_BRIDGE_PAYLOAD_BYTES, packet);
    }
    const int n = pal_bridge_in(&d->bridge, d->now_us, fault.byte, packet);
    d->bridge.n_flush = d->bridge.n_in;
    if (fault.gap_us > 0) d->split_us = d->now_us + fault.gap_us;
    return n;
}

int pal_usb_device_in(pal_usb_device* device, uint8_t packet[PAL_USB_PACKET_BYTES]) {
    if (!device->plugged) return PAL_USB_GONE;
    if (device->no_tokens) return 0;
    if (!pal_usb_usable(device, PAL_USB_FAULT_EP_IN)) return PAL_USB_STALL;
    if (device->n_again > 0) {
        const int n = device->n_again;
        memcpy(packet, device->again, (size_t)n);
        device->n_again = 0;
        return n;
    }
    if (!let_go(device)) return 0;
    const int n = take_packet(device, packet);
    if (n > 2 && pal_usb_strikes(device, PAL_USB_FAULT_DUPLICATE, PAL_USB_FAULT_IN, NULL)) {
        memcpy(device->again, packet, (size_t)n);
        device->n_again = (uint8_t)n;
    }
    return n;
}

bool pal_usb_device_present(const pal_usb_device* device) {
    return device->plugged;
}

void pal_usb_device_press(pal_usb_device* device, uint8_t buttons) {
    device->falcon.buttons = buttons & 0x0F;
}

pal_usb_device_truth pal_usb_device_read(const pal_usb_device* device) {
    const pal_falcon_sim* falcon = &device->falcon;
    pal_usb_device_truth truth;
    memset(&truth, 0, sizeof truth);
    truth.now_us = device->now_us;
    memcpy(truth.position_m, falcon->position_m, sizeof truth.position_m);
    memcpy(truth.velocity_m_per_s, falcon->velocity_m_per_s, sizeof truth.velocity_m_per_s);
    memcpy(truth.force_n, falcon->force_n, sizeof truth.force_n);
    memcpy(truth.motor_counts, falcon->motor_counts, sizeof truth.motor_counts);
    pal_falcon_sim_read(falcon, truth.encoder_counts);
    truth.homed = falcon->homed;
    truth.leds = falcon->leds;
    truth.buttons = falcon->buttons;
    truth.spare = falcon->spare;
    truth.homing = falcon->homing != 0;
    truth.running = firmware_listens(device);
    truth.watchdog = truth.running && pal_falcon_sim_watchdog(falcon);
    truth.present = device->plugged;
    truth.powered = device->powered;
    truth.dtr = device->bridge.dtr;
    truth.dsp = device->loader.dsp;
    truth.n_boots = device->loader.n_boots;
    truth.n_requests = device->n_requests;
    truth.n_replies = device->n_replies;
    truth.n_strikes = device->n_strikes;
    truth.baud = CLOCKS_PER_S / device->bridge.clocks_per_bit;
    truth.latency_ms = device->bridge.latency_ms;
    return truth;
}
