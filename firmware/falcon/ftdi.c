#include "firmware/falcon/ftdi.h"

enum { EIGHTHS = 8, CODE_SHIFT = 14 };

pal_usb_step pal_ftdi_control(pal_ftdi_request request, uint16_t value) {
    pal_usb_step step = {PAL_USB_CONTROL, (uint8_t)request, value, 0, NULL, 0, 0};
    return step;
}

pal_usb_step pal_ftdi_idle(uint32_t wake_us) {
    pal_usb_step step = {PAL_USB_IDLE, 0, 0, 0, NULL, 0, wake_us};
    return step;
}

// The divisor in eighths. Below 2 the chip knows 1 and 1 1/2 only.
static uint32_t divisor_eighths(uint32_t baud) {
    uint32_t rate = baud < PAL_FTDI_BAUD_MIN ? (uint32_t)PAL_FTDI_BAUD_MIN : baud;
    if (rate > PAL_FTDI_BAUD_MAX) rate = PAL_FTDI_BAUD_MAX;
    const uint32_t eighths = (PAL_FTDI_CHIP_HZ * (uint32_t)EIGHTHS + rate / 2U) / rate;
    if (eighths < 10) return 8;
    if (eighths < 14) return 12;
    return eighths < 16 ? 16 : eighths;
}

pal_usb_step pal_ftdi_baud(uint32_t baud) {
    static const uint8_t CODE[EIGHTHS] = {0, 3, 2, 4, 1, 5, 6, 7};
    const uint32_t eighths = divisor_eighths(baud);
    pal_usb_step step = pal_ftdi_control(PAL_FTDI_BAUD_RATE, 0);
    if (eighths == 8) return step;  // 3 Mbaud
    if (eighths == 12) {            // 2 Mbaud
        step.value = 1;
        return step;
    }
    const uint32_t code = CODE[eighths % EIGHTHS];
    step.value = (uint16_t)(eighths / EIGHTHS | (code & 3U) << CODE_SHIFT);
    step.index = (uint16_t)(code >> 2U);
    return step;
}

uint32_t pal_ftdi_real_baud(uint32_t baud) {
    const uint32_t eighths = divisor_eighths(baud);
    return (PAL_FTDI_CHIP_HZ * (uint32_t)EIGHTHS + eighths / 2U) / eighths;
}

bool pal_ftdi_next_packet(const uint8_t* transfer, size_t n_bytes, size_t* n_taken_bytes,
                          pal_ftdi_payload* out) {
    if (*n_taken_bytes >= n_bytes) return false;
    const uint8_t* packet = transfer + *n_taken_bytes;
    size_t n_packet = n_bytes - *n_taken_bytes;
    if (n_packet > PAL_FTDI_PACKET_BYTES) n_packet = PAL_FTDI_PACKET_BYTES;
    *n_taken_bytes += n_packet;
    const bool whole = n_packet >= PAL_FTDI_STATUS_BYTES;
    out->bytes = whole ? packet + PAL_FTDI_STATUS_BYTES : packet;
    out->n_bytes = whole ? n_packet - PAL_FTDI_STATUS_BYTES : 0;
    out->line_errors = whole ? (uint8_t)(packet[1] & PAL_FTDI_LINE_ERRORS) : 0;
    return true;
}
