#include <stddef.h>

#include "firmware/falcon/falcon.h"
#include "firmware/falcon/image.h"

static const float RATED_N = 8.9F;
enum { STOP_PACKETS_MIN = 3, WAIT_MAX_US = 10000000, TIMES_MAX = 1000, RMS_COUNTS_MAX = 4095 };

pal_falcon_config pal_falcon_config_default(void) {
    pal_falcon_config config = {
        .delta = &PAL_DELTA_NF1,
        .boot = pal_boot_config_default(),
        .exchange = {.period_us = 1000, .reply_wait_us = 20000, .drain_us = 5000},
        .force = pal_force_config_default(),
        .n_silent_max = 10,
        .n_stop_packets = 5,
        .drive_ttl_us = 50000,
        .button_hold_us = 10000,
        .pose = {.start_m = {0.0F, 0.0F, 0.11F}, .jump_max_counts_per_ms = 300, .velocity_cutoff_hz = 50.0F},
        .needs_homing = true,
        .keep_homing_bit = true,
        .trace = NULL,
    };
    return config;
}

static bool wait_ok(uint32_t us) {
    return us <= WAIT_MAX_US;
}

static bool boot_ok(const pal_boot_config* boot) {
    if (!(boot->n_attempts >= 1 && boot->n_attempts <= TIMES_MAX)) return false;
    if (!(boot->n_bauds >= 1 && boot->n_bauds <= PAL_BOOT_BAUDS_MAX)) return false;
    for (uint32_t i = 0; i < boot->n_bauds; ++i) {
        if (!(boot->bauds[i] >= PAL_FTDI_BAUD_MIN && boot->bauds[i] <= PAL_FTDI_BAUD_MAX)) return false;
    }
    if (!(boot->n_asks >= 1 && boot->n_asks <= TIMES_MAX)) return false;
    if (!(boot->n_first >= 1 && boot->n_first <= TIMES_MAX)) return false;
    if (boot->boot_latency_ms == 0 || boot->run_latency_ms == 0) return false;
    return wait_ok(boot->dtr_low_us) && wait_ok(boot->ask_wait_us) && wait_ok(boot->autobaud_wait_us) &&
           wait_ok(boot->echo_wait_us) && wait_ok(boot->first_wait_us) && wait_ok(boot->probe_wait_us) &&
           (unsigned)boot->reload <= PAL_RELOAD_NEVER;
}

static bool force_ok(const pal_force_config* force) {
    return force->force_max_n > 0.0F && force->force_max_n <= RATED_N && wait_ok(force->ramp_us) &&
           force->rms_max_counts > 0.0F && force->rms_max_counts <= (float)RMS_COUNTS_MAX &&
           force->rms_time_s > 0.0F && force->rms_time_s <= 3600.0F && force->rms_margin >= 0.0F &&
           force->rms_margin <= 100.0F;
}

static bool config_ok(const pal_falcon_config* c) {
    if (c->delta == NULL || !boot_ok(&c->boot) || !force_ok(&c->force)) return false;
    if (!(wait_ok(c->exchange.period_us) && wait_ok(c->exchange.reply_wait_us))) return false;
    if (!(wait_ok(c->exchange.drain_us) && wait_ok(c->drive_ttl_us) && wait_ok(c->button_hold_us)))
        return false;
    if (!(c->n_silent_max >= 1 && c->n_silent_max <= TIMES_MAX)) return false;
    if (!(c->n_stop_packets >= STOP_PACKETS_MIN && c->n_stop_packets <= TIMES_MAX)) return false;
    if (c->trace != NULL && (c->trace->records == NULL || c->trace->n_records == 0)) return false;
    const pal_pose_config* pose = &c->pose;
    return pose->jump_max_counts_per_ms > 0 && pose->velocity_cutoff_hz > 0.0F &&
           pose->velocity_cutoff_hz <= 1000.0F;
}

pal_falcon_refusal pal_falcon_config_check(const pal_falcon_config* config) {
    if (!config_ok(config)) return PAL_FALCON_REFUSE_CONFIG;
    const pal_boot_config* boot = &config->boot;
    if (boot->reload == PAL_RELOAD_NEVER) return PAL_FALCON_OK;
    if (boot->image == NULL) return PAL_FALCON_REFUSE_NO_IMAGE;
    const pal_image_problem problem = pal_image_check(boot->image, boot->n_image_bytes, NULL);
    return problem == PAL_IMAGE_OK ? PAL_FALCON_OK : PAL_FALCON_REFUSE_IMAGE;
}

const char* pal_falcon_refusal_words(pal_falcon_refusal refusal) {
    switch (refusal) {
        case PAL_FALCON_OK:
            return "";
        case PAL_FALCON_REFUSE_CONFIG:
            return "A setting of the Falcon driver is out of its range.";
        case PAL_FALCON_REFUSE_NO_IMAGE:
            return "No firmware file was given, and the Falcon needs one.";
        case PAL_FALCON_REFUSE_IMAGE:
            return "The firmware file is not a whole boot image for the Falcon.";
    }
    return "";
}
