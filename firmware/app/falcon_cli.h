/// What the commands of palpate-falcon share: one device from opening to closing, signals, and words.
#pragma once
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "firmware/app/falcon_options.h"
#include "firmware/falcon/falcon.h"
#include "firmware/port/linux/delta_file.h"
#include "firmware/port/linux/firmware_file.h"
#include "firmware/port/linux/pcap.h"
#include "firmware/port/linux/usb_falcon.h"
#ifdef __cplusplus
extern "C" {
#endif

enum {
    PAL_EXIT_DONE = 0,
    PAL_EXIT_VERDICT = 1,
    PAL_EXIT_ARGUMENTS = 2,
    PAL_EXIT_DEVICE = 3,
    PAL_EXIT_INTERRUPTED = 130
};
enum { PAL_CLI_RECORDS = 512, PAL_CLI_TURN_US = 20000, PAL_CLI_WORDS_BYTES = 512 };

typedef struct pal_falcon_cli {
    const pal_falcon_options* options;
    FILE* words;  ///< stdout, or stderr with --json
    pal_firmware_file firmware;
    pal_delta_file delta;
    pal_falcon_trace_record records[PAL_CLI_RECORDS];
    pal_falcon_trace trace;
    uint64_t n_told;  ///< records told so far
    uint64_t start_us;
    pal_falcon_config config;
    pal_falcon falcon;
    pal_usb_falcon port;
    pal_pcap pcap;
    char serial[PAL_USB_TEXT_BYTES];  ///< of the device, once one was opened
} pal_falcon_cli;

/// What --delta names, or the built-in Falcon. False: words on stderr.
bool pal_cli_delta(const pal_falcon_options* options, pal_delta_file* out);

/// From now on SIGINT, SIGTERM and SIGHUP are noticed instead of ending the process.
void pal_cli_catch_signals(void);
bool pal_cli_interrupted(void);

/// Reads the firmware, opens the record and the device. 0, or the exit code with words on stderr.
int pal_cli_open(pal_falcon_cli* cli, const pal_falcon_options* options);
/// Boots, telling the stages (with --verbose every byte); until HOMING or READY. 0 or the exit code.
int pal_cli_boot(pal_falcon_cli* cli);
/// One turn of at most PAL_CLI_TURN_US. The state.
pal_falcon_state pal_cli_turn(pal_falcon_cli* cli);
/// After a fault: closes, waits for the same device until `until_us` (pal_usb_now_us; UINT64_MAX: for ever)
/// and opens it again, ready to boot. 0, interrupted, or PAL_EXIT_DEVICE when the time is over.
int pal_cli_reopen(pal_falcon_cli* cli, uint64_t until_us);
/// Says the fault on stderr. PAL_EXIT_DEVICE.
int pal_cli_tell_fault(const pal_falcon_cli* cli);
/// Zero forces, closes everything. `code`, or PAL_EXIT_DEVICE when the record could not be written.
int pal_cli_close(pal_falcon_cli* cli, int code);

/// `text` as a JSON string, quotes and all; a byte that is no UTF-8 becomes U+FFFD.
void pal_cli_json_text(FILE* out, const char* text);

int pal_falcon_list(const pal_falcon_options* options);
int pal_falcon_zero(const pal_falcon_options* options);
int pal_falcon_firmware(const pal_falcon_options* options);
int pal_falcon_boot_command(pal_falcon_cli* cli);
int pal_falcon_home(pal_falcon_cli* cli);
int pal_falcon_monitor(pal_falcon_cli* cli);
int pal_falcon_rate(pal_falcon_cli* cli);
int pal_falcon_force_check(const pal_falcon_options* options);

#ifdef __cplusplus
}
#endif
