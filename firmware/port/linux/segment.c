#include "firmware/port/linux/segment.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

enum { PERMISSIONS = 0777, OWNER_ONLY = 0600 };

static pal_err map(int file, pal_link** link) {
    struct stat info;
    if (fstat(file, &info) != 0) return PAL_ERR_IO;
    const bool owned = info.st_uid == geteuid();
    if (!owned || (info.st_mode & PERMISSIONS) != OWNER_ONLY) {
        errno = owned ? EACCES : EPERM;
        return PAL_ERR_IO;
    }
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

static void close_quietly(int file) {
    const int why = errno;
    close(file);
    errno = why;
}

pal_err pal_segment_attach(const char* name, pal_link** link) {
    const int file = shm_open(name, O_RDWR, 0);
    if (file < 0) return PAL_ERR_IO;
    const pal_err err = map(file, link);
    close_quietly(file);
    return err;
}

void pal_segment_detach(pal_link* link) {
    munmap(link, sizeof *link);
}

// ---- the segment's one loop

// A lock of the open file, not of the process: gone when the process is, however it ends.
static bool lock_words(int file) {
    struct flock lock = {
        .l_type = F_WRLCK,
        .l_whence = SEEK_SET,
        .l_start = offsetof(pal_link, loop),
        .l_len = sizeof(pal_link_loop),
    };
    return fcntl(file, F_OFD_SETLK, &lock) == 0;
}

static void begin_words(pal_link_loop* loop) {
    uint32_t* const words[] = {&loop->heartbeat,      &loop->ended,          &loop->end_reason,
                               &loop->n_bad_tables,   &loop->realtime,       &loop->realtime_refused,
                               &loop->n_minor_faults, &loop->n_major_faults, &loop->n_preempted};
    for (size_t i = 0; i < sizeof words / sizeof words[0]; ++i) pal_link_store(words[i], 0);
    pal_link_store(&loop->pid, (uint32_t)getpid());
}

pal_err pal_segment_take(const char* name, pal_segment* segment, uint32_t* holder) {
    pal_link* link = NULL;
    *holder = 0;
    const int file = shm_open(name, O_RDWR, 0);
    if (file < 0) return PAL_ERR_IO;
    const pal_err err = map(file, &link);
    if (err != PAL_OK) {
        close_quietly(file);
        return err;
    }
    if (!lock_words(file)) {
        *holder = pal_link_load(&link->loop.pid);
        pal_segment_detach(link);
        close(file);
        errno = EBUSY;
        return PAL_ERR_IO;
    }
    begin_words(&link->loop);
    *segment = (pal_segment){.link = link, .file = file};
    return PAL_OK;
}

void pal_segment_give(pal_segment* segment) {
    pal_segment_detach(segment->link);
    close(segment->file);
    *segment = (pal_segment){.link = NULL, .file = -1};
}

const char* pal_segment_words(pal_err err, int why) {
    if (err != PAL_ERR_IO) return pal_err_words(err);
    switch (why) {
        case ENOENT:
            return "there is no such segment; a host makes it (palpate run --clock real)";
        case EPERM:
            return "it belongs to another user";
        case EACCES:
            return "its permissions must be 0600: who can write to it decides on forces";
        case EBUSY:
            return "it has a loop already";
        default:
            return strerror(why);
    }
}

// ---- a truncated segment

// Set once, before the handler; a signal handler has no other way to know.
static struct {
    uint8_t* begin;
    uint32_t* gone;
} watched;

static void on_bus_error(int number, siginfo_t* info, void* context) {
    (void)context;
    const uint8_t* at = (const uint8_t*)info->si_addr;
    const bool inside = at >= watched.begin && at < watched.begin + sizeof(pal_link);
    const int flags = MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED;
    if (inside && mmap(watched.begin, sizeof(pal_link), PROT_READ | PROT_WRITE, flags, -1, 0) != MAP_FAILED) {
        pal_link_store(watched.gone, 1);
        return;  // the same instruction again, on zeros
    }
    (void)signal(number, SIG_DFL);  // and again, which ends the process
}

void pal_segment_watch(pal_link* link, uint32_t* gone) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    watched.begin = (uint8_t*)link;
    watched.gone = gone;
    action.sa_sigaction = on_bus_error;
    action.sa_flags = SA_SIGINFO;
    sigemptyset(&action.sa_mask);
    (void)sigaction(SIGBUS, &action, NULL);
}
