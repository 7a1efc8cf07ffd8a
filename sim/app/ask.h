/// Questions to a running simulator over its control socket.
#pragma once

/// Sends `question` to the socket at `path` and prints the answer. 0; 2 when the answer is an error; 3 when
/// nobody answers, with `start` in the words: how to start one.
int pal_ask(const char* path, const char* question, const char* start);
