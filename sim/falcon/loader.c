#include "sim/falcon/loader.h"

#include <string.h>

#include "sim/falcon/random.h"

static const uint8_t REQUEST[3] = {0x0A, 0x43, 0x0D};       // LF 'C' CR
static const uint8_t ANSWER[4] = {0x0A, 0x44, 0x2C, 0x0D};  // LF 'D' ',' CR
enum {
    KEY = 0x08AA,
    RESERVED_WORDS = 8,
    XOFF = 0x13,
    WRONG = 0xFF,
    CLOCKS_PER_S = 24000000,
    MILLION = 1000000
};
enum { PART_KEY, PART_RESERVED, PART_ENTRY, PART_SIZE, PART_DESTINATION, PART_DATA };

uint8_t pal_uart_garbled(uint8_t byte, uint64_t* random) {
    return (uint8_t)(byte ^ (1 + pal_sim_random(random) % 255));
}

bool pal_uart_same_baud(uint32_t clocks_per_bit, uint32_t other_clocks_per_bit) {
    const uint64_t a = clocks_per_bit;
    const uint64_t b = other_clocks_per_bit;
    return 100 * a <= 103 * b && 100 * b <= 103 * a;
}

void pal_container_begin(pal_container* container) {
    memset(container, 0, sizeof *container);
    container->word_left = 1;
}

static void next_part(pal_container* c, uint8_t part, uint32_t n_words) {
    c->part = part;
    c->word_left = n_words;
}

static pal_container_news part_done(pal_container* c, uint16_t word) {
    switch (c->part) {
        case PART_KEY:
            if (word != KEY) return PAL_CONTAINER_BAD_KEY;
            next_part(c, PART_RESERVED, RESERVED_WORDS);
            break;
        case PART_RESERVED:
            next_part(c, PART_ENTRY, 2);
            break;
        case PART_SIZE:
            if (word == 0) return PAL_CONTAINER_COMPLETE;
            c->block_words = word;
            next_part(c, PART_DESTINATION, 2);
            break;
        case PART_DESTINATION:
            next_part(c, PART_DATA, c->block_words);
            break;
        default:  // entry point, data
            next_part(c, PART_SIZE, 1);
            break;
    }
    return PAL_CONTAINER_MORE;
}

pal_container_news pal_container_take(pal_container* container, uint8_t byte) {
    const bool high = container->n_bytes % 2 == 1;
    ++container->n_bytes;
    if (!high) {
        container->low = byte;
        return PAL_CONTAINER_MORE;
    }
    if (--container->word_left > 0) return PAL_CONTAINER_MORE;
    return part_done(container, (uint16_t)(container->low | byte << 8));
}

void pal_loader_init(pal_loader* loader, const pal_loader_config* config, uint64_t seed) {
    memset(loader, 0, sizeof *loader);
    loader->config = *config;
    loader->random = seed;
    pal_loader_power(loader, true);
}

void pal_loader_power(pal_loader* loader, bool on) {
    loader->dsp = on ? PAL_DSP_AUTOBAUD : PAL_DSP_OFF;
    loader->n_matched = 0;
    loader->answered = false;
}

void pal_loader_set_dtr(pal_loader* loader, bool high) {
    if (high == loader->dtr) return;
    loader->dtr = high;
    loader->n_matched = 0;
    loader->answered = false;
}

static bool fails_at(const pal_usb_fault* fail, pal_boot_stage stage) {
    return fail && fail->stage == stage;
}

static void say(pal_loader_answer* answer, uint8_t byte) {
    answer->bytes[answer->n_bytes++] = byte;
}

static uint8_t read_as(pal_loader* l, pal_line_byte in, uint32_t clocks_per_bit) {
    if (in.frame_ok && pal_uart_same_baud(in.clocks_per_bit, clocks_per_bit)) return in.byte;
    return pal_uart_garbled(in.byte, &l->random);
}

static void pic_receive(pal_loader* l, pal_line_byte in, const pal_usb_fault* fail,
                        pal_loader_answer* answer) {
    const uint8_t byte = read_as(l, in, PAL_UART_PIC_CLOCKS_PER_BIT);
    if (byte != REQUEST[l->n_matched]) l->n_matched = 0;
    if (byte == REQUEST[l->n_matched]) ++l->n_matched;
    if (l->n_matched < sizeof REQUEST) return;
    l->n_matched = 0;
    answer->struck = fails_at(fail, PAL_BOOT_FAIL_PIC_SILENT) || fails_at(fail, PAL_BOOT_FAIL_PIC_WRONG);
    if (fails_at(fail, PAL_BOOT_FAIL_PIC_SILENT)) return;
    answer->clocks_per_bit = PAL_UART_PIC_CLOCKS_PER_BIT;
    answer->after_us = l->config.pic_answer_us;
    if (l->config.zero_before_answer && !l->answered) say(answer, 0);
    l->answered = true;
    for (size_t i = 0; i < sizeof ANSWER; ++i) say(answer, ANSWER[i]);
    if (answer->struck) {
        answer->bytes[answer->n_bytes - 2] ^= WRONG;
        return;
    }
    ++l->n_handshakes;
    l->dsp = PAL_DSP_AUTOBAUD;
    answer->reset = true;
}

/// Whether the ROM measures the baud of this byte rightly.
static bool locks(pal_loader* l, pal_line_byte in) {
    if (!in.frame_ok || (in.byte != 'A' && in.byte != 'a')) return false;
    const uint32_t baud = CLOCKS_PER_S / in.clocks_per_bit;
    if (baud <= l->config.autobaud_sure_baud) return true;
    if (baud > l->config.autobaud_max_baud) return false;
    return pal_sim_random(&l->random) % MILLION >= l->config.autobaud_fail_per_million;
}

static void autobaud(pal_loader* l, pal_line_byte in, const pal_usb_fault* fail, pal_loader_answer* answer) {
    if (!locks(l, in)) return;
    if (fails_at(fail, PAL_BOOT_FAIL_AUTOBAUD_SILENT)) {
        answer->struck = true;
        return;
    }
    l->clocks_per_bit = answer->clocks_per_bit = in.clocks_per_bit;
    if (l->config.xoff_before_echo) say(answer, XOFF);
    if (fails_at(fail, PAL_BOOT_FAIL_AUTOBAUD_WRONG)) {
        answer->struck = true;
        say(answer, in.byte ^ WRONG);
        l->dsp = PAL_DSP_MUTE;
        return;
    }
    say(answer, in.byte);
    l->dsp = PAL_DSP_LOAD;
    pal_container_begin(&l->container);
}

static void load(pal_loader* l, pal_line_byte in, const pal_usb_fault* fail, pal_loader_answer* answer) {
    uint8_t byte = read_as(l, in, l->clocks_per_bit);
    const bool here = fail && l->container.n_bytes == fail->byte;
    if (here && fails_at(fail, PAL_BOOT_FAIL_ECHO_SILENT)) {
        answer->struck = true;
        l->dsp = PAL_DSP_MUTE;
        return;
    }
    if (here && fails_at(fail, PAL_BOOT_FAIL_ECHO_WRONG)) {
        answer->struck = true;
        byte ^= WRONG;
    }
    answer->clocks_per_bit = l->clocks_per_bit;
    say(answer, byte);
    const pal_container_news news = pal_container_take(&l->container, byte);
    if (news == PAL_CONTAINER_MORE) return;
    l->dsp = PAL_DSP_MUTE;
    if (news == PAL_CONTAINER_BAD_KEY) return;
    if (fails_at(fail, PAL_BOOT_FAIL_NO_START)) {
        answer->struck = true;
        return;
    }
    l->dsp = PAL_DSP_RUN;
    l->clocks_per_bit = PAL_UART_RUN_CLOCKS_PER_BIT;
    ++l->n_boots;
    answer->started = true;
}

pal_loader_answer pal_loader_receive(pal_loader* loader, pal_line_byte in, const pal_usb_fault* fail) {
    pal_loader_answer answer;
    memset(&answer, 0, sizeof answer);
    if (loader->dsp == PAL_DSP_OFF) return answer;
    if (loader->dtr) {
        pic_receive(loader, in, fail, &answer);
    } else if (loader->dsp == PAL_DSP_AUTOBAUD) {
        autobaud(loader, in, fail, &answer);
    } else if (loader->dsp == PAL_DSP_LOAD) {
        load(loader, in, fail, &answer);
    }
    return answer;
}
