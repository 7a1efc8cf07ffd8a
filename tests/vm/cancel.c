// Reads that are cancelled at about the moment when the FT232R's latency timer answers them: libusb's
// time-outs of 1 to 6 ms against a timer of 4 ms. An answer must either come or not come; a host controller
// that does both, or neither, loses the device. Usage: cancel N. Exit 0 when both kinds came and the device
// still answers; otherwise 1.
#include <libusb.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

enum { MS = 1000, LATENCY_MS = 4, LONGEST_MS = 6, FEWEST = 20 };

static int fail(const char* what, int code) {
    fprintf(stderr, "cancel: %s: %s\n", what, libusb_error_name(code));
    return 1;
}

int main(int argc, char** argv) {
    const long n = argc > 1 ? strtol(argv[1], NULL, 10) : 400;
    long n_answered = 0;
    long n_cancelled = 0;
    uint8_t latency_ms = 0;
    libusb_init(NULL);
    libusb_device_handle* device = libusb_open_device_with_vid_pid(NULL, 0x0403, 0xCB48);
    int code = device ? libusb_claim_interface(device, 0) : LIBUSB_ERROR_NO_DEVICE;
    if (code == 0) code = libusb_control_transfer(device, 0x40, 0x09, LATENCY_MS, 0, NULL, 0, MS);
    if (code != 0) return fail("open", code);
    for (long i = 0; i < n; ++i) {
        uint8_t packet[64];
        int moved = 0;
        code =
            libusb_bulk_transfer(device, 0x81, packet, sizeof packet, &moved, (unsigned)(1 + i % LONGEST_MS));
        if (code != 0 && code != LIBUSB_ERROR_TIMEOUT) return fail("read", code);
        if (code == 0) ++n_answered;
        if (code != 0) ++n_cancelled;
    }
    code = libusb_control_transfer(device, 0xC0, 0x0A, 0, 0, &latency_ms, 1, MS);
    if (code != 1 || latency_ms != LATENCY_MS) return fail("the latency timer read back", code);
    printf("cancel: %ld answered, %ld cancelled\n", n_answered, n_cancelled);
    if (n_answered < FEWEST || n_cancelled < FEWEST) return fail("too few of one kind", LIBUSB_ERROR_OTHER);
    libusb_release_interface(device, 0);
    libusb_close(device);
    libusb_exit(NULL);
    return 0;
}
