// A Falcon by libftdi 1.x, which knows nothing of it: boot with a synthetic image, then N exchanges.
// Usage: ftdi N. Exit 0 when all were answered well; otherwise 1 and a sentence.
#include <ftdi.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const uint8_t IMAGE[32] = {0xAA, 0x08, [18] = 0x3F, 0x00, 0x02, 0x80,
                                  0x01, 0x00, 0x3F,        0x00, 0x02, 0x80};
static struct ftdi_context* ftdi;

static void must(const char* what, int code) {
    if (code >= 0) return;
    fprintf(stderr, "ftdi: %s: %d, %s\n", what, code, ftdi_get_error_string(ftdi));
    exit(1);
}

static void write_all(const char* bytes, int n) {
    must("write", ftdi_write_data(ftdi, (unsigned char*)bytes, n) == n ? 0 : -1);
}

static void read_all(uint8_t* bytes, int n) {
    for (int got = 0, reads = 0; got < n; ++reads) {
        const int more = ftdi_read_data(ftdi, bytes + got, n - got);
        must("read", reads < 1000 ? more : -1);
        got += more;
    }
}

static void boot(void) {
    uint8_t answer[sizeof IMAGE];
    must("reset", ftdi_usb_reset(ftdi));
    must("latency", ftdi_set_latency_timer(ftdi, 16));
    must("9600", ftdi_set_baudrate(ftdi, 9600));
    must("8N1", ftdi_set_line_property(ftdi, BITS_8, STOP_BIT_1, NONE));
    must("flow", ftdi_setflowctrl(ftdi, SIO_DISABLE_FLOW_CTRL));
    must("RTS", ftdi_setrts(ftdi, 0));
    must("DTR", ftdi_setdtr(ftdi, 0));
    must("DTR", ftdi_setdtr(ftdi, 1));
    write_all("\nC\r", 3);
    read_all(answer, 4);
    must("the PIC's answer", memcmp(answer, "\nD,\r", 4) == 0 ? 0 : -1);
    must("DTR", ftdi_setdtr(ftdi, 0));
    must("140000", ftdi_set_baudrate(ftdi, 140000));
    write_all("A", 1);
    read_all(answer, 1);
    must("the ROM's echo", answer[0] == 'A' ? 0 : -1);
    write_all((const char*)IMAGE, sizeof IMAGE);
    read_all(answer, sizeof IMAGE);
    must("the echo of the image", memcmp(answer, IMAGE, sizeof IMAGE) == 0 ? 0 : -1);
    must("latency", ftdi_set_latency_timer(ftdi, 1));
    must("1500000", ftdi_set_baudrate(ftdi, 1500000));
}

int main(int argc, char** argv) {
    const long n = argc > 1 ? strtol(argv[1], NULL, 10) : 60;
    ftdi = ftdi_new();
    must("open", ftdi_usb_open_desc(ftdi, 0x0403, 0xCB48, "FALCON HAPTIC", NULL));
    must("type R", ftdi->type == TYPE_R ? 0 : -1);
    boot();
    for (long i = 0; i < n; ++i) {
        uint8_t answer[16];
        write_all("<AAAAAAAAAAAAAA>", 16);
        read_all(answer, 16);
        must("an answer without its frame", answer[0] == '<' && answer[15] == '>' ? 0 : -1);
    }
    must("close", ftdi_usb_close(ftdi));
    must("open again", ftdi_usb_open_desc(ftdi, 0x0403, 0xCB48, "FALCON HAPTIC", NULL));
    must("close again", ftdi_usb_close(ftdi));
    ftdi_free(ftdi);
    printf("ftdi: %ld exchanges\n", n);
    return 0;
}
