// libpalpate-falcon-preload.so: shows the simulated Falcon to a program that uses libusb-1.0, by standing
// before the functions of the C library by which that finds and drives USB devices. Paths below
// /sys/bus/usb/devices and /dev/bus/usb lead to the bus folder; real USB devices are not seen. Not caught:
// programs that are statically linked, setuid, or call the kernel themselves.
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include "sim/usb/preload.h"

// Once read, never again: a program's own setenv in another thread must not meet a getenv in here.
static char g_bus[PAL_PRELOAD_PATH_MAX];
static pthread_once_t g_once = PTHREAD_ONCE_INIT;
static pid_t g_pid;  // whose memory this is: vfork calls no fork handler

enum { SYSFS_TYPE = 0x62656572, SPEED_FULL = 2 };

/// What the next library in line defines.
typedef struct next_library {
    int (*openat)(int, const char*, int, ...);
    int (*close)(int);
    int (*dup2)(int, int);
    int (*dup3)(int, int, int);
    int (*close_range)(unsigned, unsigned, int);
    int (*ioctl)(int, unsigned long, ...);
    DIR* (*opendir)(const char*);
    ssize_t (*readlink)(const char*, char*, size_t);
    int (*access)(const char*, int);
    int (*fstatat)(int, const char*, struct stat*, int);
    int (*statfs)(const char*, struct statfs*);
    FILE* (*fopen)(const char*, const char*);
} next_library;

static void find(void* function, const char* name) {
    void* const found = dlsym(RTLD_NEXT, name);
    if (!found) {
        (void)fprintf(stderr,
                      "palpate-falcon-preload: the C library has no %s; it must be glibc 2.33 or later\n",
                      name);
        abort();
    }
    memcpy(function, &found, sizeof found);
}

static next_library g_next;

static void note_process(void) {
    g_pid = getpid();
}

static void begin(void) {
    note_process();
    (void)pthread_atfork(NULL, NULL, note_process);
    find(&g_next.openat, "openat");
    find(&g_next.close, "close");
    find(&g_next.dup2, "dup2");
    find(&g_next.dup3, "dup3");
    find(&g_next.close_range, "close_range");
    find(&g_next.ioctl, "ioctl");
    find(&g_next.opendir, "opendir");
    find(&g_next.readlink, "readlink");
    find(&g_next.access, "access");
    find(&g_next.fstatat, "fstatat");
    find(&g_next.statfs, "statfs");
    find(&g_next.fopen, "fopen");
    const char* bus = secure_getenv(PAL_BUS_VARIABLE);
    if (bus && strlen(bus) < sizeof g_bus) memcpy(g_bus, bus, strlen(bus) + 1);
}

static const next_library* next(void) {
    (void)pthread_once(&g_once, begin);
    return &g_next;
}

bool pal_preload_owns_memory(void) {
    (void)next();
    return getpid() == g_pid;
}

const char* pal_preload_bus(void) {
    (void)next();
    return g_bus[0] != '\0' ? g_bus : NULL;
}

__attribute__((constructor)) static void start(void) {
    (void)next();
    if (pal_preload_bus()) return;
    (void)fprintf(
        stderr,
        "palpate-falcon-preload: " PAL_BUS_VARIABLE
        " names no bus folder, no Falcon will be seen; start the program with: palpate-falcon-sim run -- "
        "PROGRAM\n");
}

static bool below(const char* path, const char* folder) {
    const size_t n = strlen(folder);
    return strncmp(path, folder, n) == 0 && (path[n] == '\0' || path[n] == '/');
}

const char* pal_preload_redirect(const char* path, char room[PAL_PRELOAD_PATH_MAX]) {
    if (!path || (!below(path, PAL_BUS_SYS) && !below(path, PAL_BUS_DEV))) return path;
    const char* bus = pal_preload_bus();
    const int n = bus ? snprintf(room, PAL_PRELOAD_PATH_MAX, "%s%s", bus, path) : -1;
    return n > 0 && n < PAL_PRELOAD_PATH_MAX ? room : "";  // "": no such file, never a real device
}

// Opening: all variants are openat.

static int open_any(int folder, const char* path, int flags, mode_t mode) {
    char room[PAL_PRELOAD_PATH_MAX];
    const char* there = pal_preload_redirect(path, room);
    struct stat found;
    if (there != path && below(path, PAL_BUS_DEV) && next()->fstatat(AT_FDCWD, there, &found, 0) == 0 &&
        S_ISSOCK(found.st_mode)) {
        return pal_preload_link_open(there, path, flags);
    }
    return next()->openat(folder, there, flags, mode);
}

/// The mode that follows `flags` when these make a file.
#define MODE_AFTER(flags, mode)                                       \
    mode_t mode = 0;                                                  \
    if (((flags)&O_CREAT) != 0 || ((flags)&O_TMPFILE) == O_TMPFILE) { \
        va_list more;                                                 \
        va_start(more, flags);                                        \
        mode = va_arg(more, mode_t);                                  \
        va_end(more);                                                 \
    }

PAL_PRELOAD_EXPORT int open(const char* path, int flags, ...) {
    MODE_AFTER(flags, mode)
    return open_any(AT_FDCWD, path, flags, mode);
}
PAL_PRELOAD_EXPORT int open64(const char* path, int flags, ...) {
    MODE_AFTER(flags, mode)
    return open_any(AT_FDCWD, path, flags | O_LARGEFILE, mode);
}
PAL_PRELOAD_EXPORT int openat(int folder, const char* path, int flags, ...) {
    MODE_AFTER(flags, mode)
    return open_any(folder, path, flags, mode);
}
PAL_PRELOAD_EXPORT int openat64(int folder, const char* path, int flags, ...) {
    MODE_AFTER(flags, mode)
    return open_any(folder, path, flags | O_LARGEFILE, mode);
}

// What a fortified program calls instead.
PAL_PRELOAD_EXPORT int __open_2(const char* path, int flags);
PAL_PRELOAD_EXPORT int __open64_2(const char* path, int flags);
PAL_PRELOAD_EXPORT int __openat_2(int folder, const char* path, int flags);
PAL_PRELOAD_EXPORT int __openat64_2(int folder, const char* path, int flags);
int __open_2(const char* path, int flags) {
    return open_any(AT_FDCWD, path, flags, 0);
}
int __open64_2(const char* path, int flags) {
    return open_any(AT_FDCWD, path, flags | O_LARGEFILE, 0);
}
int __openat_2(int folder, const char* path, int flags) {
    return open_any(folder, path, flags, 0);
}
int __openat64_2(int folder, const char* path, int flags) {
    return open_any(folder, path, flags | O_LARGEFILE, 0);
}

PAL_PRELOAD_EXPORT int close(int fd) {
    pal_preload_link_close(fd);
    return next()->close(fd);
}

// Other ways of closing.

PAL_PRELOAD_EXPORT int dup2(int from, int to) {
    if (from != to) pal_preload_link_close(to);
    return next()->dup2(from, to);
}
PAL_PRELOAD_EXPORT int dup3(int from, int to, int flags) {
    if (from != to) pal_preload_link_close(to);
    return next()->dup3(from, to, flags);
}
PAL_PRELOAD_EXPORT int close_range(unsigned first, unsigned last, int flags) {
    if (flags == 0) pal_preload_link_close_range(first, last);
    return next()->close_range(first, last, flags);
}
PAL_PRELOAD_EXPORT void closefrom(int first) {
    (void)close_range(first > 0 ? (unsigned)first : 0U, ~0U, 0);
}

// Looking at folders and files.

PAL_PRELOAD_EXPORT DIR* opendir(const char* path) {
    char room[PAL_PRELOAD_PATH_MAX];
    return next()->opendir(pal_preload_redirect(path, room));
}
PAL_PRELOAD_EXPORT FILE* fopen(const char* path, const char* mode) {
    char room[PAL_PRELOAD_PATH_MAX];
    return next()->fopen(pal_preload_redirect(path, room), mode);
}
PAL_PRELOAD_EXPORT FILE* fopen64(const char* path, const char* mode) {
    return fopen(path, mode);
}
PAL_PRELOAD_EXPORT int access(const char* path, int mode) {
    char room[PAL_PRELOAD_PATH_MAX];
    return next()->access(pal_preload_redirect(path, room), mode);
}
PAL_PRELOAD_EXPORT int stat(const char* restrict path, struct stat* restrict out) {
    char room[PAL_PRELOAD_PATH_MAX];
    return next()->fstatat(AT_FDCWD, pal_preload_redirect(path, room), out, 0);
}
PAL_PRELOAD_EXPORT int lstat(const char* restrict path, struct stat* restrict out) {
    char room[PAL_PRELOAD_PATH_MAX];
    return next()->fstatat(AT_FDCWD, pal_preload_redirect(path, room), out, AT_SYMLINK_NOFOLLOW);
}

/// libusb trusts /sys only when it is a sysfs.
PAL_PRELOAD_EXPORT int statfs(const char* path, struct statfs* out) {
    const int code = next()->statfs(path, out);
    if (code == 0 && pal_preload_bus() && strcmp(path, "/sys") == 0) out->f_type = SYSFS_TYPE;
    return code;
}

/// A descriptor of ours is a device node, whatever it is made of.
PAL_PRELOAD_EXPORT ssize_t readlink(const char* restrict path, char* restrict out, size_t n_out) {
    int fd = -1;
    char rest;
    const pal_preload_link* link =
        sscanf(path, "/proc/self/fd/%d%c", &fd, &rest) == 1 ? pal_preload_link_of(fd) : NULL;
    if (link) {
        const char* node = pal_preload_link_node(link);
        const size_t n = strlen(node) < n_out ? strlen(node) : n_out;
        memcpy(out, node, n);
        return (ssize_t)n;
    }
    char room[PAL_PRELOAD_PATH_MAX];
    return next()->readlink(pal_preload_redirect(path, room), out, n_out);
}

// The ioctls of usbfs.

static int refuse(int reason) {
    errno = reason;
    return -1;
}

static int capabilities(void* argument) {
    const uint32_t known =
        USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
    memcpy(argument, &known, sizeof known);
    return 0;
}

static int reap(pal_preload_link* link, void* argument, bool wait) {
    struct usbdevfs_urb** urb = argument;
    return pal_preload_reap(link, urb, wait);
}

/// A call whose argument is one unsigned int.
static int call_with_number(pal_preload_link* link, pal_wire_call_kind kind, const void* argument) {
    unsigned int number;
    memcpy(&number, argument, sizeof number);
    return pal_preload_call(link, kind, number);
}

static int set_interface(pal_preload_link* link, const void* argument) {
    const struct usbdevfs_setinterface* wanted = argument;
    if (wanted->interface > 0xFF || wanted->altsetting > 0xFF) return refuse(EINVAL);
    return pal_preload_call(link, PAL_WIRE_INTERFACE, wanted->interface << 8 | wanted->altsetting);
}

static int disconnect_claim(pal_preload_link* link, const void* argument) {
    const struct usbdevfs_disconnect_claim* wanted = argument;
    const int code = pal_preload_call(link, PAL_WIRE_CLAIM, wanted->interface);
    return code < 0 && errno == ENOENT ? refuse(EINVAL) : code;  // as usbfs says it here
}

static int node_ioctl(pal_preload_link* link, unsigned long request, void* argument) {
    switch (request) {
        case USBDEVFS_SUBMITURB:
            return pal_preload_submit(link, argument);
        case USBDEVFS_DISCARDURB:
            return pal_preload_discard(link, argument);
        case USBDEVFS_REAPURBNDELAY:
            return reap(link, argument, false);
        case USBDEVFS_REAPURB:
            return reap(link, argument, true);
        case USBDEVFS_GET_CAPABILITIES:
            return capabilities(argument);
        case USBDEVFS_GET_SPEED:
            return SPEED_FULL;
        case USBDEVFS_CLAIMINTERFACE:
            return call_with_number(link, PAL_WIRE_CLAIM, argument);
        case USBDEVFS_RELEASEINTERFACE:
            return call_with_number(link, PAL_WIRE_RELEASE, argument);
        case USBDEVFS_SETCONFIGURATION:
            return call_with_number(link, PAL_WIRE_CONFIGURATION, argument);
        case USBDEVFS_CLEAR_HALT:
        case USBDEVFS_RESETEP:
            return call_with_number(link, PAL_WIRE_CLEAR_HALT, argument);
        case USBDEVFS_SETINTERFACE:
            return set_interface(link, argument);
        case USBDEVFS_DISCONNECT_CLAIM:
            return disconnect_claim(link, argument);
        case USBDEVFS_RESET:
            return pal_preload_call(link, PAL_WIRE_RESET, 0);
        case USBDEVFS_GETDRIVER:
        case USBDEVFS_IOCTL:
            return refuse(ENODATA);  // no kernel driver holds it
        default:
            return refuse(ENOTTY);
    }
}

PAL_PRELOAD_EXPORT int ioctl(int fd, unsigned long request, ...) {
    va_list more;
    va_start(more, request);
    void* argument = va_arg(more, void*);
    va_end(more);
    pal_preload_link* link = pal_preload_link_of(fd);
    return link ? node_ioctl(link, request, argument) : next()->ioctl(fd, request, argument);
}
