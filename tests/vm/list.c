// What libusb says of every Falcon it finds, one line each, the strings by the device's own requests.
// Exit 0 when there is one, 1 when there is none, 2 when one could not be read.
#include <libusb.h>
#include <stdio.h>

enum { VENDOR = 0x0403, PRODUCT = 0xCB48, TEXT_BYTES = 128 };

static int text(libusb_device_handle* handle, uint8_t index, char out[TEXT_BYTES]) {
    return libusb_get_string_descriptor_ascii(handle, index, (unsigned char*)out, TEXT_BYTES);
}

/// 0, or a libusb error.
static int print(libusb_device* device, const struct libusb_device_descriptor* d) {
    struct libusb_config_descriptor* config = NULL;
    libusb_device_handle* handle = NULL;
    char product[TEXT_BYTES];
    char serial[TEXT_BYTES];
    int code = libusb_open(device, &handle);
    if (code == 0) code = libusb_get_active_config_descriptor(device, &config);
    if (code == 0) {
        code = text(handle, d->iProduct, product);
        if (code > 0) code = text(handle, d->iSerialNumber, serial);
    }
    if (code > 0) {
        printf("%04x:%04x release %04x speed %d product \"%s\" serial \"%s\"", d->idVendor, d->idProduct,
               d->bcdDevice, libusb_get_device_speed(device), product, serial);
        const struct libusb_interface_descriptor* face = &config->interface[0].altsetting[0];
        for (int i = 0; i < face->bNumEndpoints; ++i) {
            const struct libusb_endpoint_descriptor* e = &face->endpoint[i];
            printf(" endpoint %02x %s %d", e->bEndpointAddress, (e->bmAttributes & 3) == 2 ? "bulk" : "other",
                   e->wMaxPacketSize);
        }
        printf("\n");
        code = 0;
    }
    if (config) libusb_free_config_descriptor(config);
    if (handle) libusb_close(handle);
    return code;
}

int main(void) {
    libusb_device** devices = NULL;
    int n_falcons = 0;
    int code = libusb_init(NULL);
    const ssize_t n = code == 0 ? libusb_get_device_list(NULL, &devices) : code;
    if (n < 0) code = (int)n;
    for (ssize_t i = 0; i < n && code == 0; ++i) {
        struct libusb_device_descriptor d;
        code = libusb_get_device_descriptor(devices[i], &d);
        if (code != 0 || d.idVendor != VENDOR || d.idProduct != PRODUCT) continue;
        ++n_falcons;
        code = print(devices[i], &d);
    }
    if (n >= 0) libusb_free_device_list(devices, 1);
    if (code != 0) {
        fprintf(stderr, "list: %s\n", libusb_error_name(code));
        return 2;
    }
    libusb_exit(NULL);
    return n_falcons > 0 ? 0 : 1;
}
