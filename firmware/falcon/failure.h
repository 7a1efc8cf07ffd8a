/// The stages a Falcon goes through and the ways in which it can fail, each with a sentence for a person.
#pragma once
#ifdef __cplusplus
extern "C" {
#endif

typedef enum pal_falcon_stage {
    PAL_STAGE_NONE = 0,     ///< not started, or stopped
    PAL_STAGE_CHIP,         ///< the USB bridge is being set up
    PAL_STAGE_RESTART,      ///< the boot controller (a PIC) is being woken: DTR held low, then high
    PAL_STAGE_ASK,          ///< it is asked for the boot loader, 9600 baud
    PAL_STAGE_AUTOBAUD,     ///< the loader's ROM measures the baud rate from an 'A'
    PAL_STAGE_UPLOAD,       ///< the firmware goes out, each byte is echoed
    PAL_STAGE_RUN,          ///< the bridge is being set up for run time
    PAL_STAGE_FIRST_REPLY,  ///< zero-force requests until the first valid reply
    PAL_STAGE_HOMING,       ///< the user moves the grip until all three arms know where they are
    PAL_STAGE_READY,        ///< forces
    PAL_STAGE_STOPPING,     ///< requests of zero force
    PAL_STAGE_FAILED        ///< for good; pal_falcon_status says why
} pal_falcon_stage;

typedef enum pal_falcon_failure {
    PAL_FAIL_NONE = 0,
    PAL_FAIL_NO_PIC,        ///< no answer to the question for the loader: most likely no power supply
    PAL_FAIL_NO_AUTOBAUD,   ///< the loader did not echo the 'A'
    PAL_FAIL_ECHO_WRONG,    ///< byte N of the upload came back as another one
    PAL_FAIL_ECHO_TIMEOUT,  ///< byte N of the upload did not come back
    PAL_FAIL_NO_REPLY,      ///< the upload went well, the firmware does not answer
    PAL_FAIL_NO_FIRMWARE,   ///< no answer to the probe and there is, or may be, nothing to load
    PAL_FAIL_TRANSFER,      ///< the port reported a failed transfer
    PAL_FAIL_SILENT,        ///< a running device stopped answering
    PAL_FAIL_UNPLUGGED      ///< the port reported that the device is gone
} pal_falcon_failure;

/// Short name, "echo wrong". Never NULL.
const char* pal_failure_name(pal_falcon_failure failure);
/// What happened and what to do, one or two sentences. "" for PAL_FAIL_NONE. Never NULL.
const char* pal_failure_words(pal_falcon_failure failure);
const char* pal_stage_name(pal_falcon_stage stage);
/// What is going on and what the user does now.
const char* pal_stage_words(pal_falcon_stage stage);

#ifdef __cplusplus
}
#endif
