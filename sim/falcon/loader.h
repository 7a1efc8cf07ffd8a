/// What boots the Falcon: the PIC, which owns the serial line while DTR is high and resets the DSP, and the
/// DSP's boot ROM, which echoes every byte of a container (TI SPRU095C) and runs it. Neither has a time-out.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "sim/falcon/faults.h"
#ifdef __cplusplus
extern "C" {
#endif

/// Serial bit times are counted in clocks of 24 MHz: every divisor of the bridge is a whole number of them.
enum {
    PAL_UART_CLOCKS_PER_US = 24,
    PAL_UART_PIC_CLOCKS_PER_BIT = 2500,  ///< 9600 baud
    PAL_UART_RUN_CLOCKS_PER_BIT = 16,    ///< 1.5 Mbaud
    PAL_UART_BITS_PER_BYTE = 10,         ///< 8N1
    PAL_LOADER_ANSWER_MAX = 8
};

/// Where a boot-fail fault strikes.
typedef enum pal_boot_stage {
    PAL_BOOT_FAIL_PIC_SILENT = 1,   ///< the request is not answered, the DSP goes on as it was
    PAL_BOOT_FAIL_PIC_WRONG,        ///< the answer has a wrong byte, the DSP goes on as it was
    PAL_BOOT_FAIL_AUTOBAUD_SILENT,  ///< 'A' is not locked on and not echoed; the ROM waits for the next one
    PAL_BOOT_FAIL_AUTOBAUD_WRONG,   ///< the echo of 'A' is another byte; mute from then on
    PAL_BOOT_FAIL_ECHO_WRONG,       ///< one byte of the container is taken and echoed wrong
    PAL_BOOT_FAIL_ECHO_SILENT,      ///< mute from one byte of the container on
    PAL_BOOT_FAIL_NO_START          ///< all is echoed, nothing runs: mute
} pal_boot_stage;

/// What no source tells is an option.
typedef struct pal_loader_config {
    bool zero_before_answer;      ///< the first answer after DTR rose comes after a byte 00
    bool xoff_before_echo;        ///< the echo of 'A' comes after a byte 13
    uint32_t pic_answer_us;       ///< between the end of the request and the begin of its answer
    uint32_t autobaud_sure_baud;  ///< up to here autobaud always locks; TI: about 100000
    uint32_t autobaud_max_baud;   ///< beyond it never; assumed 1000000: probes at run speed stay unanswered
    uint32_t autobaud_fail_per_million;  ///< in between it fails with this probability
    uint32_t start_us;                   ///< between the container's last byte and the firmware's first ear
} pal_loader_config;

typedef enum pal_dsp_state {
    PAL_DSP_OFF,       ///< no supply
    PAL_DSP_AUTOBAUD,  ///< ROM, waits for 'A' at any baud
    PAL_DSP_LOAD,      ///< ROM, within a container
    PAL_DSP_MUTE,      ///< gave up; only the PIC helps
    PAL_DSP_RUN        ///< run-time firmware
} pal_dsp_state;

/// Where in a container the ROM is.
typedef struct pal_container {
    uint32_t n_bytes;      ///< taken so far
    uint32_t word_left;    ///< words until the present part ends
    uint32_t block_words;  ///< of the present block
    uint8_t part;          ///< private
    uint8_t low;           ///< first byte of the present word
} pal_container;

typedef enum pal_container_news {
    PAL_CONTAINER_MORE,
    PAL_CONTAINER_BAD_KEY,
    PAL_CONTAINER_COMPLETE
} pal_container_news;

void pal_container_begin(pal_container* container);
/// Takes the next byte.
pal_container_news pal_container_take(pal_container* container, uint8_t byte);

typedef struct pal_loader {
    pal_loader_config config;
    pal_dsp_state dsp;
    uint32_t clocks_per_bit;  ///< of the DSP
    pal_container container;
    uint64_t random;
    uint32_t n_handshakes, n_boots;
    uint8_t n_matched;  ///< of the PIC's request
    bool dtr;
    bool answered;  ///< since DTR rose
} pal_loader;

/// One byte as it ends on the line.
typedef struct pal_line_byte {
    uint32_t clocks_per_bit;
    uint8_t byte;
    bool frame_ok;  ///< 8N1
} pal_line_byte;

typedef struct pal_loader_answer {
    uint8_t bytes[PAL_LOADER_ANSWER_MAX];
    uint8_t n_bytes;
    uint32_t clocks_per_bit;
    uint32_t after_us;
    bool reset;    ///< the PIC has reset the DSP: its firmware, if any, is gone
    bool started;  ///< the firmware begins to run
    bool struck;   ///< `fail` did its work
} pal_loader_answer;

/// Both are powered; the ROM waits for autobaud.
void pal_loader_init(pal_loader* loader, const pal_loader_config* config, uint64_t seed);
/// The supply comes (ROM) or goes (nothing answers, the firmware is lost).
void pal_loader_power(pal_loader* loader, bool on);
void pal_loader_set_dtr(pal_loader* loader, bool high);
/// A byte for the PIC or the DSP: in state PAL_DSP_RUN with DTR low it is not for the loader. `fail` may be
/// NULL.
pal_loader_answer pal_loader_receive(pal_loader* loader, pal_line_byte in, const pal_usb_fault* fail);
/// Clocks at a time.
static inline uint64_t pal_uart_clock(uint64_t us) {
    return us * PAL_UART_CLOCKS_PER_US;
}
/// Whether two ends with these bit times understand each other (within 3 %).
bool pal_uart_same_baud(uint32_t clocks_per_bit, uint32_t other_clocks_per_bit);
/// A byte as an end with another baud reads it: never the byte itself.
uint8_t pal_uart_garbled(uint8_t byte, uint64_t* random);

#ifdef __cplusplus
}
#endif
