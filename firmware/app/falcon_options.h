/// The command line of palpate-falcon.
#pragma once
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef enum pal_falcon_command {
    PAL_COMMAND_HELP = 0,
    PAL_COMMAND_LIST,
    PAL_COMMAND_FIRMWARE,
    PAL_COMMAND_BOOT,
    PAL_COMMAND_HOME,
    PAL_COMMAND_MONITOR,
    PAL_COMMAND_RATE,
    PAL_COMMAND_ZERO,
    PAL_COMMAND_FORCE_CHECK
} pal_falcon_command;

typedef struct pal_falcon_options {
    pal_falcon_command command;
    const char* serial;    ///< NULL: the first by serial
    const char* firmware;  ///< NULL: the usual places
    const char* delta;     ///< file of geometry and gains; NULL: the built-in Falcon NF1
    const char* pcap;      ///< NULL: no record
    bool json, verbose;
    bool no_reload;        ///< use the firmware that runs
    bool no_event_char;    ///< the bridge waits for its timer with each reply
    bool after_stdin;      ///< of zero: wait for the end of stdin (usb_guard.h)
    uint32_t n_attempts;   ///< at booting; 0: the usual number
    double seconds;        ///< of monitor, 0: for ever; of home: patience; of rate
    uint32_t n_exchanges;  ///< of rate; 0: until `seconds`
    uint32_t period_us;    ///< of rate
    double rate_min_hz;    ///< of rate: below it the verdict is bad
} pal_falcon_options;

/// Reads argv. What is wrong goes to `complaint`, one line, and false is returned.
bool pal_falcon_options_read(int argc, char** argv, pal_falcon_options* options, FILE* complaint);
void pal_falcon_options_help(FILE* out);

#ifdef __cplusplus
}
#endif
