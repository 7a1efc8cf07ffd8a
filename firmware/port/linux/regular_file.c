#include "firmware/port/linux/regular_file.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

FILE* pal_regular_file_open(const char* path, const char** why) {
    struct stat about;
    const int file =
        open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // a pipe without a writer must not hold us
    if (file >= 0 && fstat(file, &about) == 0 && !S_ISREG(about.st_mode)) {
        (void)close(file);
        *why = "not a file";
        return NULL;
    }
    FILE* stream = file >= 0 ? fdopen(file, "rb") : NULL;
    *why = stream != NULL ? "" : strerror(errno);
    if (stream == NULL && file >= 0) (void)close(file);
    return stream;
}
