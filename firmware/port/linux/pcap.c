#include "firmware/port/linux/pcap.h"

#include <string.h>

enum {
    MAJOR = 2,
    MINOR = 4,
    SNAP_BYTES = 65535,
    XFER_CONTROL = 2,  // of usbmon
    XFER_BULK = 3,
    RECORD_BYTES = 16
};

static const uint32_t MAGIC = 0xA1B2C3D4;  // microseconds, native byte order

static void put(uint8_t* at, const void* value, size_t n_bytes) {
    memcpy(at, value, n_bytes);
}

static void put32(uint8_t* at, uint32_t value) {
    put(at, &value, sizeof value);
}

bool pal_pcap_open(pal_pcap* pcap, const char* path) {
    uint8_t header[PAL_PCAP_FILE_HEADER_BYTES] = {0};
    const uint16_t version[2] = {MAJOR, MINOR};
    pcap->failed = false;
    pcap->file = fopen(path, "wbe");
    if (pcap->file == NULL) return false;
    put32(header, MAGIC);
    put(header + 4, version, sizeof version);
    put32(header + 16, SNAP_BYTES);
    put32(header + 20, PAL_PCAP_LINK_TYPE);
    pcap->failed = fwrite(header, sizeof header, 1, pcap->file) != 1;
    return true;
}

// struct usbmon_packet of Documentation/usb/usbmon.rst in the Linux sources.
static void header_of(const pal_pcap_record* r, uint32_t n_kept, uint8_t h[PAL_PCAP_HEADER_BYTES]) {
    const bool in = (r->endpoint & 0x80U) != 0;
    const uint16_t bus = r->bus;
    const int64_t s = (int64_t)(r->time_us / 1000000U);
    memset(h, 0, PAL_PCAP_HEADER_BYTES);
    put(h, &r->id, sizeof r->id);
    h[8] = (uint8_t)r->event;
    h[9] = (r->endpoint & 0x7FU) == 0 ? XFER_CONTROL : XFER_BULK;
    h[10] = r->endpoint;
    h[11] = r->address;
    put(h + 12, &bus, sizeof bus);
    h[14] = r->setup != NULL ? 0 : '-';
    h[15] = r->data != NULL ? 0 : in ? '<' : '>';
    put(h + 16, &s, sizeof s);
    put32(h + 24, (uint32_t)(r->time_us % 1000000U));
    put(h + 28, &r->status, sizeof r->status);
    put32(h + 32, r->n_bytes);
    put32(h + 36, n_kept);
    if (r->setup != NULL) put(h + 40, r->setup, 8);
}

void pal_pcap_write(pal_pcap* pcap, const pal_pcap_record* record) {
    if (pcap == NULL || pcap->file == NULL || pcap->failed) return;
    const uint32_t n_kept = record->data != NULL ? record->n_bytes : 0;
    uint8_t head[RECORD_BYTES + PAL_PCAP_HEADER_BYTES];
    put32(head, (uint32_t)(record->time_us / 1000000U));
    put32(head + 4, (uint32_t)(record->time_us % 1000000U));
    put32(head + 8, PAL_PCAP_HEADER_BYTES + n_kept);
    put32(head + 12, PAL_PCAP_HEADER_BYTES + n_kept);
    header_of(record, n_kept, head + RECORD_BYTES);
    pcap->failed = fwrite(head, sizeof head, 1, pcap->file) != 1 ||
                   (n_kept > 0 && fwrite(record->data, n_kept, 1, pcap->file) != 1);
}

bool pal_pcap_close(pal_pcap* pcap) {
    if (pcap->file == NULL) return true;
    const bool closed = fclose(pcap->file) == 0;
    pcap->file = NULL;
    return closed && !pcap->failed;
}
