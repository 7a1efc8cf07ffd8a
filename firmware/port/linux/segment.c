#include "firmware/port/linux/segment.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static pal_err map(int file, pal_link** link) {
    struct stat info;
    if (fstat(file, &info) != 0) return PAL_ERR_IO;
    if (info.st_size < (off_t)sizeof(pal_link)) return PAL_ERR_SIZE;
    void* at = mmap(NULL, sizeof(pal_link), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file, 0);
    if (at == MAP_FAILED) return PAL_ERR_IO;
    const pal_err err = pal_link_check((const pal_link*)at, (size_t)info.st_size);
    if (err != PAL_OK) {
        munmap(at, sizeof(pal_link));
        return err;
    }
    *link = (pal_link*)at;
    return PAL_OK;
}

pal_err pal_segment_attach(const char* name, pal_link** link) {
    const int file = shm_open(name, O_RDWR, 0);
    if (file < 0) return PAL_ERR_IO;
    const pal_err err = map(file, link);
    const int why = errno;
    close(file);
    errno = why;
    return err;
}

void pal_segment_detach(pal_link* link) {
    munmap(link, sizeof *link);
}
