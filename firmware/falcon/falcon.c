#include "firmware/falcon/falcon.h"

#include <string.h>

enum { DONE_WAKE_US = 1000000 };

static uint32_t since_us(uint64_t now_us, uint64_t then_us) {
    const uint64_t passed_us = now_us - then_us;
    return passed_us < UINT32_MAX ? (uint32_t)passed_us : UINT32_MAX;
}

static void tell(pal_falcon* f, uint64_t now_us) {
    if (now_us > f->now_us) f->now_us = now_us;  // time never goes back
}

static bool is_live(const pal_falcon* f) {
    return f->state == PAL_FALCON_HOMING || f->state == PAL_FALCON_READY;
}

static void trace_stage(pal_falcon* f) {
    pal_falcon_status now;
    pal_falcon_status_read(f, &now);
    const uint32_t mark = now.attempt << 8U | (uint32_t)now.stage;
    if (mark == f->traced) return;
    f->traced = mark;
    pal_trace_stage(f->config.trace, f->now_us, now.stage, now.failure, now.attempt);
}

// ---- states

pal_falcon_refusal pal_falcon_init(pal_falcon* f, const pal_falcon_config* config) {
    const pal_falcon_config kept = *config;  // `config` may be f->config
    memset(f, 0, sizeof *f);
    const pal_falcon_refusal refusal = pal_falcon_config_check(&kept);
    if (refusal != PAL_FALCON_OK) return refusal;
    f->config = kept;
    pal_boot_start(&f->boot, &kept.boot);
    f->state = PAL_FALCON_BOOTING;
    return PAL_FALCON_OK;
}

static void note(pal_falcon* f, uint32_t faults) {
    f->pending_faults |= faults;
    f->faults_seen |= faults;
}

// No force until a reply has come and a force was given after it.
static void let_go(pal_falcon* f) {
    f->driven = false;
    f->hold_zero = true;
    pal_force_restart(&f->force);
}

static void fail(pal_falcon* f, pal_falcon_failure failure, pal_falcon_stage stage, bool may_send) {
    f->failure = failure;
    f->failed_stage = stage;
    f->state = PAL_FALCON_FAULT;
    f->n_stop_sent = may_send ? 0 : f->config.n_stop_packets;
    let_go(f);
}

static pal_falcon_stage stage_of(const pal_falcon* f) {
    switch (f->state) {
        case PAL_FALCON_CLOSED:
            return PAL_STAGE_NONE;
        case PAL_FALCON_BOOTING:
            return f->boot.stage;
        case PAL_FALCON_HOMING:
            return PAL_STAGE_HOMING;
        case PAL_FALCON_READY:
            return PAL_STAGE_READY;
        case PAL_FALCON_STOPPING:
            return PAL_STAGE_STOPPING;
        case PAL_FALCON_FAULT:
            return PAL_STAGE_FAILED;
    }
    return PAL_STAGE_NONE;
}

// After a time-out since `n_before` of them: no force, and after too many in a row the end.
static void check_silence(pal_falcon* f, uint32_t n_before) {
    if (f->exchange.n_timeouts == n_before) return;
    note(f, PAL_FALCON_TIMEOUT);
    let_go(f);
    const bool silent = f->exchange.n_silent >= f->config.n_silent_max;
    if (is_live(f) && silent) fail(f, PAL_FAIL_SILENT, stage_of(f), true);
}

// ---- requests

static uint8_t leds_of(const pal_falcon* f) {
    const uint8_t wanted = (uint8_t)(f->wanted_leds & (uint32_t)PAL_WIRE_LEDS);
    if (wanted != 0) return wanted;
    return f->state == PAL_FALCON_READY ? (uint8_t)PAL_WIRE_BLUE : (uint8_t)PAL_WIRE_RED;
}

// Motor words for the next request, left in f->force.
static void choose_words(pal_falcon* f) {
    for (int c = 0; c < 3; ++c) f->applied_n[c] = 0.0F;
    pal_force_zero(&f->force);
    if (f->state != PAL_FALCON_READY || !f->driven || f->hold_zero) return;
    const pal_falcon_config* config = &f->config;
    if (config->drive_ttl_us > 0 && since_us(f->now_us, f->drive_us) > config->drive_ttl_us) {
        note(f, PAL_FALCON_DRIVE_STALE);
        f->driven = false;
        pal_force_restart(&f->force);
    } else if (f->wants_counts) {
        note(f, pal_force_counts(&config->force, config->delta, &f->force, f->wanted_counts));
    } else if (f->pose.has_position) {
        note(f, pal_force_words(&config->force, config->delta, &f->force, f->pose.position_m, f->wanted_n,
                                f->wanted_limit_n, f->applied_n));
    }
}

static pal_usb_step send_request(pal_falcon* f, const pal_exchange_config* exchange) {
    const bool first = f->exchange.n_requests == 0;
    pal_force_elapse(&f->config.force, &f->force, first ? 0U : since_us(f->now_us, f->request_us));
    choose_words(f);
    f->asked_homing = is_live(f) && f->config.needs_homing && (!f->homing.homed || f->config.keep_homing_bit);
    pal_wire_request out = {.motor_counts = {0, 0, 0}, .flags = 0};
    for (int i = 0; i < 3; ++i) out.motor_counts[i] = f->force.words[i];
    if (is_live(f)) out.flags = (uint8_t)(leds_of(f) | (f->asked_homing ? (uint32_t)PAL_WIRE_HOMING : 0U));
    f->request_us = f->now_us;
    return pal_exchange_send(exchange, &f->exchange, f->now_us, &out);
}

// So many in vain are too many.
static uint32_t n_first_max(const pal_falcon* f) {
    return f->boot.probing ? 1U : f->config.boot.n_first;
}

// Zero-force requests after the upload, or the one probe.
static pal_usb_step first_reply_step(pal_falcon* f) {
    const pal_boot_config* boot = &f->config.boot;
    pal_exchange_config exchange = f->config.exchange;
    exchange.reply_wait_us = f->boot.probing ? boot->probe_wait_us : boot->first_wait_us;
    bool wants = false;
    const pal_usb_step step = pal_exchange_next(&exchange, &f->exchange, f->now_us, &wants);
    if (f->exchange.n_silent < n_first_max(f)) return wants ? send_request(f, &exchange) : step;
    pal_boot_fail(&f->boot, PAL_FAIL_NO_REPLY);
    return pal_boot_next(&f->boot, f->now_us);
}

static pal_usb_step boot_step(pal_falcon* f) {
    const bool exchanging = f->boot.stage == PAL_STAGE_FIRST_REPLY;
    const pal_usb_step step = exchanging ? first_reply_step(f) : pal_boot_next(&f->boot, f->now_us);
    if (!exchanging && f->boot.stage == PAL_STAGE_FIRST_REPLY) memset(&f->exchange, 0, sizeof f->exchange);
    if (f->boot.stage != PAL_STAGE_FAILED) return step;
    fail(f, f->boot.failure, f->boot.failed_stage, false);
    return pal_ftdi_idle(DONE_WAKE_US);
}

bool pal_falcon_done(const pal_falcon* f) {
    if (f->state == PAL_FALCON_CLOSED) return true;
    return f->state == PAL_FALCON_FAULT && f->n_stop_sent >= f->config.n_stop_packets;
}

static pal_usb_step run_step(pal_falcon* f) {
    if (pal_falcon_done(f)) return pal_ftdi_idle(DONE_WAKE_US);
    const uint32_t n_timeouts = f->exchange.n_timeouts;
    bool wants = false;
    const pal_usb_step step = pal_exchange_next(&f->config.exchange, &f->exchange, f->now_us, &wants);
    check_silence(f, n_timeouts);
    if (!wants) return step;
    if (!is_live(f)) {
        if (f->n_stop_sent >= f->config.n_stop_packets) {
            f->state = PAL_FALCON_CLOSED;
            return pal_ftdi_idle(DONE_WAKE_US);
        }
        f->n_stop_sent += 1U;
    }
    return send_request(f, &f->config.exchange);
}

pal_usb_step pal_falcon_next(pal_falcon* f, uint64_t now_us) {
    tell(f, now_us);
    trace_stage(f);
    const pal_usb_step step = f->state == PAL_FALCON_BOOTING ? boot_step(f) : run_step(f);
    trace_stage(f);
    pal_trace_step(f->config.trace, f->now_us, &step);
    return step;
}

// A port that cannot transfer is not a device that does not answer.
static void fail_boot_transfer(pal_falcon* f) {
    if (f->boot.stage == PAL_STAGE_FIRST_REPLY) {
        pal_exchange_broken(&f->exchange);
        if (f->exchange.n_silent < n_first_max(f)) return;
    }
    pal_boot_fail(&f->boot, PAL_FAIL_TRANSFER);
    if (f->boot.stage == PAL_STAGE_FAILED) fail(f, f->boot.failure, f->boot.failed_stage, false);
}

void pal_falcon_transfer_failed(pal_falcon* f, bool gone, uint64_t now_us) {
    tell(f, now_us);
    if (f->state == PAL_FALCON_CLOSED || f->state == PAL_FALCON_FAULT) {
        f->n_stop_sent = f->config.n_stop_packets;  // nothing can be sent: give up
    } else if (gone) {
        fail(f, PAL_FAIL_UNPLUGGED, stage_of(f), false);
    } else if (f->state == PAL_FALCON_BOOTING) {
        fail_boot_transfer(f);
    } else {
        const uint32_t n_timeouts = f->exchange.n_timeouts;
        pal_exchange_broken(&f->exchange);
        check_silence(f, n_timeouts);
        if (f->state == PAL_FALCON_STOPPING && f->exchange.n_silent >= f->config.n_silent_max) {
            fail(f, PAL_FAIL_TRANSFER, PAL_STAGE_STOPPING, false);
        }
    }
    trace_stage(f);
}

void pal_falcon_stop(pal_falcon* f) {
    if (f->state == PAL_FALCON_BOOTING) f->state = PAL_FALCON_CLOSED;
    if (!is_live(f)) return;
    let_go(f);
    f->n_stop_sent = 0;
    f->state = PAL_FALCON_STOPPING;
}

// ---- replies

static void enter(pal_falcon* f, pal_falcon_state state) {
    f->state = state;
    f->pose.has_position = false;
    f->pose.has_counts = false;  // at homing the counters jump
    let_go(f);
}

static void follow_homing(pal_falcon* f, uint8_t flags) {
    if (!f->config.needs_homing) return;
    if (!pal_homing_step(&f->homing, flags, f->asked_homing)) return;
    if (!f->homing.homed) note(f, PAL_FALCON_HOME_LOST);
    enter(f, f->homing.homed ? PAL_FALCON_READY : PAL_FALCON_HOMING);
}

static void on_reply(pal_falcon* f, const pal_wire_reply* reply) {
    const uint32_t dt_us = since_us(f->now_us, f->reply_us);
    f->reply_us = f->now_us;
    f->hold_zero = false;
    f->homed_flags = reply->homed;
    for (int i = 0; i < 3; ++i) f->encoder_counts[i] = reply->encoder_counts[i];
    pal_grip_step(&f->grip, reply->buttons, dt_us, f->config.button_hold_us);
    if (f->state == PAL_FALCON_BOOTING)
        enter(f, f->config.needs_homing ? PAL_FALCON_HOMING : PAL_FALCON_READY);
    if (is_live(f)) follow_homing(f, reply->homed);
    if (f->state == PAL_FALCON_READY) {
        const uint32_t faults =
            pal_pose_step(&f->config.pose, f->config.delta, &f->pose, f->encoder_counts, dt_us);
        note(f, faults);
        if (faults != 0) let_go(f);
    }
    f->faults = f->pending_faults;
    f->pending_faults = 0;
}

static void take_payload(pal_falcon* f, const pal_ftdi_payload* payload) {
    if (f->state == PAL_FALCON_BOOTING && f->boot.stage != PAL_STAGE_FIRST_REPLY) {
        pal_boot_feed(&f->boot, payload->bytes, payload->n_bytes);
        return;
    }
    if (payload->line_errors != 0) note(f, PAL_FALCON_LINE);
    const uint32_t n_unasked = f->exchange.n_unasked;
    pal_wire_reply reply;
    const bool got = pal_exchange_feed(&f->exchange, payload->bytes, payload->n_bytes, &reply);
    if (f->exchange.n_unasked != n_unasked) note(f, PAL_FALCON_UNASKED);
    if (got) on_reply(f, &reply);
}

void pal_falcon_feed(pal_falcon* f, const uint8_t* transfer, size_t n_bytes, uint64_t now_us) {
    tell(f, now_us);
    if (pal_falcon_done(f)) return;
    size_t n_taken_bytes = 0;
    size_t n_before = 0;
    pal_ftdi_payload payload;
    while (pal_ftdi_next_packet(transfer, n_bytes, &n_taken_bytes, &payload)) {
        pal_trace_read(f->config.trace, f->now_us, transfer + n_before, n_taken_bytes - n_before);
        n_before = n_taken_bytes;
        take_payload(f, &payload);
    }
    if (f->boot.stage == PAL_STAGE_FAILED && f->state == PAL_FALCON_BOOTING) {
        fail(f, f->boot.failure, f->boot.failed_stage, false);
    }
    trace_stage(f);
}

// ---- the caller's side

void pal_falcon_drive(pal_falcon* f, const float force_n[3], float limit_n, uint8_t leds) {
    for (int c = 0; c < 3; ++c) f->wanted_n[c] = force_n[c];
    f->wanted_limit_n = limit_n;
    f->wanted_leds = leds;
    f->wants_counts = false;
    f->driven = f->state == PAL_FALCON_READY && !f->hold_zero;
    f->drive_us = f->now_us;
}

void pal_falcon_drive_counts(pal_falcon* f, const int16_t motor_counts[3], uint8_t leds) {
    for (int i = 0; i < 3; ++i) f->wanted_counts[i] = motor_counts[i];
    f->wanted_leds = leds;
    f->wants_counts = true;
    f->driven = f->state == PAL_FALCON_READY && !f->hold_zero;
    f->drive_us = f->now_us;
}

pal_falcon_state pal_falcon_read(const pal_falcon* f, pal_falcon_sense* out) {
    for (int c = 0; c < 3; ++c) {
        out->position_m[c] = f->pose.position_m[c];
        out->velocity_m_per_s[c] = f->pose.velocity_m_per_s[c];
        out->force_n[c] = f->applied_n[c];
        out->encoder_counts[c] = f->encoder_counts[c];
        out->motor_counts[c] = f->force.words[c];
    }
    out->buttons = f->grip.buttons;
    out->homed = f->homed_flags;
    out->has_position = f->pose.has_position;
    out->time_us = f->reply_us;
    out->n_exchanges = f->exchange.n_replies;
    out->n_timeouts = f->exchange.n_timeouts;
    out->n_unasked = f->exchange.n_unasked;
    out->n_skipped_bytes = f->exchange.reader.n_skipped_bytes;
    out->faults = f->faults | f->pending_faults;
    out->faults_seen = f->faults_seen;
    return f->state;
}

void pal_falcon_status_read(const pal_falcon* f, pal_falcon_status* out) {
    const bool failed = f->state == PAL_FALCON_FAULT;
    const bool started = f->boot.attempt > 0;
    out->stage = stage_of(f);
    out->at_stage = failed ? f->failed_stage : out->stage;
    out->failure = failed ? f->failure : f->boot.failure;
    out->attempt = f->boot.attempt;
    out->n_attempts = f->config.boot.n_attempts;
    out->baud = started ? pal_ftdi_real_baud(pal_boot_baud(&f->boot)) : 0U;
    out->n_image_bytes = (uint32_t)f->config.boot.n_image_bytes;
    out->n_echoed_bytes = (uint32_t)f->boot.n_echoed_bytes;
    out->failed_byte = (uint32_t)f->boot.failed_byte;
}

size_t pal_falcon_size_bytes(void) {
    return sizeof(pal_falcon);
}
