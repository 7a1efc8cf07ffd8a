#include "firmware/port/linux/usb_device.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

enum { TURN_US = 5000 };

static bool take(pal_usb_device* usb) {
    return __atomic_exchange_n(&usb->in_use, 1U, __ATOMIC_ACQUIRE) == 0;
}

static void give(pal_usb_device* usb) {
    __atomic_store_n(&usb->in_use, 0U, __ATOMIC_RELEASE);
}

static bool stopping(const pal_usb_device* usb) {
    return __atomic_load_n(&usb->stop, __ATOMIC_ACQUIRE) != 0;
}

static void count(uint32_t* counter) {
    __atomic_fetch_add(counter, 1U, __ATOMIC_RELAXED);
}

// ---- the tick

static pal_device_news tell(pal_usb_device* usb, uint8_t reply[PAL_WIRE_BYTES]) {
    pal_falcon_sense sense;
    const pal_falcon_state state = pal_falcon_read(&usb->falcon, &sense);
    if (sense.n_exchanges == usb->n_taken) return PAL_DEVICE_NONE;
    usb->n_taken = sense.n_exchanges;
    const bool ready = state == PAL_FALCON_READY;
    // The loop latches "homed" once: encoders of a device that homes again would be taken for positions.
    if (!ready && (state != PAL_FALCON_HOMING || usb->was_ready)) return PAL_DEVICE_NONE;
    usb->was_ready = usb->was_ready || ready;
    // And it must not do so before the driver does: all three at once are told when READY only.
    const uint8_t homing = sense.homed == PAL_HOMED_ALL ? 0 : sense.homed;
    pal_wire_reply told = {.buttons = sense.buttons, .homed = ready ? (uint8_t)PAL_HOMED_ALL : homing};
    for (int i = 0; i < 3; ++i) told.encoder_counts[i] = sense.encoder_counts[i];
    pal_packet_encode_reply(&told, reply);
    return PAL_DEVICE_FRESH;
}

static pal_device_news collect(void* context, uint8_t reply[PAL_WIRE_BYTES]) {
    pal_usb_device* usb = (pal_usb_device*)context;
    pal_device_news news = PAL_DEVICE_NONE;
    if (!take(usb)) return news;
    if (!usb->lost) {
        pal_usb_falcon_collect(&usb->port);
        news = tell(usb, reply);
        if (news == PAL_DEVICE_FRESH) usb->times.reply_ns = usb->port.came_ns;
    }
    give(usb);
    return news;
}

static bool is_lost(const pal_usb_device* usb) {
    return usb->port.gone || pal_falcon_done(&usb->falcon);
}

static pal_device_news send_request(void* context, const uint8_t request[PAL_WIRE_BYTES]) {
    pal_usb_device* usb = (pal_usb_device*)context;
    pal_wire_reply words;  // a request reads like a reply: motor words for encoders, flags for buttons
    if (!take(usb)) return PAL_DEVICE_NONE;
    pal_device_news news = PAL_DEVICE_NONE;
    usb->tick_us = pal_usb_now_us();
    if (!usb->lost && pal_packet_decode(request, &words)) {
        const uint32_t n_before = usb->falcon.exchange.n_requests;
        pal_falcon_drive_counts(&usb->falcon, words.encoder_counts,
                                (uint8_t)(words.buttons & (uint32_t)PAL_WIRE_LEDS));
        (void)pal_usb_falcon_send(&usb->port);
        if (usb->falcon.exchange.n_requests != n_before) news = PAL_DEVICE_FRESH;
        usb->times.sent_ns = usb->port.sent_ns;
        usb->times.done_ns = usb->port.done_ns;
        usb->lost = is_lost(usb);
    }
    give(usb);
    return news;
}

static void tell_times(void* context, pal_device_times* times) {
    *times = ((const pal_usb_device*)context)->times;
}

// ---- the thread

static void pause_us(uint32_t us) {
    const struct timespec pause = {.tv_sec = us / 1000000U, .tv_nsec = (long)(us % 1000000U) * 1000L};
    (void)nanosleep(&pause, NULL);
}

static void say_fault(const pal_usb_device* usb) {
    char words[PAL_USB_WORDS_BYTES];
    (void)pal_falcon_describe(&usb->falcon, words, sizeof words);
    (void)fprintf(stderr, "palpate-loop: %s Forces are off; it is waited for.\n", words);
}

// Boots until the first reply. False: it failed, or `*stop` or usb->stop is set.
static bool boot(pal_usb_device* usb, const volatile sig_atomic_t* stop) {
    pal_falcon_sense sense;
    pal_falcon_state state = PAL_FALCON_BOOTING;
    while (state == PAL_FALCON_BOOTING && !stopping(usb) && (stop == NULL || *stop == 0)) {
        pal_usb_falcon_turn(&usb->port, TURN_US);
        state = pal_falcon_read(&usb->falcon, &sense);
    }
    return state == PAL_FALCON_HOMING || state == PAL_FALCON_READY;
}

// `*told`: what the last look found; each new reason but that the device is not there is said once.
static bool reopen(pal_usb_device* usb, pal_usb_problem* told) {
    char why[PAL_USB_WORDS_BYTES];
    if (pal_falcon_init(&usb->falcon, &usb->config) != PAL_FALCON_OK) return false;
    const char* serial = usb->serial[0] != '\0' ? usb->serial : NULL;
    const pal_usb_problem problem = pal_usb_falcon_open(&usb->port, &usb->falcon, serial, NULL, why);
    const bool is_news = problem != *told && problem != PAL_USB_OK && problem != PAL_USB_NONE;
    if (is_news) (void)fprintf(stderr, "palpate-loop: %s\n", why);
    *told = problem;
    if (problem != PAL_USB_OK) return false;
    if (boot(usb, NULL)) return true;
    if (!stopping(usb)) say_fault(usb);
    pal_usb_falcon_close(&usb->port);
    return false;
}

// The device went away: the thread keeps the lock until it is back, so that the tick sees a late device.
static void bring_back(pal_usb_device* usb) {
    pal_usb_problem told = PAL_USB_NONE;
    say_fault(usb);
    count(&usb->n_lost);
    pal_usb_falcon_close(&usb->port);
    while (!stopping(usb)) {
        pause_us(PAL_USB_DEVICE_REOPEN_US);
        if (stopping(usb) || !reopen(usb, &told)) continue;
        usb->n_taken = 0;
        usb->lost = false;
        usb->tick_us = pal_usb_now_us();
        count(&usb->n_resumed);
        (void)fprintf(stderr, "palpate-loop: Falcon %s is back. %s Then switch forces off and on.\n",
                      usb->serial, pal_falcon_words(&usb->falcon));
        return;
    }
}

// Nobody has ticked for long: requests go on, and drive_ttl_us has made their force zero.
static void stand_in(pal_usb_device* usb) {
    pal_usb_falcon_turn(&usb->port, TURN_US);
    usb->lost = is_lost(usb);
}

static void* run_thread(void* context) {
    pal_usb_device* usb = (pal_usb_device*)context;
    while (!stopping(usb)) {
        uint32_t wait_us = PAL_USB_DEVICE_LOOK_US;
        if (take(usb)) {
            if (usb->lost) {
                bring_back(usb);
            } else if (pal_usb_now_us() - usb->tick_us > PAL_USB_DEVICE_SILENT_US) {
                stand_in(usb);
                wait_us = 0;
            }
            give(usb);
        }
        pause_us(wait_us);
    }
    return NULL;
}

// ---- open and close

static pal_usb_device_open_result open_and_boot(pal_usb_device* usb, const char* serial,
                                                const volatile sig_atomic_t* stop,
                                                char why[PAL_FIRMWARE_WORDS_BYTES]) {
    const pal_falcon_refusal refusal = pal_falcon_init(&usb->falcon, &usb->config);
    if (refusal != PAL_FALCON_OK) {
        (void)snprintf(why, PAL_FIRMWARE_WORDS_BYTES, "%s", pal_falcon_refusal_words(refusal));
        return PAL_USB_DEVICE_NO_FIRMWARE;
    }
    if (pal_usb_falcon_open(&usb->port, &usb->falcon, serial, NULL, why) != PAL_USB_OK)
        return PAL_USB_DEVICE_FAILED;
    (void)snprintf(usb->serial, sizeof usb->serial, "%s", usb->port.link.about.serial);
    if (boot(usb, stop)) return PAL_USB_DEVICE_OPEN;
    const bool stopped = stop != NULL && *stop != 0;
    (void)pal_falcon_describe(&usb->falcon, why, PAL_FIRMWARE_WORDS_BYTES);
    pal_usb_falcon_close(&usb->port);
    return stopped ? PAL_USB_DEVICE_STOPPED : PAL_USB_DEVICE_FAILED;
}

pal_usb_device_open_result pal_usb_device_open(pal_usb_device* usb, const pal_usb_device_choice* choice,
                                               const volatile sig_atomic_t* stop, pal_device* device,
                                               char why[PAL_FIRMWARE_WORDS_BYTES]) {
    memset(usb, 0, sizeof *usb);
    if (!pal_firmware_read(choice->firmware, &usb->firmware, why)) return PAL_USB_DEVICE_NO_FIRMWARE;
    usb->config = pal_falcon_config_default();
    usb->config.boot.image = usb->firmware.bytes;
    usb->config.boot.n_image_bytes = usb->firmware.n_bytes;
    usb->config.exchange.period_us = 0;  // the loop's tick is the pace
    if (choice->delta != NULL) {
        usb->config.delta = choice->delta;
        memcpy(usb->config.pose.start_m, choice->start_m, sizeof usb->config.pose.start_m);
    }
    const pal_usb_device_open_result result = open_and_boot(usb, choice->serial, stop, why);
    if (result != PAL_USB_DEVICE_OPEN) return result;
    usb->tick_us = pal_usb_now_us();
    if (pthread_create(&usb->thread, NULL, run_thread, usb) != 0) {
        pal_usb_falcon_close(&usb->port);
        (void)snprintf(why, PAL_FIRMWARE_WORDS_BYTES, "no thread to watch the device");
        return PAL_USB_DEVICE_FAILED;
    }
    *device = (pal_device){.context = usb, .collect = collect, .send = send_request, .times = tell_times};
    return PAL_USB_DEVICE_OPEN;
}

void pal_usb_device_close(pal_usb_device* usb) {
    __atomic_store_n(&usb->stop, 1U, __ATOMIC_RELEASE);
    (void)pthread_join(usb->thread, NULL);
    pal_usb_falcon_close(&usb->port);
}
