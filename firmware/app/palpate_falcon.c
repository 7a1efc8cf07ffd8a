/// palpate-falcon: a Falcon on the USB for people who set one up.
#include <stdio.h>

#include "firmware/app/falcon_cli.h"

static int run_device(const pal_falcon_options* options) {
    static pal_falcon_cli cli;
    pal_cli_catch_signals();
    int code = pal_cli_open(&cli, options);
    if (code != PAL_EXIT_DONE) return pal_cli_close(&cli, code);
    switch (options->command) {
        case PAL_COMMAND_BOOT:
            code = pal_falcon_boot_command(&cli);
            break;
        case PAL_COMMAND_HOME:
            code = pal_falcon_home(&cli);
            break;
        case PAL_COMMAND_MONITOR:
            code = pal_falcon_monitor(&cli);
            break;
        default:
            code = pal_falcon_rate(&cli);
            break;
    }
    return pal_cli_close(&cli, code);
}

static int run(const pal_falcon_options* options) {
    switch (options->command) {
        case PAL_COMMAND_HELP:
            pal_falcon_options_help(stdout);
            return PAL_EXIT_DONE;
        case PAL_COMMAND_LIST:
            return pal_falcon_list(options);
        case PAL_COMMAND_FIRMWARE:
            return pal_falcon_firmware(options);
        case PAL_COMMAND_ZERO:
            return pal_falcon_zero(options);
        case PAL_COMMAND_FORCE_CHECK:
            return pal_falcon_force_check(options);
        default:
            return run_device(options);
    }
}

int main(int argc, char** argv) {
    pal_falcon_options options;
    if (!pal_falcon_options_read(argc, argv, &options, stderr)) return PAL_EXIT_ARGUMENTS;
    const int code = run(&options);
    if ((fflush(stdout) != 0 || ferror(stdout) != 0) && code == PAL_EXIT_DONE) {
        (void)fputs("palpate-falcon: stdout cannot be written\n", stderr);
        return PAL_EXIT_VERDICT;
    }
    return code;
}
