/// A loop for the tests of the USB port: homes the Falcon, then pushes with a constant motor word, 1000 times
/// a second, as palpate-loop does it. A late device is not pushed until it has answered for 20 ticks again.
/// SIGTERM ends it in order; SIGUSR1 makes it stop ticking for ever, as a program that hangs.
/// usage: usb_push FIRMWARE MOTOR_WORD [GUARD]. Prints a line for each thing that happens.
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "firmware/falcon/packet.h"
#include "firmware/port/linux/usb_device.h"
#include "firmware/port/linux/usb_guard.h"

enum { LATE_TICKS = 20, GOOD_TICKS = 20, ALL_HOMED = 7, ZERO_TICKS = 20 };

static volatile sig_atomic_t asked_to_stop = 0;
static volatile sig_atomic_t asked_to_hang = 0;

static void on_signal(int number) {
    if (number == SIGUSR1) asked_to_hang = 1;
    if (number != SIGUSR1) asked_to_stop = 1;
}

static void tick_pause(void) {
    const struct timespec pause = {.tv_nsec = 1000000};
    (void)nanosleep(&pause, NULL);
}

static void say(const char* word) {
    (void)printf("%s\n", word);
    (void)fflush(stdout);
}

static void send_words(const pal_device* device, int16_t words) {
    const pal_wire_request request = {.motor_counts = {words, words, words}, .flags = 0};
    uint8_t packet[PAL_WIRE_BYTES];
    pal_packet_encode(&request, packet);
    (void)device->send(device->context, packet);
}

static void run(const pal_device* device, int16_t words) {
    uint32_t n_late = 0;
    uint32_t n_good = 0;
    bool pushing = false;
    while (asked_to_stop == 0) {
        uint8_t packet[PAL_WIRE_BYTES];
        pal_wire_reply reply = {.homed = 0};
        const bool fresh = device->collect(device->context, packet) == PAL_DEVICE_FRESH;
        if (fresh && !pal_packet_decode(packet, &reply)) say("not a reply");
        n_late = fresh ? 0 : n_late + 1;
        if (n_late == LATE_TICKS && pushing) say("late");
        if (n_late >= LATE_TICKS) n_good = 0;
        if (fresh) n_good = reply.homed == ALL_HOMED ? n_good + 1 : 0;
        const bool may_push = n_late < LATE_TICKS && n_good >= GOOD_TICKS;
        if (may_push && !pushing) say("pushing");
        pushing = may_push;
        send_words(device, may_push ? words : (int16_t)0);
        while (asked_to_hang != 0) tick_pause();
        tick_pause();
    }
    for (int i = 0; i < ZERO_TICKS; ++i) {
        uint8_t packet[PAL_WIRE_BYTES];
        (void)device->collect(device->context, packet);
        send_words(device, 0);
        tick_pause();
    }
}

int main(int argc, char** argv) {
    static pal_usb_device usb;
    pal_device device;
    char why[PAL_FIRMWARE_WORDS_BYTES];
    if (argc < 3) return 2;
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_signal;
    (void)sigaction(SIGTERM, &action, NULL);
    (void)sigaction(SIGUSR1, &action, NULL);
    const pal_usb_device_choice choice = {.firmware = argv[1]};
    const pal_usb_device_open_result result =
        pal_usb_device_open(&usb, &choice, &asked_to_stop, &device, why);
    if (result != PAL_USB_DEVICE_OPEN) {
        (void)fprintf(stderr, "usb_push: %s\n", why);
        return 3;
    }
    pal_usb_guard guard = {.file = -1};
    if (argc > 3 && !pal_usb_guard_start(&guard, argv[3], usb.serial)) say("no guard");
    say("open");
    run(&device, (int16_t)atoi(argv[2]));
    pal_usb_device_close(&usb);
    pal_usb_guard_dismiss(&guard);
    (void)printf("lost %u resumed %u\n", usb.n_lost, usb.n_resumed);
    return 0;
}
