/// The simulated Falcon as a process: 1 kHz by the wall clock, packets over a Unix socket, questions over
/// another.
#pragma once
#include <stdbool.h>
#include <stdint.h>

#include "sim/falcon/falcon_sim.h"
#include "sim/hand/hand.h"

typedef struct pal_serve_options {
    const char*
        socket_path;        ///< SOCK_SEQPACKET: a request in, a reply out; questions go to this + ".control"
    bool die_with_parent;   ///< end when the process that started this one has ended ...
    uint32_t linger_ticks;  ///< ... and so many ticks have passed, in which questions are still answered
    pal_falcon_sim_config falcon;
    pal_hand_config hand;
} pal_serve_options;

/// Serves until SIGTERM, SIGINT, "quit" or the parent's death. The exit code of the process: 0, 2 or 3.
int pal_serve(const pal_serve_options* options);
/// Sends `question` ("status" or "quit") to the one that serves `socket_path` and prints the answer. 0 or 3.
int pal_serve_ask(const char* socket_path, const char* question);
