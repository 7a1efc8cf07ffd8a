/// palpate-falcon-sim run: a simulator and a program that sees it.
#pragma once
#include "sim/app/options.h"

/// Runs options->rest with the simulated devices. The program's exit code (128 + signal when one ended it), 2
/// when the command line is bad, 3 when the simulator does not start or cannot be shown to the program, 126
/// or 127 when the program does not. The program gets SIGTERM when this process is killed.
int pal_run(pal_options* options);
/// Prints what a shell must set so that its programs see the bus. 0 or 3.
int pal_env(const char* bus_folder);
