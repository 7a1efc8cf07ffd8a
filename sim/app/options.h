/// The command line of palpate-falcon-sim.
#pragma once
#include <stdbool.h>
#include <stdint.h>

#include "sim/app/exit_codes.h"
#include "sim/app/serve.h"
#include "sim/falcon/usb_device.h"
#include "sim/usb/bus.h"

/// What each option belongs to; a verb is one of them.
typedef enum pal_verb {
    PAL_VERB_SOCKET = 1,  ///< serve --socket, and status and quit of that
    PAL_VERB_USB = 2,     ///< serve --usb
    PAL_VERB_RUN = 4,
    PAL_VERB_USBIP = 8,
    PAL_VERB_ASK = 16,  ///< status, quit, fault, env of a bus
} pal_verb;

typedef struct pal_options {
    pal_verb verb;
    // The hand and the mechanics, as pal_serve has them too.
    const char* path_file;
    unsigned long long ramp_ticks, seed, watchdog_ms, linger_s;
    double scale;           ///< of the delta's lengths
    pal_hand_point middle;  ///< where the hand holds the device without a path
    pal_serve_options serve;
    // The devices on USB.
    const char* bus;  ///< folder; NULL: the usual one
    const char* serial;
    const char* faults_file;
    const char* pcap_file;  ///< NULL: no capture
    unsigned long long n_devices, packets_per_frame;
    pal_host_timing timing;
    pal_usb_device_config device;
    // USB/IP.
    const char* listen;
    unsigned long long tcp_port;
    // Questions.
    unsigned long long device_index;  ///< from 1; 0: all
    char** rest;                      ///< what follows the options; ends with NULL
    bool help;                        ///< was asked for; the rest was not read
} pal_options;

/// Reads the options of `verb`, "serve", from argv[1] on. 0, or PAL_EXIT_BAD_INPUT and one line on stderr
/// that says what would be right.
int pal_options_read(int argc, char** argv, const char* verb, pal_options* out);
/// One line on stderr. PAL_EXIT_BAD_INPUT.
int pal_options_refuse(const char* option, const char* value, const char* right);
/// The bus folder: --bus, else the environment's, else the user's own.
const char* pal_options_bus(const pal_options* options);
