/// What the device and its loop allow at most: one place for the loop's options and the scene's keys.
#pragma once

#define PAL_FORCE_DEVICE_MAX_N 8.9  ///< rated force of a Falcon; a limit on |force| is in (0, this]
#define PAL_RAMP_MAX_S 60           ///< longest soft start
