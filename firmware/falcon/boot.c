#include "firmware/falcon/boot.h"

enum {
    PIC_BAUD = 9600,
    RUN_BAUD = 1500000,
    EVENT_CHAR = 0x3E,  // the last byte of every reply
    AUTOBAUD_CHAR = 0x41,
    QUESTION_BYTES = 3,
    ANSWER_BYTES = 4
};
static const uint8_t QUESTION[QUESTION_BYTES] = {0x0A, 0x43, 0x0D};
static const uint8_t ANSWER[ANSWER_BYTES] = {0x0A, 0x44, 0x2C, 0x0D};
static const uint8_t AUTOBAUD[1] = {AUTOBAUD_CHAR};

pal_boot_config pal_boot_config_default(void) {
    pal_boot_config config = {
        .image = NULL,
        .n_image_bytes = 0,
        .reload = PAL_RELOAD_ALWAYS,
        .n_attempts = 6,
        .bauds = {142857, 142857, 115385, 57554},
        .n_bauds = 4,
        .dtr_low_us = 10000,
        .ask_wait_us = 100000,
        .n_asks = 25,
        .autobaud_wait_us = 100000,
        .echo_wait_us = 200000,
        .first_wait_us = 50000,
        .n_first = 20,
        .probe_wait_us = 100000,
        .boot_latency_ms = 16,
        .run_latency_ms = 2,
        .event_char = true,
    };
    return config;
}

static void enter(pal_boot* boot, pal_falcon_stage stage) {
    boot->stage = stage;
    boot->at = 0;
    boot->match = 0;
    boot->arming = false;
    boot->waiting = false;
}

static void start_attempt(pal_boot* boot) {
    boot->n_asked = 0;
    boot->n_sent_bytes = 0;
    boot->n_echoed_bytes = 0;
    enter(boot, PAL_STAGE_CHIP);
}

void pal_boot_start(pal_boot* boot, const pal_boot_config* config) {
    boot->config = *config;
    boot->failure = PAL_FAIL_NONE;
    boot->failed_stage = PAL_STAGE_NONE;
    boot->attempt = 1;
    boot->failed_byte = 0;
    boot->probing = config->reload != PAL_RELOAD_ALWAYS;
    boot->deadline_us = 0;
    start_attempt(boot);
}

uint32_t pal_boot_baud(const pal_boot* boot) {
    return boot->config.bauds[(boot->attempt - 1U) % boot->config.n_bauds];
}

void pal_boot_fail(pal_boot* boot, pal_falcon_failure failure) {
    boot->failed_byte = boot->n_echoed_bytes;
    boot->failed_stage = boot->stage;
    if (boot->probing) {
        boot->failure = failure == PAL_FAIL_NO_REPLY ? PAL_FAIL_NO_FIRMWARE : failure;
        boot->probing = false;
        if (boot->config.reload == PAL_RELOAD_IF_SILENT)
            start_attempt(boot);
        else
            enter(boot, PAL_STAGE_FAILED);
        return;
    }
    boot->failure = failure;
    if (boot->attempt < boot->config.n_attempts) {
        boot->attempt += 1U;
        start_attempt(boot);
    } else {
        enter(boot, PAL_STAGE_FAILED);
    }
}

// The wait that starts once the step handed out is done.
static uint32_t wait_us(const pal_boot* boot) {
    switch (boot->stage) {
        case PAL_STAGE_RESTART:
            return boot->config.dtr_low_us;
        case PAL_STAGE_ASK:
            return boot->config.ask_wait_us;
        case PAL_STAGE_AUTOBAUD:
            return boot->config.autobaud_wait_us;
        case PAL_STAGE_UPLOAD:
            return boot->config.echo_wait_us;
        default:
            return 0;
    }
}

static void on_late(pal_boot* boot) {
    boot->waiting = false;
    if (boot->stage == PAL_STAGE_ASK && boot->n_asked >= boot->config.n_asks) {
        pal_boot_fail(boot, PAL_FAIL_NO_PIC);
    } else if (boot->stage == PAL_STAGE_AUTOBAUD) {
        pal_boot_fail(boot, PAL_FAIL_NO_AUTOBAUD);
    } else if (boot->stage == PAL_STAGE_UPLOAD) {
        pal_boot_fail(boot, PAL_FAIL_ECHO_TIMEOUT);
    }
}

static pal_usb_step write_of(pal_boot* boot, const uint8_t* bytes, size_t n_bytes) {
    pal_usb_step step = {PAL_USB_WRITE, 0, 0, 0, bytes, n_bytes, 0};
    boot->arming = true;
    return step;
}

// Everything that the last session may have left: formats, lines, characters, bytes.
static pal_usb_step chip_step(pal_boot* boot) {
    static const struct {
        pal_ftdi_request request;
        uint16_t value;
    } LIST[] = {
        {PAL_FTDI_RESET, PAL_FTDI_RESET_ALL},
        {PAL_FTDI_DATA_FORMAT, PAL_FTDI_8N1},
        {PAL_FTDI_FLOW_CONTROL, 0},
        {PAL_FTDI_EVENT_CHAR, 0},
        {PAL_FTDI_ERROR_CHAR, 0},
        {PAL_FTDI_MODEM_CONTROL, PAL_FTDI_RTS_LOW},
        {PAL_FTDI_MODEM_CONTROL, PAL_FTDI_DTR_LOW},
        {PAL_FTDI_RESET, PAL_FTDI_PURGE_OUT},
        {PAL_FTDI_RESET, PAL_FTDI_PURGE_IN},
    };
    const pal_usb_step step = pal_ftdi_control(LIST[boot->at].request, LIST[boot->at].value);
    boot->at += 1U;
    if (boot->at == sizeof LIST / sizeof LIST[0]) {
        enter(boot, boot->probing ? PAL_STAGE_RUN : PAL_STAGE_RESTART);
    }
    return step;
}

static pal_usb_step restart_step(pal_boot* boot) {
    boot->at += 1U;
    if (boot->at == 1) return pal_ftdi_control(PAL_FTDI_LATENCY_MS, boot->config.boot_latency_ms);
    if (boot->at == 2) {
        boot->arming = true;
        return pal_ftdi_baud(PIC_BAUD);
    }
    enter(boot, PAL_STAGE_ASK);
    return pal_ftdi_control(PAL_FTDI_MODEM_CONTROL, PAL_FTDI_DTR_HIGH);
}

static pal_usb_step autobaud_step(pal_boot* boot) {
    boot->at += 1U;
    if (boot->at == 1) return pal_ftdi_control(PAL_FTDI_MODEM_CONTROL, PAL_FTDI_DTR_LOW);
    if (boot->at == 2) return pal_ftdi_baud(pal_boot_baud(boot));
    return write_of(boot, AUTOBAUD, sizeof AUTOBAUD);
}

static pal_usb_step upload_step(pal_boot* boot) {
    const uint8_t* at = boot->config.image + boot->n_sent_bytes;
    size_t n_bytes = boot->config.n_image_bytes - boot->n_sent_bytes;
    if (n_bytes > PAL_BOOT_CHUNK_BYTES) n_bytes = PAL_BOOT_CHUNK_BYTES;
    boot->n_sent_bytes += n_bytes;
    return write_of(boot, at, n_bytes);
}

static pal_usb_step run_step(pal_boot* boot) {
    if (boot->at == 2 && !boot->config.event_char) boot->at += 1U;
    boot->at += 1U;
    switch (boot->at) {
        case 1:
            return pal_ftdi_control(PAL_FTDI_LATENCY_MS, boot->config.run_latency_ms);
        case 2:
            return pal_ftdi_baud(RUN_BAUD);
        case 3:
            return pal_ftdi_control(PAL_FTDI_EVENT_CHAR, PAL_FTDI_CHAR_ON | EVENT_CHAR);
        case 4:
            return pal_ftdi_control(PAL_FTDI_RESET, PAL_FTDI_PURGE_OUT);
        default:
            break;
    }
    enter(boot, PAL_STAGE_FIRST_REPLY);
    return pal_ftdi_control(PAL_FTDI_RESET, PAL_FTDI_PURGE_IN);
}

pal_usb_step pal_boot_next(pal_boot* boot, uint64_t now_us) {
    if (boot->arming) {
        boot->arming = false;
        boot->waiting = true;
        boot->deadline_us = now_us + wait_us(boot);
    }
    if (boot->waiting) {
        if (now_us < boot->deadline_us) return pal_ftdi_idle((uint32_t)(boot->deadline_us - now_us));
        on_late(boot);
    }
    switch (boot->stage) {
        case PAL_STAGE_CHIP:
            return chip_step(boot);
        case PAL_STAGE_RESTART:
            return restart_step(boot);
        case PAL_STAGE_ASK:
            boot->n_asked += 1U;
            return write_of(boot, QUESTION, sizeof QUESTION);
        case PAL_STAGE_AUTOBAUD:
            return autobaud_step(boot);
        case PAL_STAGE_UPLOAD:
            return upload_step(boot);
        case PAL_STAGE_RUN:
            return run_step(boot);
        default:
            return pal_ftdi_idle(0);
    }
}

// The answer wherever it is: after a 00, after noise, over several packets.
static void feed_answer(pal_boot* boot, uint8_t byte) {
    if (boot->n_asked == 0) return;
    if (byte == ANSWER[boot->match])
        boot->match += 1U;
    else
        boot->match = byte == ANSWER[0] ? 1U : 0U;
    if (boot->match == ANSWER_BYTES) enter(boot, PAL_STAGE_AUTOBAUD);
}

static void feed_echo(pal_boot* boot, uint8_t byte) {
    if (boot->n_echoed_bytes == boot->n_sent_bytes) return;  // nothing is owed: noise between chunks
    if (byte != boot->config.image[boot->n_echoed_bytes]) {
        pal_boot_fail(boot, PAL_FAIL_ECHO_WRONG);
        return;
    }
    boot->n_echoed_bytes += 1U;
    if (boot->n_echoed_bytes == boot->config.n_image_bytes) {
        enter(boot, PAL_STAGE_RUN);
    } else if (boot->n_echoed_bytes == boot->n_sent_bytes) {
        boot->arming = false;
        boot->waiting = false;
    }
}

void pal_boot_feed(pal_boot* boot, const uint8_t* bytes, size_t n_bytes) {
    for (size_t i = 0; i < n_bytes; ++i) {
        if (boot->stage == PAL_STAGE_ASK) {
            feed_answer(boot, bytes[i]);
        } else if (boot->stage == PAL_STAGE_AUTOBAUD) {
            if (boot->at == 3 && bytes[i] == AUTOBAUD_CHAR) enter(boot, PAL_STAGE_UPLOAD);
        } else if (boot->stage == PAL_STAGE_UPLOAD) {
            feed_echo(boot, bytes[i]);
        }
    }
}
