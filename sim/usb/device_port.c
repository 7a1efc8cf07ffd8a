#include "sim/usb/device_port.h"

static void device_advance(void* context, uint64_t now_us) {
    pal_usb_device_advance(context, now_us);
}
static uint64_t device_next_us(const void* context) {
    return pal_usb_device_next_us(context);
}
static int answer(int n) {
    if (n >= 0) return n;
    return n == PAL_USB_STALL ? PAL_HOST_DEVICE_STALLS : PAL_HOST_DEVICE_GONE;
}
static int device_control(void* context, const uint8_t setup[8], uint8_t* data, size_t n_bytes) {
    return answer(pal_usb_device_control(context, setup, data, n_bytes));
}
static int device_out(void* context, const uint8_t* bytes, size_t n_bytes) {
    return answer(pal_usb_device_out(context, bytes, n_bytes));
}
static int device_in(void* context, uint8_t packet[PAL_HOST_PACKET_BYTES]) {
    return answer(pal_usb_device_in(context, packet));
}
static bool device_present(const void* context) {
    return pal_usb_device_present(context);
}

pal_host_device pal_host_device_of(pal_usb_device* device) {
    return (pal_host_device){device,     device_advance, device_next_us, device_control,
                             device_out, device_in,      device_present};
}
