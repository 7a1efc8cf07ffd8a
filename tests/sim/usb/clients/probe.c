// A program on libusb that tries one thing at a time. Usage: probe WHAT. Exit 0 as it should be, 1 and a
// sentence otherwise. Of the endless ones: 42 when the device left, 43 when it did before it was claimed.
#include <errno.h>
#include <libusb.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { MS = 1000, LEFT = 42, NEVER_THERE = 43, VENDOR = 0x0403, PRODUCT = 0xCB48, N_TRANSFERS = 4 };

#define EXPECT(condition)                                                  \
    do {                                                                   \
        if (!(condition)) {                                                \
            fprintf(stderr, "probe: line %d: %s\n", __LINE__, #condition); \
            exit(1);                                                       \
        }                                                                  \
    } while (0)

static bool endless;

static libusb_device_handle* open_claimed(void) {
    libusb_device_handle* device = libusb_open_device_with_vid_pid(NULL, VENDOR, PRODUCT);
    const int code = device ? libusb_claim_interface(device, 0) : LIBUSB_ERROR_NO_DEVICE;
    if (endless && code == LIBUSB_ERROR_NO_DEVICE) exit(NEVER_THERE);
    EXPECT(code == 0);
    return device;
}

static int request(libusb_device_handle* device, uint8_t what, uint16_t value) {
    return libusb_control_transfer(device, 0x40, what, value, 0, NULL, 0, MS);
}

static int latency(libusb_device_handle* device, uint16_t ms) {
    return request(device, 9, ms);
}

static int list(void) {
    libusb_device** all;
    const ssize_t n = libusb_get_device_list(NULL, &all);
    for (ssize_t i = 0; i < n; ++i) {
        struct libusb_device_descriptor d;
        libusb_device_handle* device;
        unsigned char text[3][64] = {"", "", ""};
        EXPECT(libusb_get_device_descriptor(all[i], &d) == 0);
        EXPECT(libusb_open(all[i], &device) == 0);
        EXPECT(libusb_get_string_descriptor_ascii(device, d.iManufacturer, text[0], sizeof text[0]) > 0);
        EXPECT(libusb_get_string_descriptor_ascii(device, d.iProduct, text[1], sizeof text[1]) > 0);
        EXPECT(libusb_get_string_descriptor_ascii(device, d.iSerialNumber, text[2], sizeof text[2]) > 0);
        printf("%04x:%04x bcd %04x speed %d config %d: %s, %s, %s\n", d.idVendor, d.idProduct, d.bcdDevice,
               libusb_get_device_speed(all[i]), d.bNumConfigurations, text[0], text[1], text[2]);
        libusb_close(device);
    }
    libusb_free_device_list(all, 1);
    return 0;
}

static int standard(void) {
    libusb_device_handle* device = open_claimed();
    int configuration = 0;
    EXPECT(libusb_get_configuration(device, &configuration) == 0 && configuration == 1);
    EXPECT(libusb_set_interface_alt_setting(device, 0, 0) == 0);
    EXPECT(libusb_clear_halt(device, 0x81) == 0);
    EXPECT(libusb_kernel_driver_active(device, 0) == 0);
    EXPECT(libusb_claim_interface(device, 5) == LIBUSB_ERROR_NOT_FOUND);
    EXPECT(libusb_set_auto_detach_kernel_driver(device, 1) == 0);
    EXPECT(libusb_reset_device(device) == 0);
    uint8_t ms = 0;
    EXPECT(latency(device, 77) == 0);
    EXPECT(libusb_control_transfer(device, 0xC0, 10, 0, 0, &ms, 1, MS) == 1 && ms == 77);
    EXPECT(request(device, 0x66, 0) == LIBUSB_ERROR_PIPE);  // no such request: stall
    uint8_t byte;
    int moved;
    EXPECT(libusb_bulk_transfer(device, 0x83, &byte, 1, &moved, MS) != 0);  // no such endpoint
    EXPECT(libusb_release_interface(device, 0) == 0);
    libusb_close(device);
    return 0;
}

static int overflow(void) {
    libusb_device_handle* device = open_claimed();
    uint8_t byte;
    int moved;
    EXPECT(libusb_bulk_transfer(device, 0x81, &byte, 1, &moved, MS) ==
           LIBUSB_ERROR_OVERFLOW);  // two status bytes
    libusb_close(device);
    return 0;
}

static int timeout(void) {
    libusb_device_handle* device = open_claimed();
    uint8_t packet[64];
    int moved;
    EXPECT(latency(device, 255) == 0);
    EXPECT(libusb_bulk_transfer(device, 0x81, packet, 64, &moved, MS) ==
           0);  // from here a packet takes 255 ms
    EXPECT(libusb_bulk_transfer(device, 0x81, packet, 64, &moved, 5) == LIBUSB_ERROR_TIMEOUT);
    EXPECT(latency(device, 1) == 0);
    EXPECT(libusb_bulk_transfer(device, 0x81, packet, 64, &moved, MS) == 0 && moved == 2);
    libusb_close(device);
    return 0;
}

// Asynchronous.

static int n_ended, last_status;

static void LIBUSB_CALL ended(struct libusb_transfer* transfer) {
    ++n_ended;
    last_status = (int)transfer->status;
}

static int cancel(void) {
    libusb_device_handle* device = open_claimed();
    uint8_t packet[64];
    int moved;
    EXPECT(latency(device, 255) == 0);
    EXPECT(libusb_bulk_transfer(device, 0x81, packet, 64, &moved, MS) == 0);
    struct libusb_transfer* transfer = libusb_alloc_transfer(0);
    libusb_fill_bulk_transfer(transfer, device, 0x81, packet, 64, ended, NULL, 0);
    EXPECT(libusb_submit_transfer(transfer) == 0);
    EXPECT(libusb_cancel_transfer(transfer) == 0);
    while (n_ended == 0) EXPECT(libusb_handle_events(NULL) == 0);
    EXPECT(last_status == LIBUSB_TRANSFER_CANCELLED);
    EXPECT(libusb_cancel_transfer(transfer) == LIBUSB_ERROR_NOT_FOUND);
    EXPECT(latency(device, 1) == 0);
    EXPECT(libusb_bulk_transfer(device, 0x81, packet, 64, &moved, MS) == 0);
    libusb_free_transfer(transfer);
    libusb_close(device);
    return 0;
}

static void LIBUSB_CALL again(struct libusb_transfer* transfer) {
    last_status = (int)transfer->status;
    if (transfer->status == LIBUSB_TRANSFER_COMPLETED && libusb_submit_transfer(transfer) == 0) {
        ++n_ended;
    } else {
        *(int*)transfer->user_data = 0;
    }
}

/// Several INs always posted, as fast drivers do, until `n` have come or the device leaves.
static int post_reads(long n, unsigned timeout_ms) {
    libusb_device_handle* device = open_claimed();
    static uint8_t packets[N_TRANSFERS][64];
    int alive[N_TRANSFERS];
    struct libusb_transfer* transfers[N_TRANSFERS];
    EXPECT(latency(device, 1) == 0 || endless);
    for (int i = 0; i < N_TRANSFERS; ++i) {
        alive[i] = 1;
        transfers[i] = libusb_alloc_transfer(0);
        libusb_fill_bulk_transfer(transfers[i], device, 0x81, packets[i], 64, again, &alive[i], timeout_ms);
        const int code = libusb_submit_transfer(transfers[i]);
        if (code != 0) alive[i] = 0;
    }
    bool cancelled = false;
    while (alive[0] || alive[1] || alive[2] || alive[3]) {
        (void)libusb_handle_events(NULL);
        if (n_ended >= n && !cancelled) {
            cancelled = true;
            for (int i = 0; i < N_TRANSFERS; ++i) libusb_cancel_transfer(transfers[i]);
        }
    }
    for (int i = 0; i < N_TRANSFERS; ++i) libusb_free_transfer(transfers[i]);
    libusb_close(device);
    return cancelled ? 0 : LEFT;
}

// Claims.

static int claims(void) {
    libusb_device_handle* one = open_claimed();
    libusb_device_handle* two = libusb_open_device_with_vid_pid(NULL, VENDOR, PRODUCT);
    EXPECT(two && libusb_claim_interface(two, 0) == LIBUSB_ERROR_BUSY);
    libusb_close(one);
    EXPECT(libusb_claim_interface(two, 0) == 0);
    libusb_close(two);
    for (int i = 0; i < 300; ++i) {  // a claim ends with its handle, at once, also with transfers in flight
        libusb_device_handle* device = open_claimed();
        EXPECT(latency(device, 1) == 0);
        libusb_close(device);
    }
    return 0;
}

// Threads.

static void* talk(void* context) {
    libusb_device_handle* device = context;
    for (int i = 0; i < 200; ++i) {
        uint8_t ms = 0;
        EXPECT(libusb_control_transfer(device, 0xC0, 10, 0, 0, &ms, 1, MS) == 1 && ms == 2);
    }
    return NULL;
}

static void* listen_in(void* context) {
    for (int i = 0; i < 50; ++i) {
        uint8_t packet[64];
        int moved;
        EXPECT(libusb_bulk_transfer(context, 0x81, packet, 64, &moved, MS) == 0 && moved >= 2);
    }
    return NULL;
}

static int threads(void) {
    libusb_device_handle* device = open_claimed();
    EXPECT(latency(device, 2) == 0);
    pthread_t all[4];
    for (int i = 0; i < 4; ++i) pthread_create(&all[i], NULL, i < 2 ? talk : listen_in, device);
    for (int i = 0; i < 4; ++i) pthread_join(all[i], NULL);
    libusb_close(device);
    return 0;
}

/// A child that has inherited the device and closes it must not disturb the parent.
static int forks(void) {
    libusb_device_handle* device = open_claimed();
    EXPECT(latency(device, 3) == 0);
    for (int i = 0; i < 5; ++i) {
        int status = -1;
        const pid_t child = fork();
        if (child == 0) {
            for (int fd = 3; fd < 64; ++fd) close(fd);
            _exit(0);
        }
        EXPECT(waitpid(child, &status, 0) == child && status == 0);
        EXPECT(latency(device, 3) == 0);
    }
    EXPECT(system("exit 0") == 0);
    libusb_close(device);
    return 0;
}

// Plugs.

static int n_came, n_left;

static int LIBUSB_CALL plugged(libusb_context* context, libusb_device* device, libusb_hotplug_event event,
                               void* user) {
    (void)context, (void)device, (void)user;
    if (event == LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED) ++n_came;
    if (event == LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT) ++n_left;
    return 0;
}

static void listen_for_plugs(void) {
    EXPECT(libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG));
    EXPECT(libusb_hotplug_register_callback(
               NULL, LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT,
               LIBUSB_HOTPLUG_ENUMERATE, VENDOR, PRODUCT, LIBUSB_HOTPLUG_MATCH_ANY, plugged, NULL,
               NULL) == 0);
}

static void wait_for(const int* count, int wanted) {
    struct timeval patience = {0, 100000};
    for (int i = 0; i < 100 && *count < wanted; ++i) libusb_handle_events_timeout(NULL, &patience);
    EXPECT(*count >= wanted);
}

/// With an open device and a read on it; then again, and once more without anything open.
static int hotplug(const char* simulator) {
    char command[512];
    snprintf(command, sizeof command, "%s fault 'unplug at_s=0 for_s=0.1' >/dev/null", simulator);
    listen_for_plugs();
    EXPECT(n_came == 1);
    for (int round = 1; round <= 3; ++round) {
        libusb_device_handle* device = round < 3 ? open_claimed() : NULL;
        EXPECT(system(command) == 0);
        int code = 0;
        for (int i = 0; i < 1000 && device && code == 0; ++i) {
            uint8_t packet[64];
            int moved;
            code = libusb_bulk_transfer(device, 0x81, packet, 64, &moved, 5 * MS);
        }
        EXPECT(!device || code == LIBUSB_ERROR_NO_DEVICE);
        EXPECT(!device || latency(device, 1) == LIBUSB_ERROR_NO_DEVICE);
        wait_for(&n_left, round);
        if (device) libusb_close(device);
        wait_for(&n_came, round + 1);
    }
    libusb_device_handle* device = open_claimed();
    EXPECT(latency(device, 1) == 0);
    libusb_close(device);
    return 0;
}

// Until the device leaves.

static int endless_sync(void) {
    libusb_device_handle* device = open_claimed();
    int code = 0;
    while (code == 0) {
        uint8_t packet[64];
        int moved;
        code = latency(device, 1);
        if (code == 0) code = libusb_bulk_transfer(device, 0x02, packet, 16, &moved, 2 * MS);
        if (code == 0) code = libusb_bulk_transfer(device, 0x81, packet, 64, &moved, 2 * MS);
    }
    libusb_release_interface(device, 0);
    libusb_close(device);
    if (code == LIBUSB_ERROR_NO_DEVICE) return LEFT;
    fprintf(stderr, "probe: %s\n", libusb_error_name(code));
    return 1;
}

/// One read without a time limit, which only an unplug can end.
static int endless_wait(void) {
    libusb_device_handle* device = open_claimed();
    int code = latency(device, 255);
    while (code == 0) {
        uint8_t packet[64];
        int moved;
        code = libusb_bulk_transfer(device, 0x81, packet, 64, &moved, 0);
    }
    libusb_close(device);
    return code == LIBUSB_ERROR_NO_DEVICE ? LEFT : 1;
}

static volatile bool threads_end;

static void* pump(void* context) {
    (void)context;
    struct timeval patience = {0, 50000};
    while (!threads_end) libusb_handle_events_timeout(NULL, &patience);
    return NULL;
}

static void* ask(void* context) {
    while (latency(context, 1) == 0) {
    }
    return NULL;
}

/// Events on a thread of their own, two more that ask and this one that reads.
static int endless_threads(void) {
    libusb_device_handle* device = open_claimed();
    pthread_t all[3];
    pthread_create(&all[0], NULL, pump, NULL);
    pthread_create(&all[1], NULL, ask, device);
    pthread_create(&all[2], NULL, ask, device);
    int code = 0;
    while (code == 0) {
        uint8_t packet[64];
        int moved;
        code = libusb_bulk_transfer(device, 0x81, packet, 64, &moved, 0);
    }
    pthread_join(all[1], NULL);
    pthread_join(all[2], NULL);
    threads_end = true;
    pthread_join(all[0], NULL);
    libusb_close(device);
    return code == LIBUSB_ERROR_NO_DEVICE ? LEFT : 1;
}

int main(int argc, char** argv) {
    const char* what = argc > 1 ? argv[1] : "";
    if (strcmp(what, "exit") == 0) return argc > 2 ? (int)strtol(argv[2], NULL, 10) : 0;
    endless = strncmp(what, "endless", 7) == 0;
    if (libusb_init(NULL) != 0) return 1;
    int code = 1;
    if (strcmp(what, "list") == 0) code = list();
    if (strcmp(what, "standard") == 0) code = standard();
    if (strcmp(what, "overflow") == 0) code = overflow();
    if (strcmp(what, "timeout") == 0) code = timeout();
    if (strcmp(what, "cancel") == 0) code = cancel();
    if (strcmp(what, "async") == 0) code = post_reads(200, MS);
    if (strcmp(what, "claims") == 0) code = claims();
    if (strcmp(what, "threads") == 0) code = threads();
    if (strcmp(what, "forks") == 0) code = forks();
    if (strcmp(what, "hotplug") == 0 && argc > 2) code = hotplug(argv[2]);
    if (strcmp(what, "endless-sync") == 0) code = endless_sync();
    if (strcmp(what, "endless-async") == 0) code = post_reads(1L << 60, 0);
    if (strcmp(what, "endless-wait") == 0) code = endless_wait();
    if (strcmp(what, "endless-threads") == 0) code = endless_threads();
    libusb_exit(NULL);
    return code;
}
