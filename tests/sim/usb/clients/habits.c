// What programs do besides using the device. Usage: habits WHAT [NODE]. Exit 0 as it should be, 1 and a
// sentence otherwise.
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <libusb.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>
// <sys/ioctl.h> first: the next one needs its macros.
#include <linux/usbdevice_fs.h>

#define EXPECT(condition)                                                   \
    do {                                                                    \
        if (!(condition)) {                                                 \
            fprintf(stderr, "habits: line %d: %s\n", __LINE__, #condition); \
            exit(1);                                                        \
        }                                                                   \
    } while (0)

static void nothing(int signal_number) {
    (void)signal_number;
}

/// A profiler's or a timer's signals, all the time: no call fails for them.
static int signals(void) {
    EXPECT(libusb_init(NULL) == 0);
    struct sigaction action = {.sa_handler = nothing};
    const struct itimerval often = {{0, 100}, {0, 100}};
    EXPECT(sigaction(SIGALRM, &action, NULL) == 0 && setitimer(ITIMER_REAL, &often, NULL) == 0);
    for (int i = 0; i < 100; ++i) {
        libusb_device_handle* device = libusb_open_device_with_vid_pid(NULL, 0x0403, 0xCB48);
        EXPECT(device && libusb_claim_interface(device, 0) == 0);
        EXPECT(libusb_set_interface_alt_setting(device, 0, 0) == 0);
        EXPECT(libusb_release_interface(device, 0) == 0);
        libusb_close(device);
    }
    libusb_exit(NULL);
    return 0;
}

static int n_descriptors(void) {
    int n = 0;
    for (int fd = 0; fd < 1024; ++fd) n += fcntl(fd, F_GETFD) >= 0;
    return n;
}

/// Coming and going leaves no descriptor behind.
static int inits(void) {
    const int before = n_descriptors();
    for (int i = 0; i < 10; ++i) {
        libusb_context* context;
        EXPECT(libusb_init(&context) == 0);
        libusb_exit(context);
    }
    EXPECT(n_descriptors() == before);
    return 0;
}

/// A descriptor that was a device and is another file now.
static int replaced(const char* node) {
    const int other = open("/dev/null", O_RDWR);
    for (int how = 0; how < 3; ++how) {
        uint32_t known = 0;
        const int device = open(node, O_RDWR);
        EXPECT(device >= 0 && other >= 0 && ioctl(device, USBDEVFS_GET_CAPABILITIES, &known) == 0);
        if (how == 0) EXPECT(dup2(other, device) == device);
        if (how == 1) EXPECT(dup3(other, device, O_CLOEXEC) == device);
        if (how == 2) EXPECT(close_range((unsigned)device, (unsigned)device, 0) == 0);
        if (how == 2) EXPECT(fcntl(other, F_DUPFD, device) == device);
        EXPECT(ioctl(device, USBDEVFS_GET_CAPABILITIES, &known) < 0 && errno == ENOTTY);
        EXPECT(close(device) == 0);
    }
    return 0;
}

/// What a child of vfork closes before it starts a program is its own.
static int vforks(const char* node) {
    uint32_t known = 0;
    int status = -1;
    const int device = open(node, O_RDWR);
    EXPECT(device >= 0);
    const pid_t child = vfork();
    if (child == 0) {
        close(device);
        close_range(3, ~0U, 0);
        _exit(0);
    }
    EXPECT(waitpid(child, &status, 0) == child && status == 0);
    EXPECT(ioctl(device, USBDEVFS_GET_CAPABILITIES, &known) == 0);
    EXPECT(close(device) == 0);
    return 0;
}

/// Without a bus there is no device, nor a real one; what is elsewhere is there.
static int hidden(void) {
    struct stat found;
    EXPECT(open("/dev/bus/usb/001/001", O_RDWR) < 0 && errno == ENOENT);
    EXPECT(opendir("/dev/bus/usb") == NULL && errno == ENOENT);
    EXPECT(stat("/dev/bus/usb", &found) != 0 && errno == ENOENT);
    EXPECT(access("/sys/bus/usb/devices", F_OK) != 0 && errno == ENOENT);
    EXPECT(stat("/dev", &found) == 0 && stat("/dev/null", &found) == 0);
    return 0;
}

/// The environment is the program's: what it does to it changes nothing here.
static int forgets(const char* node) {
    EXPECT(clearenv() == 0);
    const int device = open(node, O_RDWR);
    EXPECT(device >= 0 && close(device) == 0);
    return 0;
}

int main(int argc, char** argv) {
    const char* what = argc > 1 ? argv[1] : "";
    const char* node = argc > 2 ? argv[2] : "/dev/bus/usb/001/002";
    if (strcmp(what, "signals") == 0) return signals();
    if (strcmp(what, "inits") == 0) return inits();
    if (strcmp(what, "replaced") == 0) return replaced(node);
    if (strcmp(what, "vforks") == 0) return vforks(node);
    if (strcmp(what, "hidden") == 0) return hidden();
    if (strcmp(what, "forgets") == 0) return forgets(node);
    fprintf(stderr, "habits: signals, inits, replaced, vforks, hidden or forgets\n");
    return 2;
}
