#include "firmware/falcon/failure.h"

const char* pal_failure_name(pal_falcon_failure failure) {
    switch (failure) {
        case PAL_FAIL_NONE:
            return "none";
        case PAL_FAIL_NO_PIC:
            return "no answer from the boot controller";
        case PAL_FAIL_NO_AUTOBAUD:
            return "no echo of the autobaud character";
        case PAL_FAIL_ECHO_WRONG:
            return "wrong echo";
        case PAL_FAIL_ECHO_TIMEOUT:
            return "echo missing";
        case PAL_FAIL_NO_REPLY:
            return "no reply after the upload";
        case PAL_FAIL_NO_FIRMWARE:
            return "no firmware running";
        case PAL_FAIL_TRANSFER:
            return "USB transfer failed";
        case PAL_FAIL_SILENT:
            return "device silent";
        case PAL_FAIL_UNPLUGGED:
            return "device unplugged";
    }
    return "none";
}

const char* pal_failure_words(pal_falcon_failure failure) {
    switch (failure) {
        case PAL_FAIL_NONE:
            return "";
        case PAL_FAIL_NO_PIC:
            return "The Falcon is on the USB but does not answer. Plug in its power supply; if it is plugged "
                   "in, take it out for five seconds and start again.";
        case PAL_FAIL_NO_AUTOBAUD:
            return "The Falcon answers but its boot loader does not start. Take its power supply out for "
                   "five seconds and start again.";
        case PAL_FAIL_ECHO_WRONG:
            return "The firmware arrived damaged. Use a shorter USB cable or another port without a hub and "
                   "start again.";
        case PAL_FAIL_ECHO_TIMEOUT:
            return "The upload of the firmware stopped half-way. Check the USB cable and the power supply "
                   "and start again.";
        case PAL_FAIL_NO_REPLY:
            return "The firmware is loaded but does not answer. Check that the file is firmware for the "
                   "Novint Falcon, take the power supply out for five seconds and start again.";
        case PAL_FAIL_NO_FIRMWARE:
            return "No firmware runs in the Falcon and loading was not allowed. Start again with the "
                   "firmware file and without the option that forbids loading.";
        case PAL_FAIL_TRANSFER:
            return "A transfer over USB failed. Check the cable, try another port and start again.";
        case PAL_FAIL_SILENT:
            return "The Falcon stopped answering, forces are off. Check its power supply and its cable.";
        case PAL_FAIL_UNPLUGGED:
            return "The Falcon was unplugged. Plug its USB cable in again.";
    }
    return "";
}

const char* pal_stage_name(pal_falcon_stage stage) {
    switch (stage) {
        case PAL_STAGE_NONE:
            return "closed";
        case PAL_STAGE_CHIP:
            return "chip";
        case PAL_STAGE_RESTART:
            return "restart";
        case PAL_STAGE_ASK:
            return "ask";
        case PAL_STAGE_AUTOBAUD:
            return "autobaud";
        case PAL_STAGE_UPLOAD:
            return "upload";
        case PAL_STAGE_RUN:
            return "run";
        case PAL_STAGE_FIRST_REPLY:
            return "first reply";
        case PAL_STAGE_HOMING:
            return "homing";
        case PAL_STAGE_READY:
            return "ready";
        case PAL_STAGE_STOPPING:
            return "stopping";
        case PAL_STAGE_FAILED:
            return "failed";
    }
    return "closed";
}

const char* pal_stage_words(pal_falcon_stage stage) {
    switch (stage) {
        case PAL_STAGE_NONE:
            return "The Falcon is not in use.";
        case PAL_STAGE_CHIP:
            return "Setting up the USB bridge.";
        case PAL_STAGE_RESTART:
            return "Waking the boot controller.";
        case PAL_STAGE_ASK:
            return "Waiting for the boot controller. Is the power supply plugged in?";
        case PAL_STAGE_AUTOBAUD:
            return "Waiting for the boot loader.";
        case PAL_STAGE_UPLOAD:
            return "Loading the firmware.";
        case PAL_STAGE_RUN:
            return "Starting the firmware.";
        case PAL_STAGE_FIRST_REPLY:
            return "Waiting for the firmware's first reply.";
        case PAL_STAGE_HOMING:
            return "Pull the grip all the way out, then push it all the way in.";
        case PAL_STAGE_READY:
            return "Ready.";
        case PAL_STAGE_STOPPING:
            return "Forces off, closing.";
        case PAL_STAGE_FAILED:
            return "Stopped by a fault, forces are off.";
    }
    return "The Falcon is not in use.";
}
