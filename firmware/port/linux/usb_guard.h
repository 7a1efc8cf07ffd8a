/// A process that outlives the one that makes forces: nobody knows how soon a Falcon by itself lets go, so
/// when a loop is killed or crashes, its guard sends the requests of zero force that the loop cannot send any
/// more.
#pragma once
#include <stdbool.h>
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_USB_GUARD_FAREWELL = 'z', PAL_USB_GUARD_END_MS = 1000 };

/// Zero-initialise, file -1, when there is none.
typedef struct pal_usb_guard {
    int file;  ///< the other end of its stdin; closed without a farewell, it says that the loop is gone
    int process;
} pal_usb_guard;

/// Starts `program` (palpate-falcon) as `zero --after-stdin --serial SERIAL`, in a session of its own: Ctrl-C
/// does not reach it. False with errno; `guard` is then none.
bool pal_usb_guard_start(pal_usb_guard* guard, const char* program, const char* serial);
/// The guard's part: waits for the end of stdin. False: with a farewell, there is nothing to do.
bool pal_usb_guard_is_needed(void);
/// The zero forces are out: bids farewell and waits for its end, PAL_USB_GUARD_END_MS at most.
void pal_usb_guard_dismiss(pal_usb_guard* guard);

#ifdef __cplusplus
}
#endif
