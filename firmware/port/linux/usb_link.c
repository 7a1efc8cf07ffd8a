#include "firmware/port/linux/usb_link.h"

#include <fcntl.h>
#include <libusb.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "firmware/falcon/ftdi.h"

enum { PATH_BYTES = 128, PORTS_MAX = 7, INTERFACE = 0 };

// One line of an attribute of the device in sysfs: no transfer, no right to open needed.
static bool read_attribute(libusb_device* device, const char* name, char out[PAL_USB_TEXT_BYTES]) {
    uint8_t ports[PORTS_MAX];
    const int n_ports = libusb_get_port_numbers(device, ports, PORTS_MAX);
    if (n_ports <= 0) return false;
    char path[PATH_BYTES];
    int n =
        snprintf(path, sizeof path, "/sys/bus/usb/devices/%u-%u", libusb_get_bus_number(device), ports[0]);
    for (int i = 1; i < n_ports; ++i) {
        n += snprintf(path + n, sizeof path - (size_t)n, ".%u", ports[i]);
    }
    (void)snprintf(path + n, sizeof path - (size_t)n, "/%s", name);
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) return false;
    const ssize_t n_read = read(file, out, PAL_USB_TEXT_BYTES - 1);
    close(file);
    if (n_read <= 0) return false;
    out[n_read] = '\0';
    out[strcspn(out, "\n")] = '\0';
    return out[0] != '\0';
}

static void read_string(libusb_device* device, uint8_t index, char out[PAL_USB_TEXT_BYTES]) {
    libusb_device_handle* handle = NULL;
    out[0] = '\0';
    if (index == 0 || libusb_open(device, &handle) != 0) return;
    if (libusb_get_string_descriptor_ascii(handle, index, (unsigned char*)out, PAL_USB_TEXT_BYTES) < 0) {
        out[0] = '\0';
    }
    libusb_close(handle);
}

static uint16_t speed_of(libusb_device* device) {
    switch (libusb_get_device_speed(device)) {
        case LIBUSB_SPEED_LOW:
            return 1;
        case LIBUSB_SPEED_FULL:
            return 12;
        case LIBUSB_SPEED_HIGH:
            return 480;
        case LIBUSB_SPEED_SUPER:
            return 5000;
        default:
            return 0;
    }
}

void pal_usb_link_describe(struct libusb_device* device, pal_usb_found* about) {
    struct libusb_device_descriptor descriptor;
    memset(about, 0, sizeof *about);
    memset(&descriptor, 0, sizeof descriptor);
    (void)libusb_get_device_descriptor(device, &descriptor);
    about->bus = libusb_get_bus_number(device);
    about->address = libusb_get_device_address(device);
    about->speed_mbit_per_s = speed_of(device);
    (void)snprintf(about->node, sizeof about->node, "/dev/bus/usb/%03u/%03u", about->bus, about->address);
    if (!read_attribute(device, "serial", about->serial)) {
        read_string(device, descriptor.iSerialNumber, about->serial);
    }
    if (!read_attribute(device, "product", about->product)) {
        read_string(device, descriptor.iProduct, about->product);
    }
}

static pal_usb_problem problem_of(int error) {
    switch (error) {
        case LIBUSB_SUCCESS:
            return PAL_USB_OK;
        case LIBUSB_ERROR_ACCESS:
            return PAL_USB_DENIED;
        case LIBUSB_ERROR_BUSY:
            return PAL_USB_BUSY;
        case LIBUSB_ERROR_NO_DEVICE:
        case LIBUSB_ERROR_NOT_FOUND:
            return PAL_USB_NONE;
        default:
            return PAL_USB_FAILED;
    }
}

pal_usb_problem pal_usb_link_claim(struct libusb_device* device, struct libusb_device_handle** handle) {
    *handle = NULL;
    libusb_device_handle* opened = NULL;
    int error = libusb_open(device, &opened);
    if (error != 0) return problem_of(error);
    (void)libusb_set_auto_detach_kernel_driver(opened, 1);
    error = libusb_claim_interface(opened, INTERFACE);
    if (error == 0) {
        *handle = opened;
        return PAL_USB_OK;
    }
    libusb_close(opened);
    return problem_of(error);
}

static bool is_falcon(libusb_device* device) {
    struct libusb_device_descriptor descriptor;
    return libusb_get_device_descriptor(device, &descriptor) == 0 && descriptor.idVendor == PAL_FTDI_VENDOR &&
           descriptor.idProduct == PAL_FTDI_FALCON;
}

// -1: by serial `a` comes first.
static int order(const pal_usb_found* a, const pal_usb_found* b) {
    const int by_serial = strcmp(a->serial, b->serial);
    if (by_serial != 0) return by_serial;
    return a->bus != b->bus ? (int)a->bus - (int)b->bus : (int)a->address - (int)b->address;
}

// The wanted one of the list; NULL when it is not there.
static libusb_device* pick(libusb_device** list, const char* serial, pal_usb_found* about) {
    libusb_device* best = NULL;
    for (int i = 0; list[i] != NULL; ++i) {
        pal_usb_found other;
        if (!is_falcon(list[i])) continue;
        pal_usb_link_describe(list[i], &other);
        if (serial != NULL && strcmp(serial, other.serial) != 0) continue;
        if (best != NULL && order(about, &other) <= 0) continue;
        best = list[i];
        *about = other;
    }
    return best;
}

// Starts libusb and lists all devices. How many; negative, with nothing started and a sentence in `why`, when
// USB cannot be used.
static ssize_t start(libusb_context** context, libusb_device*** list, char why[PAL_USB_WORDS_BYTES]) {
    const int error = libusb_init(context);
    const ssize_t n = error == 0 ? libusb_get_device_list(*context, list) : error;
    if (n >= 0) return n;
    (void)snprintf(why, PAL_USB_WORDS_BYTES, "USB cannot be used on this machine: %s.",
                   libusb_strerror((int)n));
    if (error == 0) libusb_exit(*context);
    return n;
}

pal_usb_problem pal_usb_link_open(pal_usb_link* link, const char* serial, char why[PAL_USB_WORDS_BYTES]) {
    memset(link, 0, sizeof *link);
    libusb_device** list = NULL;
    if (start(&link->context, &list, why) < 0) {
        memset(link, 0, sizeof *link);
        return PAL_USB_FAILED;
    }
    libusb_device* device = pick(list, serial, &link->about);
    const pal_usb_problem problem = device == NULL ? PAL_USB_NONE : pal_usb_link_claim(device, &link->handle);
    libusb_free_device_list(list, 1);
    if (problem == PAL_USB_OK) return PAL_USB_OK;
    if (serial != NULL) (void)snprintf(link->about.serial, sizeof link->about.serial, "%s", serial);
    pal_usb_explain(problem, &link->about, why);
    libusb_exit(link->context);
    memset(link, 0, sizeof *link);
    return problem;
}

void pal_usb_link_close(pal_usb_link* link) {
    if (link->context == NULL) return;
    if (link->handle != NULL) {
        (void)libusb_release_interface(link->handle, INTERFACE);
        libusb_close(link->handle);
    }
    libusb_exit(link->context);
    memset(link, 0, sizeof *link);
}

// ---- usb_find.h

static void insert(pal_usb_found* found, int n, const pal_usb_found* one) {
    int at = n;
    for (; at > 0 && order(&found[at - 1], one) > 0; --at) found[at] = found[at - 1];
    found[at] = *one;
}

int pal_usb_find(pal_usb_found found[PAL_USB_DEVICES_MAX], char why[PAL_USB_WORDS_BYTES]) {
    libusb_context* context = NULL;
    libusb_device** list = NULL;
    const ssize_t n_all = start(&context, &list, why);
    if (n_all < 0) return -1;
    int n = 0;
    for (ssize_t i = 0; i < n_all && n < PAL_USB_DEVICES_MAX; ++i) {
        pal_usb_found one;
        libusb_device_handle* handle = NULL;
        if (!is_falcon(list[i])) continue;
        pal_usb_link_describe(list[i], &one);
        one.access = pal_usb_link_claim(list[i], &handle);
        if (handle != NULL) {
            (void)libusb_release_interface(handle, INTERFACE);
            libusb_close(handle);
        }
        if (one.access == PAL_USB_BUSY) pal_usb_who(one.node, one.user);
        insert(found, n, &one);
        n += 1;
    }
    libusb_free_device_list(list, 1);
    libusb_exit(context);
    return n;
}
