/// The simulated devices of one process, each behind its own host controller, and their clock: microseconds
/// of CLOCK_MONOTONIC since the bus began. The front ends (usbfs_server.h, usbip.h) move URBs in and out.
#pragma once
#include <stdbool.h>
#include <stdint.h>

#include "sim/falcon/usb_device.h"
#include "sim/usb/host_controller.h"
#include "sim/usb/pcap.h"
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_BUS_DEVICES_MAX = 8, PAL_BUS_TEXT_BYTES = 128, PAL_BUS_DESCRIPTOR_BYTES = 512 };

/// One port with its device.
typedef struct pal_bus_port {
    pal_usb_device device;
    pal_host host;
    bool present;     ///< enumerated and not unplugged since
    uint32_t number;  ///< address on the bus, a new one after each plug; 2..127
    /// As the device told when it was plugged in.
    uint8_t device_descriptor[18];
    uint8_t configuration[PAL_BUS_DESCRIPTOR_BYTES];
    uint32_t n_configuration;
    char manufacturer[PAL_BUS_TEXT_BYTES], product[PAL_BUS_TEXT_BYTES], serial[PAL_BUS_TEXT_BYTES];
    pal_usbmon* capture;  ///< NULL: none
} pal_bus_port;

typedef struct pal_bus {
    pal_bus_port ports[PAL_BUS_DEVICES_MAX];
    uint32_t n_ports;
    uint32_t last_number;
    uint64_t begin_us;  ///< of CLOCK_MONOTONIC
    uint64_t lost_us;   ///< time that passed while the process did not run, beyond what is caught up
    uint64_t now_us;
} pal_bus;

/// One device for each configuration. False when one makes no sense, its index in *bad.
bool pal_bus_init(pal_bus* bus, const pal_usb_device_config* configs, uint32_t n_configs,
                  pal_host_timing timing, uint32_t packets_per_frame, uint32_t* bad);
/// Begins a capture of all that passes to FILE, until pal_usbmon_close. False: errno says why.
bool pal_bus_capture(pal_bus* bus, pal_usbmon* capture, const char* file);
/// Reads the clock and brings every device and controller up to it. A long stop of the process is left out.
void pal_bus_advance(pal_bus* bus);
/// Microseconds until advance has something to do; at most `most_us`.
uint64_t pal_bus_wait_us(const pal_bus* bus, uint64_t most_us);
/// Compares `present` with the device: +1 plugged in (and enumerated) just now, -1 unplugged just now, 0 as
/// before.
int pal_bus_look(pal_bus* bus, uint32_t port);
/// A control request outside any queue, as hub and kernel make them. Bytes, PAL_HOST_DEVICE_*.
int pal_bus_control(pal_bus_port* port, uint8_t type, uint8_t request, uint16_t value, uint16_t index,
                    uint8_t* data, uint16_t n_bytes);

#ifdef __cplusplus
}
#endif
