// A Falcon by libusb alone, as a newcomer would write it: boot with a synthetic image (docs/PROTOCOL.md 4),
// then N exchanges. Usage: plain N. Exit 0 when all were answered well; otherwise 1 and a sentence.
#include <libusb.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MS = 1000 };
static const uint8_t IMAGE[32] = {0xAA, 0x08, [18] = 0x3F, 0x00, 0x02, 0x80,
                                  0x01, 0x00, 0x3F,        0x00, 0x02, 0x80};
static libusb_device_handle* device;

static void fail(const char* what, int code) {
    fprintf(stderr, "plain: %s: %s\n", what, libusb_error_name(code));
    exit(1);
}

static void request(uint8_t what, uint16_t value) {
    const int code = libusb_control_transfer(device, 0x40, what, value, 0, NULL, 0, MS);
    if (code != 0) fail("request", code);
}

static void out(const uint8_t* bytes, int n) {
    int moved = 0;
    const int code = libusb_bulk_transfer(device, 0x02, (uint8_t*)bytes, n, &moved, MS);
    if (code != 0 || moved != n) fail("write", code);
}

/// Payload until `n` bytes are there.
static void in(uint8_t* bytes, int n) {
    for (int got = 0, reads = 0; got < n;) {
        uint8_t packet[64];
        int moved = 0;
        const int code = libusb_bulk_transfer(device, 0x81, packet, sizeof packet, &moved, MS);
        if (code != 0 || ++reads > 50) fail("read", code);
        for (int i = 2; i < moved && got < n; ++i) bytes[got++] = packet[i];
    }
}

static void boot(void) {
    uint8_t answer[sizeof IMAGE];
    request(0x00, 1), request(0x00, 2);                                   // purge
    request(0x09, 16), request(0x03, 0x4138);                             // latency, 9600 baud
    request(0x04, 8), request(0x02, 0);                                   // 8N1, no flow control
    request(0x01, 0x0200), request(0x01, 0x0100), request(0x01, 0x0101);  // RTS low, DTR low, DTR high
    out((const uint8_t*)"\nC\r", 3);
    in(answer, 4);
    if (memcmp(answer, "\nD,\r", 4) != 0) fail("the PIC's answer", LIBUSB_ERROR_OTHER);
    request(0x01, 0x0100), request(0x03, 0x0015);  // DTR low, 142857 baud
    out((const uint8_t*)"A", 1);
    in(answer, 1);
    if (answer[0] != 'A') fail("the ROM's echo", LIBUSB_ERROR_OTHER);
    out(IMAGE, sizeof IMAGE);
    in(answer, sizeof IMAGE);
    if (memcmp(answer, IMAGE, sizeof IMAGE) != 0) fail("the echo of the image", LIBUSB_ERROR_OTHER);
    request(0x09, 1), request(0x03, 2);  // latency 1 ms, 1.5 Mbaud
    request(0x00, 1), request(0x00, 2);
}

int main(int argc, char** argv) {
    const long n = argc > 1 ? strtol(argv[1], NULL, 10) : 60;
    libusb_init(NULL);
    device = libusb_open_device_with_vid_pid(NULL, 0x0403, 0xCB48);
    if (!device) fail("open", LIBUSB_ERROR_NO_DEVICE);
    int code = libusb_claim_interface(device, 0);
    if (code != 0) fail("claim", code);
    boot();
    for (long i = 0; i < n; ++i) {
        uint8_t answer[16];
        out((const uint8_t*)"<AAAAAAAAAAAAAA>", 16);
        in(answer, 16);
        if (answer[0] != '<' || answer[15] != '>') fail("an answer without its frame", LIBUSB_ERROR_OTHER);
    }
    printf("plain: %ld exchanges\n", n);
    libusb_release_interface(device, 0);
    libusb_close(device);
    libusb_exit(NULL);
    return 0;
}
