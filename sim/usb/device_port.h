/// The device model as a host controller wants it.
#pragma once
#include "sim/falcon/usb_device.h"
#include "sim/usb/host_controller.h"
#ifdef __cplusplus
extern "C" {
#endif

/// `device` is borrowed.
pal_host_device pal_host_device_of(pal_usb_device* device);

#ifdef __cplusplus
}
#endif
