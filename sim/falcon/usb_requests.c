// Chapter 9 requests, descriptors and the EEPROM of an FT232R in the Falcon's name.
#include <string.h>

#include "sim/falcon/usb_device_private.h"

enum {
    DIRECTION_IN = 0x80,
    TO_DEVICE = 0,
    TO_INTERFACE = 1,
    TO_ENDPOINT = 2,

    GET_STATUS = 0,
    CLEAR_FEATURE = 1,
    SET_FEATURE = 3,
    SET_ADDRESS = 5,
    GET_DESCRIPTOR = 6,
    GET_CONFIGURATION = 8,
    SET_CONFIGURATION = 9,
    GET_INTERFACE = 10,
    SET_INTERFACE = 11,

    FEATURE_HALT = 0,
    FEATURE_WAKEUP = 1,
    ADDRESS_MAX = 127,

    DESCRIPTOR_DEVICE = 1,
    DESCRIPTOR_CONFIGURATION = 2,
    DESCRIPTOR_STRING = 3,

    RELEASE_FT232R = 0x0600,
    ATTRIBUTES = 0xA0,  // from the bus, may wake the host
    POWER_2_MA = 45,    // 90 mA
    N_STRINGS = 3,

    EEPROM_VENDOR = 1,
    EEPROM_PRODUCT = 2,
    EEPROM_RELEASE = 3,
    EEPROM_POWER = 4,
    EEPROM_CHIP = 5,
    EEPROM_USB = 6,
    EEPROM_STRINGS = 7,        // three words: length and place
    EEPROM_STRINGS_AT = 0x18,  // bytes
    EEPROM_SUM = PAL_BRIDGE_EEPROM_WORDS - 1,
    EEPROM_SUM_BEGIN = 0xAAAA
};

static const char* string_of(const pal_usb_device* d, unsigned which) {
    if (which == 0) return d->config.manufacturer;
    return which == 1 ? d->config.product : d->config.serial;
}

static size_t length_of(const char* text) {
    size_t n = 0;
    while (n < PAL_USB_TEXT_BYTES && text[n] != '\0') ++n;
    return n;
}

/// USB's form: length, type, UTF-16. Returns bytes.
static size_t string_descriptor(const char* text, uint8_t out[2 + 2 * PAL_USB_TEXT_BYTES]) {
    const size_t n = length_of(text);
    out[0] = (uint8_t)(2 + 2 * n);
    out[1] = DESCRIPTOR_STRING;
    for (size_t i = 0; i < n; ++i) {
        out[2 + 2 * i] = (uint8_t)text[i];
        out[3 + 2 * i] = 0;
    }
    return 2 + 2 * n;
}

static void put_byte(uint16_t* words, size_t at, uint8_t byte) {
    const unsigned shift = at % 2 ? 8 : 0;
    words[at / 2] = (uint16_t)(words[at / 2] | byte << shift);
}

static uint16_t eeprom_sum(const uint16_t* words) {
    uint16_t sum = EEPROM_SUM_BEGIN;
    for (int i = 0; i < EEPROM_SUM; ++i) {
        sum ^= words[i];
        sum = (uint16_t)(sum << 1 | sum >> 15);
    }
    return sum;
}

bool pal_usb_fill_eeprom(pal_usb_device* device) {
    uint16_t* words = device->bridge.eeprom;
    memset(words, 0, sizeof device->bridge.eeprom);
    words[0] = 0x4000;  // as FTDI ships it
    words[EEPROM_VENDOR] = PAL_USB_VENDOR_ID;
    words[EEPROM_PRODUCT] = PAL_USB_PRODUCT_ID;
    words[EEPROM_RELEASE] = RELEASE_FT232R;
    words[EEPROM_POWER] = POWER_2_MA << 8 | ATTRIBUTES;
    words[EEPROM_CHIP] = 0x0008;  // serial number in use
    words[EEPROM_USB] = 0x0200;
    size_t at = EEPROM_STRINGS_AT;
    for (unsigned i = 0; i < N_STRINGS; ++i) {
        uint8_t text[2 + 2 * PAL_USB_TEXT_BYTES];
        const char* string = string_of(device, i);
        if (length_of(string) == PAL_USB_TEXT_BYTES) return false;  // it has no end
        const size_t n = string_descriptor(string, text);
        if (at + n > 2 * EEPROM_SUM) return false;
        words[EEPROM_STRINGS + i] = (uint16_t)(n << 8 | 0x80U | at);
        for (size_t k = 0; k < n; ++k) put_byte(words, at + k, text[k]);
        at += n;
    }
    words[EEPROM_SUM] = eeprom_sum(words);
    return true;
}

static int answer(const uint8_t* from, size_t n, uint8_t* data, size_t n_bytes) {
    const size_t fits = n < n_bytes ? n : n_bytes;
    if (fits > 0) memcpy(data, from, fits);
    return (int)fits;
}

static int get_string(const pal_usb_device* d, unsigned which, uint8_t* data, size_t n_bytes) {
    static const uint8_t LANGUAGES[4] = {4, DESCRIPTOR_STRING, 0x09, 0x04};  // English, United States
    if (which == 0) return answer(LANGUAGES, sizeof LANGUAGES, data, n_bytes);
    if (which > N_STRINGS) return PAL_USB_STALL;
    uint8_t text[2 + 2 * PAL_USB_TEXT_BYTES];
    return answer(text, string_descriptor(string_of(d, which - 1), text), data, n_bytes);
}

static int get_descriptor(const pal_usb_device* d, uint16_t value, uint8_t* data, size_t n_bytes) {
    static const uint8_t DEVICE[18] = {18,
                                       1,
                                       0x00,
                                       0x02,
                                       0,
                                       0,
                                       0,
                                       8,
                                       PAL_USB_VENDOR_ID & 0xFF,
                                       PAL_USB_VENDOR_ID >> 8,
                                       PAL_USB_PRODUCT_ID & 0xFF,
                                       PAL_USB_PRODUCT_ID >> 8,
                                       RELEASE_FT232R & 0xFF,
                                       RELEASE_FT232R >> 8,
                                       1,
                                       2,
                                       3,
                                       1};
    static const uint8_t CONFIGURATION[32] = {9,   2,          32,
                                              0,   1,          1,
                                              0,   ATTRIBUTES, POWER_2_MA,  // configuration 1, one interface
                                              9,   4,          0,
                                              0,   2,          255,
                                              255, 255,        2,  // interface 0, two endpoints, string 2
                                              7,   5,          PAL_USB_EP_IN,
                                              2,   64,         0,
                                              0,  // bulk
                                              7,   5,          PAL_USB_EP_OUT,
                                              2,   64,         0,
                                              0};
    const unsigned index = value & 0xFFU;
    switch (value >> 8) {
        case DESCRIPTOR_DEVICE:
            return index == 0 ? answer(DEVICE, sizeof DEVICE, data, n_bytes) : PAL_USB_STALL;
        case DESCRIPTOR_CONFIGURATION:
            return index == 0 ? answer(CONFIGURATION, sizeof CONFIGURATION, data, n_bytes) : PAL_USB_STALL;
        case DESCRIPTOR_STRING:
            return get_string(d, index, data, n_bytes);
        default:
            return PAL_USB_STALL;
    }
}

/// 0: no such endpoint.
static uint8_t endpoint_bit(uint16_t index) {
    if (index == PAL_USB_EP_IN) return PAL_USB_FAULT_EP_IN;
    return index == PAL_USB_EP_OUT ? PAL_USB_FAULT_EP_OUT : 0;
}

static int get_status(const pal_usb_device* d, unsigned recipient, uint16_t index, uint8_t* data,
                      size_t n_bytes) {
    uint8_t status[2] = {0, 0};
    const uint8_t endpoint = endpoint_bit(index);
    if (recipient == TO_DEVICE) {
        status[0] = d->remote_wakeup ? 2 : 0;
    } else if (recipient == TO_ENDPOINT && endpoint) {
        status[0] = pal_usb_halted(d, (pal_usb_fault_endpoint)endpoint) ? 1 : 0;
    } else if (!(recipient == TO_INTERFACE && index == 0) &&
               !(recipient == TO_ENDPOINT && (index & 0x7FU) == 0)) {
        return PAL_USB_STALL;
    }
    return answer(status, sizeof status, data, n_bytes);
}

static int set_feature(pal_usb_device* d, unsigned recipient, uint16_t feature, uint16_t index, bool on) {
    const uint8_t endpoint = endpoint_bit(index);
    if (recipient == TO_DEVICE && feature == FEATURE_WAKEUP) {
        d->remote_wakeup = on;
        return 0;
    }
    if (recipient != TO_ENDPOINT || feature != FEATURE_HALT || !endpoint) return PAL_USB_STALL;
    d->halted = (uint8_t)(on ? d->halted | endpoint : d->halted & ~endpoint);
    return 0;
}

static int set_configuration(pal_usb_device* d, uint16_t value) {
    if (value > 1) return PAL_USB_STALL;
    d->configuration = (uint8_t)value;
    d->halted = 0;
    return 0;
}

static int device_to_host(const pal_usb_device* d, const uint8_t setup[8], uint8_t* data, size_t n_bytes) {
    static const uint8_t ALTERNATE = 0;
    const unsigned recipient = setup[0] & 0x1FU;
    const uint16_t value = (uint16_t)(setup[2] | setup[3] << 8);
    const uint16_t index = (uint16_t)(setup[4] | setup[5] << 8);
    switch (setup[1]) {
        case GET_STATUS:
            return get_status(d, recipient, index, data, n_bytes);
        case GET_DESCRIPTOR:
            return recipient == TO_DEVICE ? get_descriptor(d, value, data, n_bytes) : PAL_USB_STALL;
        case GET_CONFIGURATION:
            return recipient == TO_DEVICE ? answer(&d->configuration, 1, data, n_bytes) : PAL_USB_STALL;
        case GET_INTERFACE:
            return recipient == TO_INTERFACE && index == 0 ? answer(&ALTERNATE, 1, data, n_bytes)
                                                           : PAL_USB_STALL;
        default:
            return PAL_USB_STALL;
    }
}

static int host_to_device(pal_usb_device* d, const uint8_t setup[8]) {
    const unsigned recipient = setup[0] & 0x1FU;
    const uint16_t value = (uint16_t)(setup[2] | setup[3] << 8);
    const uint16_t index = (uint16_t)(setup[4] | setup[5] << 8);
    switch (setup[1]) {
        case CLEAR_FEATURE:
            return set_feature(d, recipient, value, index, false);
        case SET_FEATURE:
            return set_feature(d, recipient, value, index, true);
        case SET_ADDRESS:
            // One device on its wire: what comes is for it, whatever its address.
            return recipient == TO_DEVICE && value <= ADDRESS_MAX ? 0 : PAL_USB_STALL;
        case SET_CONFIGURATION:
            return recipient == TO_DEVICE ? set_configuration(d, value) : PAL_USB_STALL;
        case SET_INTERFACE:
            return recipient == TO_INTERFACE && index == 0 && value == 0 ? 0 : PAL_USB_STALL;
        default:
            return PAL_USB_STALL;
    }
}

int pal_usb_standard_request(pal_usb_device* device, const uint8_t setup[8], uint8_t* data, size_t n_bytes) {
    return (setup[0] & DIRECTION_IN) ? device_to_host(device, setup, data, n_bytes)
                                     : host_to_device(device, setup);
}
