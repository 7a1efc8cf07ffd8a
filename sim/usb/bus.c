#include "sim/usb/bus.h"

#include <string.h>
#include <time.h>

#include "sim/usb/device_port.h"

enum {
    CATCH_UP_US = 200000,
    NUMBER_MIN = 2,  // 1 is the root hub's
    NUMBER_MAX = 127,
    TO_DEVICE = 0x00,
    FROM_DEVICE = 0x80,
    GET_DESCRIPTOR = 6,
    SET_CONFIGURATION = 9,
    DESCRIPTOR_DEVICE = 1,
    DESCRIPTOR_CONFIGURATION = 2,
    DESCRIPTOR_STRING = 3,
    ENGLISH = 0x0409
};

int pal_bus_control(pal_bus_port* port, uint8_t type, uint8_t request, uint16_t value, uint16_t index,
                    uint8_t* data, uint16_t n_bytes) {
    const uint8_t setup[8] = {type,
                              request,
                              (uint8_t)(value & 0xFFU),
                              (uint8_t)(value >> 8),
                              (uint8_t)(index & 0xFFU),
                              (uint8_t)(index >> 8),
                              (uint8_t)(n_bytes & 0xFFU),
                              (uint8_t)(n_bytes >> 8)};
    pal_urb urb = {.data = data, .n_bytes = n_bytes, .status = PAL_HOST_PENDING};
    memcpy(urb.setup, setup, sizeof setup);
    if (port->capture) pal_usbmon_see(port->capture, (uint8_t)port->number, &urb, port->host.now_us);
    const int n = port->host.device.control(&port->device, setup, data, n_bytes);
    urb.status = n >= 0 ? PAL_HOST_OK : n == PAL_HOST_DEVICE_STALLS ? PAL_HOST_STALLED : PAL_HOST_GONE;
    urb.n_done = n > 0 ? (uint32_t)n : 0;
    if (port->capture) pal_usbmon_see(port->capture, (uint8_t)port->number, &urb, port->host.now_us);
    return n;
}

/// String descriptor `index` in ASCII; empty when there is none.
static void read_text(pal_bus_port* port, uint8_t index, char out[PAL_BUS_TEXT_BYTES]) {
    uint8_t bytes[255];
    out[0] = '\0';
    if (index == 0) return;
    const uint16_t value = (uint16_t)(DESCRIPTOR_STRING << 8 | index);
    const int n = pal_bus_control(port, FROM_DEVICE, GET_DESCRIPTOR, value, ENGLISH, bytes, sizeof bytes);
    int n_out = 0;
    for (int i = 2; i + 1 < n && n_out + 1 < PAL_BUS_TEXT_BYTES; i += 2) {
        const bool ascii = bytes[i + 1] == 0 && bytes[i] >= ' ' && bytes[i] <= '~';
        out[n_out++] = ascii ? (char)bytes[i] : '?';
    }
    out[n_out] = '\0';
}

/// The next address of the bus that no device has.
static uint32_t free_number(const pal_bus* bus) {
    uint32_t number = bus->last_number;
    bool taken = true;
    while (taken) {  // there are more addresses than ports
        number = number < NUMBER_MAX ? number + 1 : NUMBER_MIN;
        taken = false;
        for (uint32_t i = 0; i < bus->n_ports; ++i) {
            taken = taken || (bus->ports[i].present && bus->ports[i].number == number);
        }
    }
    return number;
}

/// What a kernel does with a device that was plugged in. False when it does not answer as a device must.
static bool enumerate(pal_bus* bus, pal_bus_port* port) {
    port->number = free_number(bus);
    const int n_device = pal_bus_control(port, FROM_DEVICE, GET_DESCRIPTOR, DESCRIPTOR_DEVICE << 8, 0,
                                         port->device_descriptor, sizeof port->device_descriptor);
    if (n_device != (int)sizeof port->device_descriptor) return false;
    const int n = pal_bus_control(port, FROM_DEVICE, GET_DESCRIPTOR, DESCRIPTOR_CONFIGURATION << 8, 0,
                                  port->configuration, sizeof port->configuration);
    if (n < 9) return false;
    port->n_configuration = (uint32_t)n;
    read_text(port, port->device_descriptor[14], port->manufacturer);
    read_text(port, port->device_descriptor[15], port->product);
    read_text(port, port->device_descriptor[16], port->serial);
    if (pal_bus_control(port, TO_DEVICE, SET_CONFIGURATION, port->configuration[5], 0, NULL, 0) < 0)
        return false;
    bus->last_number = port->number;
    return true;
}

static uint64_t clock_us(clockid_t clock) {
    struct timespec now;
    (void)clock_gettime(clock, &now);
    return (uint64_t)now.tv_sec * 1000000U + (uint64_t)now.tv_nsec / 1000U;
}

static uint64_t monotonic_us(void) {
    return clock_us(CLOCK_MONOTONIC);
}

bool pal_bus_init(pal_bus* bus, const pal_usb_device_config* configs, uint32_t n_configs,
                  pal_host_timing timing, uint32_t packets_per_frame, uint32_t* bad) {
    memset(bus, 0, sizeof *bus);
    bus->begin_us = monotonic_us();
    bus->last_number = NUMBER_MIN - 1;
    for (uint32_t i = 0; i < n_configs && i < PAL_BUS_DEVICES_MAX; ++i) {
        pal_bus_port* port = &bus->ports[i];
        *bad = i;
        if (!pal_usb_device_init(&port->device, &configs[i])) return false;
        const pal_host_device wire = pal_host_device_of(&port->device);
        pal_host_init(&port->host, &wire, timing, packets_per_frame);
        ++bus->n_ports;
    }
    return true;
}

static void see(void* context, pal_urb* urb, uint64_t now_us) {
    const pal_bus_port* port = context;
    pal_usbmon_see(port->capture, (uint8_t)port->number, urb, now_us);
}

bool pal_bus_capture(pal_bus* bus, pal_usbmon* capture, const char* file) {
    const uint64_t age_us = monotonic_us() - bus->begin_us;
    if (!pal_usbmon_open(capture, file, clock_us(CLOCK_REALTIME) - age_us)) return false;
    for (uint32_t i = 0; i < bus->n_ports; ++i) {
        bus->ports[i].capture = capture;
        pal_host_watch(&bus->ports[i].host, see, &bus->ports[i]);
    }
    return true;
}

void pal_bus_advance(pal_bus* bus) {
    uint64_t now_us = monotonic_us() - bus->begin_us - bus->lost_us;
    if (now_us - bus->now_us > CATCH_UP_US) {
        bus->lost_us += now_us - bus->now_us - CATCH_UP_US;
        now_us = bus->now_us + CATCH_UP_US;
    }
    bus->now_us = now_us;
    for (uint32_t i = 0; i < bus->n_ports; ++i) pal_host_advance(&bus->ports[i].host, now_us);
}

uint64_t pal_bus_wait_us(const pal_bus* bus, uint64_t most_us) {
    const uint64_t elapsed_us = monotonic_us() - bus->begin_us - bus->lost_us - bus->now_us;
    uint64_t wait_us = most_us;
    for (uint32_t i = 0; i < bus->n_ports; ++i) {
        const uint64_t at_us = pal_host_next_us(&bus->ports[i].host);
        const uint64_t left_us = at_us > bus->now_us ? at_us - bus->now_us : 0;
        const uint64_t still_us = left_us > elapsed_us ? left_us - elapsed_us : 0;
        if (still_us < wait_us) wait_us = still_us;
    }
    return wait_us;
}

int pal_bus_look(pal_bus* bus, uint32_t port_index) {
    pal_bus_port* port = &bus->ports[port_index];
    const bool there = pal_usb_device_present(&port->device);
    if (there == port->present) return 0;
    if (!there) {
        pal_host_end(&port->host, NULL, PAL_HOST_GONE);
        port->present = false;
        return -1;
    }
    port->present = enumerate(bus, port);
    return port->present ? 1 : 0;
}
