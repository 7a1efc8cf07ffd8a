/// The simulated devices of the command line, each with its hand.
#pragma once
#include "sim/app/options.h"
#include "sim/app/path_file.h"

typedef struct pal_devices {
    pal_path_file path;
    pal_hand hands[PAL_BUS_DEVICES_MAX];
    pal_usb_fault faults[PAL_USB_FAULTS_MAX];
    pal_usb_device_config configs[PAL_BUS_DEVICES_MAX];
    uint32_t n;
} pal_devices;

/// The hand and mechanics as the options say. False with words in `why`.
bool pal_devices_hand(pal_options* options, pal_path_file* path, char* why, size_t n_why);
/// All devices. Serials count up from the first. `out` must stay where it is: the hands are pointed to.
bool pal_devices_make(pal_options* options, pal_devices* out, char* why, size_t n_why);
void pal_devices_free(pal_devices* devices);
