/// Opening a file that the user has named.
#pragma once
#include <stdio.h>
#ifdef __cplusplus
extern "C" {
#endif

/// Opens `path` for reading. NULL with the reason in `*why`, a few words (static, or strerror's): what is no
/// ordinary file - a folder, a device, a pipe, which might never begin or end - is "not a file". Never waits
/// for another process.
FILE* pal_regular_file_open(const char* path, const char** why);

#ifdef __cplusplus
}
#endif
