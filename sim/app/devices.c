#include "sim/app/devices.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FAULTS_FILE_MAX = 65536 };
// Height of a Falcon whose arms are at -15 degrees, the usual homing reference. Whatever the delta's size,
// the hand pushes as far beyond it: as hard.
static const double HOME_Z_M = 0.0774;

bool pal_devices_hand(pal_options* o, pal_path_file* path, char* why, size_t n_why) {
    pal_falcon_sim_config* falcon = &o->serve.falcon;
    pal_hand_config* hand = &o->serve.hand;
    *path = (pal_path_file){NULL, 0};
    if (o->path_file && !pal_path_file_read(o->path_file, path, why, n_why)) return false;
    pal_falcon_sim_resize(falcon, o->scale);
    memcpy(o->middle.at_m, falcon->start_m, sizeof o->middle.at_m);
    hand->home_in_m[2] = PAL_HAND_HOME_IN_Z_M + (o->scale - 1.0) * HOME_Z_M;
    hand->path = path->points ? path->points : &o->middle;
    hand->n_points = path->points ? path->n_points : 1;
    hand->wait_ticks = (uint32_t)o->ramp_ticks;
    falcon->watchdog_ticks = (uint32_t)o->watchdog_ms;
    if (hand->stiffness_n_per_m > 0.0) hand->weight_n = falcon->mass_kg * falcon->gravity_m_per_s2;
    return true;
}

/// No two devices are alike: mass, frictions and motor gain differ by so much of their usual value, by the
/// seed.
static const double DEVICE_SPREAD = 0.3;

static void hand_advance(void* context, bool homed, const double position_m[3]) {
    pal_hand_advance(context, homed, position_m);
}

static bool read_faults(const char* file, pal_devices* out, char* why, size_t n_why) {
    static char text[FAULTS_FILE_MAX];
    FILE* in = fopen(file, "r");
    if (!in) {
        (void)snprintf(why, n_why, "%s: %s; name a readable file of faults", file, strerror(errno));
        return false;
    }
    const size_t n = fread(text, 1, sizeof text, in);
    const bool whole = feof(in) != 0;
    const int reason = ferror(in) ? errno : 0;
    (void)fclose(in);
    if (reason != 0) {
        (void)snprintf(why, n_why, "%s: %s; name a readable file of faults", file, strerror(reason));
        return false;
    }
    if (!whole) {
        (void)snprintf(why, n_why, "%s: too long; at most %d faults", file, PAL_USB_FAULTS_MAX);
        return false;
    }
    pal_usb_fault_error error = {0};
    const int count = pal_usb_faults_parse(text, n, out->faults, PAL_USB_FAULTS_MAX, &error);
    if (count < 0) {
        (void)snprintf(why, n_why, "%s: %s", file, error.message);
        return false;
    }
    out->configs[0].faults = out->faults;
    out->configs[0].n_faults = (size_t)count;
    return true;
}

/// Device `index` has a serial of its own: the first one's, its last digits counted up. False: too few
/// digits.
static bool count_up(char serial[PAL_USB_TEXT_BYTES], uint32_t index) {
    size_t at = strlen(serial);
    uint32_t carry = index;
    for (; carry > 0 && at > 0; --at) {
        char* c = &serial[at - 1];
        if (*c < '0' || *c > '9') return false;
        const uint32_t sum = (uint32_t)(*c - '0') + carry;
        *c = (char)('0' + sum % 10);
        carry = sum / 10;
    }
    return carry == 0;
}

bool pal_devices_make(pal_options* o, pal_devices* out, char* why, size_t n_why) {
    memset(out, 0, sizeof *out);
    if (!pal_devices_hand(o, &out->path, why, n_why)) return false;
    pal_usb_device_config* first = &o->device;
    if (o->serial) {
        const size_t n = strlen(o->serial);
        if (n == 0 || n >= sizeof first->serial) {
            (void)snprintf(why, n_why, "--serial %s: must have 1..%d characters", o->serial,
                           PAL_USB_TEXT_BYTES - 1);
            return false;
        }
        memcpy(first->serial, o->serial, n + 1);
    }
    first->instant = o->timing == PAL_HOST_IMMEDIATE;
    out->n = (uint32_t)o->n_devices;
    for (uint32_t i = 0; i < out->n; ++i) {
        pal_usb_device_config* config = &out->configs[i];
        *config = *first;
        if (!count_up(config->serial, i)) {
            (void)snprintf(why, n_why,
                           "--serial %s: must end in digits that can be counted up for %u devices",
                           first->serial, (unsigned)out->n);
            return false;
        }
        config->seed = o->seed + i;
        config->falcon = o->serve.falcon;
        pal_falcon_sim_vary(&config->falcon, config->seed, DEVICE_SPREAD);
        pal_hand_config hand = o->serve.hand;
        if (hand.weight_n > 0.0) hand.weight_n = config->falcon.mass_kg * config->falcon.gravity_m_per_s2;
        pal_hand_init(&out->hands[i], &hand);
        config->hand = (pal_usb_hand){&out->hands[i], hand_advance, pal_hand_push, o->serve.hand.mass_kg};
    }
    if (o->faults_file && !read_faults(o->faults_file, out, why, n_why)) return false;
    for (uint32_t i = 1; i < out->n; ++i) {
        out->configs[i].faults = out->configs[0].faults;
        out->configs[i].n_faults = out->configs[0].n_faults;
    }
    return true;
}

void pal_devices_free(pal_devices* devices) {
    free(devices->path.points);
    devices->path = (pal_path_file){NULL, 0};
}
