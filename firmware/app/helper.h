/// The loop's second thread, of ordinary priority: all that is slow and must not be in the tick. It checks
/// tables, takes signals, looks for the host's process and counts what disturbs the tick's thread.
#pragma once
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>

#include "firmware/app/session.h"
#ifdef __cplusplus
extern "C" {
#endif

typedef struct pal_helper {
    pthread_t thread;
    pal_session* session;
    const volatile sig_atomic_t* signal_seen;
    uint32_t watched_thread;  ///< its id, when it is to be watched; 0 before
    uint32_t stop;            ///< asks the thread to end
} pal_helper;

/// Starts the thread, which gets the signals that the caller blocks later. False: the system refuses.
bool pal_helper_start(pal_helper* helper, pal_session* session, const volatile sig_atomic_t* signal_seen);
/// Disturbances of the calling thread count from now on, into the words of the link.
void pal_helper_watch_me(pal_helper* helper);
/// Counts once more and ends the thread.
void pal_helper_stop(pal_helper* helper);

#ifdef __cplusplus
}
#endif
