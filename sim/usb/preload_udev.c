// The part of libudev that libusb-1.0 and lsusb call, answered from the bus folder. Other subsystems are
// empty. Device objects are ours: every function of libudev that takes one and is in use out there must be
// here.
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "sim/usb/preload.h"

enum { DEVICES_MAX = 32, NAME_MAX_BYTES = 16 };

struct udev {
    int references;
};
struct udev_list_entry {
    struct udev_list_entry* next;
    char name[PAL_PRELOAD_PATH_MAX];
};
struct udev_enumerate {
    int references;
    struct udev* udev;
    bool other;  ///< asked for a subsystem that is not usb
    int n;
    struct udev_list_entry entries[DEVICES_MAX];
};
struct udev_device {
    int references;
    struct udev* udev;
    const char* action;
    char syspath[PAL_PRELOAD_PATH_MAX];
    char sysname[NAME_MAX_BYTES];
    char devnode[PAL_PRELOAD_PATH_MAX];
    char value[256];  ///< of the attribute asked for last
};
struct udev_monitor {
    int references;
    struct udev* udev;
    int fd;
    int n_present;
    pal_wire_event present[DEVICES_MAX];
};

static bool bus_path(const char* rest, char room[PAL_PRELOAD_PATH_MAX]) {
    const char* bus = pal_preload_bus();
    const int n = bus ? snprintf(room, PAL_PRELOAD_PATH_MAX, "%s%s", bus, rest) : -1;
    return n > 0 && n < PAL_PRELOAD_PATH_MAX;
}

static int connect_events(void) {
    char path[PAL_PRELOAD_PATH_MAX];
    return bus_path("/events", path) ? pal_preload_connect(path) : -1;
}

// Contexts.

PAL_PRELOAD_EXPORT struct udev* udev_new(void);
PAL_PRELOAD_EXPORT struct udev* udev_ref(struct udev* udev);
PAL_PRELOAD_EXPORT struct udev* udev_unref(struct udev* udev);
struct udev* udev_new(void) {
    struct udev* udev = calloc(1, sizeof *udev);
    if (udev) udev->references = 1;
    return udev;
}
struct udev* udev_ref(struct udev* udev) {
    if (udev) (void)__atomic_add_fetch(&udev->references, 1, __ATOMIC_ACQ_REL);
    return udev;
}
struct udev* udev_unref(struct udev* udev) {
    if (udev && __atomic_sub_fetch(&udev->references, 1, __ATOMIC_ACQ_REL) == 0) free(udev);
    return NULL;
}

// Lists.

PAL_PRELOAD_EXPORT struct udev_list_entry* udev_list_entry_get_next(struct udev_list_entry* entry);
PAL_PRELOAD_EXPORT const char* udev_list_entry_get_name(struct udev_list_entry* entry);
PAL_PRELOAD_EXPORT const char* udev_list_entry_get_value(struct udev_list_entry* entry);
struct udev_list_entry* udev_list_entry_get_next(struct udev_list_entry* entry) {
    return entry ? entry->next : NULL;
}
const char* udev_list_entry_get_name(struct udev_list_entry* entry) {
    return entry ? entry->name : NULL;
}
const char* udev_list_entry_get_value(struct udev_list_entry* entry) {
    (void)entry;
    return NULL;
}

PAL_PRELOAD_EXPORT struct udev_enumerate* udev_enumerate_new(struct udev* udev);
PAL_PRELOAD_EXPORT struct udev_enumerate* udev_enumerate_unref(struct udev_enumerate* list);
PAL_PRELOAD_EXPORT int udev_enumerate_add_match_subsystem(struct udev_enumerate* list, const char* subsystem);
PAL_PRELOAD_EXPORT int udev_enumerate_add_match_property(struct udev_enumerate* list, const char* name,
                                                         const char* value);
PAL_PRELOAD_EXPORT int udev_enumerate_add_match_sysattr(struct udev_enumerate* list, const char* name,
                                                        const char* value);
PAL_PRELOAD_EXPORT int udev_enumerate_scan_devices(struct udev_enumerate* list);
PAL_PRELOAD_EXPORT struct udev_list_entry* udev_enumerate_get_list_entry(struct udev_enumerate* list);
struct udev_enumerate* udev_enumerate_new(struct udev* udev) {
    struct udev_enumerate* list = calloc(1, sizeof *list);
    if (list) *list = (struct udev_enumerate){.references = 1, .udev = udev};
    return list;
}
struct udev_enumerate* udev_enumerate_unref(struct udev_enumerate* list) {
    if (list && __atomic_sub_fetch(&list->references, 1, __ATOMIC_ACQ_REL) == 0) free(list);
    return NULL;
}
int udev_enumerate_add_match_subsystem(struct udev_enumerate* list, const char* subsystem) {
    if (strcmp(subsystem, "usb") != 0) list->other = true;
    return 0;
}
int udev_enumerate_add_match_property(struct udev_enumerate* list, const char* name, const char* value) {
    if (strcmp(name, "DEVTYPE") == 0 && strcmp(value, "usb_device") != 0) list->other = true;
    return 0;
}
int udev_enumerate_add_match_sysattr(struct udev_enumerate* list, const char* name, const char* value) {
    (void)list;
    (void)name;
    (void)value;
    return 0;
}

/// A bus whose simulator has ended keeps its folder but no devices.
static bool bus_lives(void) {
    const int fd = connect_events();
    if (fd >= 0) (void)close(fd);
    return fd >= 0;
}

int udev_enumerate_scan_devices(struct udev_enumerate* list) {
    list->n = 0;
    if (list->other || !bus_lives()) return 0;
    DIR* folder = opendir(PAL_BUS_SYS);
    if (!folder) return 0;
    for (const struct dirent* at = readdir(folder); at && list->n < DEVICES_MAX; at = readdir(folder)) {
        if (at->d_name[0] == '.') continue;
        struct udev_list_entry* entry = &list->entries[list->n];
        const int n = snprintf(entry->name, sizeof entry->name, PAL_BUS_SYS "/%s", at->d_name);
        if (n < 0 || (size_t)n >= sizeof entry->name) continue;
        entry->next = NULL;
        if (list->n > 0) list->entries[list->n - 1].next = entry;
        ++list->n;
    }
    (void)closedir(folder);
    return 0;
}
struct udev_list_entry* udev_enumerate_get_list_entry(struct udev_enumerate* list) {
    return list->n > 0 ? &list->entries[0] : NULL;
}

// The hardware database: there, and empty. Its entries would be of the other library's kind.

struct udev_hwdb {
    int references;
};
PAL_PRELOAD_EXPORT struct udev_hwdb* udev_hwdb_new(struct udev* udev);
PAL_PRELOAD_EXPORT struct udev_hwdb* udev_hwdb_unref(struct udev_hwdb* hwdb);
PAL_PRELOAD_EXPORT struct udev_list_entry* udev_hwdb_get_properties_list_entry(struct udev_hwdb* hwdb,
                                                                               const char* modalias,
                                                                               unsigned flags);
struct udev_hwdb* udev_hwdb_new(struct udev* udev) {
    (void)udev;
    return calloc(1, sizeof(struct udev_hwdb));
}
struct udev_hwdb* udev_hwdb_unref(struct udev_hwdb* hwdb) {
    free(hwdb);
    return NULL;
}
struct udev_list_entry* udev_hwdb_get_properties_list_entry(struct udev_hwdb* hwdb, const char* modalias,
                                                            unsigned flags) {
    (void)hwdb;
    (void)modalias;
    (void)flags;
    return NULL;
}

// Devices.

/// First line of an attribute; NULL when there is none.
static const char* attribute(const char* syspath, const char* name, char* out, size_t n_out) {
    char path[2 * PAL_PRELOAD_PATH_MAX];
    const int n = snprintf(path, sizeof path, "%s/%s", syspath, name);
    if (n < 0 || (size_t)n >= sizeof path) return NULL;
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) return NULL;
    const ssize_t got = read(fd, out, n_out - 1);
    (void)close(fd);
    if (got < 0) return NULL;
    out[got] = '\0';
    out[strcspn(out, "\n")] = '\0';
    return out;
}

static struct udev_device* make_device(struct udev* udev, const char* sysname, int bus, int number) {
    struct udev_device* device = calloc(1, sizeof *device);
    if (!device) return NULL;
    device->references = 1;
    device->udev = udev;
    (void)snprintf(device->sysname, sizeof device->sysname, "%s", sysname);
    (void)snprintf(device->syspath, sizeof device->syspath, PAL_BUS_SYS "/%s", sysname);
    (void)snprintf(device->devnode, sizeof device->devnode, PAL_BUS_DEV "/%03d/%03d", bus, number);
    return device;
}

PAL_PRELOAD_EXPORT struct udev_device* udev_device_new_from_syspath(struct udev* udev, const char* syspath);
PAL_PRELOAD_EXPORT struct udev_device* udev_device_ref(struct udev_device* device);
PAL_PRELOAD_EXPORT struct udev_device* udev_device_unref(struct udev_device* device);
struct udev_device* udev_device_new_from_syspath(struct udev* udev, const char* syspath) {
    char text[16];
    const char* slash = strrchr(syspath, '/');
    if (!slash || strlen(slash + 1) >= NAME_MAX_BYTES || !attribute(syspath, "busnum", text, sizeof text)) {
        errno = ENODEV;
        return NULL;
    }
    const int bus = (int)strtol(text, NULL, 10);
    if (!attribute(syspath, "devnum", text, sizeof text)) return NULL;
    return make_device(udev, slash + 1, bus, (int)strtol(text, NULL, 10));
}
struct udev_device* udev_device_ref(struct udev_device* device) {
    if (device) (void)__atomic_add_fetch(&device->references, 1, __ATOMIC_ACQ_REL);
    return device;
}
struct udev_device* udev_device_unref(struct udev_device* device) {
    if (device && __atomic_sub_fetch(&device->references, 1, __ATOMIC_ACQ_REL) == 0) free(device);
    return NULL;
}

PAL_PRELOAD_EXPORT const char* udev_device_get_action(struct udev_device* device);
PAL_PRELOAD_EXPORT const char* udev_device_get_devnode(struct udev_device* device);
PAL_PRELOAD_EXPORT const char* udev_device_get_sysname(struct udev_device* device);
PAL_PRELOAD_EXPORT const char* udev_device_get_syspath(struct udev_device* device);
PAL_PRELOAD_EXPORT const char* udev_device_get_subsystem(struct udev_device* device);
PAL_PRELOAD_EXPORT const char* udev_device_get_devtype(struct udev_device* device);
PAL_PRELOAD_EXPORT const char* udev_device_get_sysattr_value(struct udev_device* device, const char* name);
PAL_PRELOAD_EXPORT const char* udev_device_get_property_value(struct udev_device* device, const char* name);
PAL_PRELOAD_EXPORT struct udev_device* udev_device_get_parent(struct udev_device* device);
PAL_PRELOAD_EXPORT struct udev_device* udev_device_get_parent_with_subsystem_devtype(
    struct udev_device* device, const char* subsystem, const char* devtype);
PAL_PRELOAD_EXPORT struct udev* udev_device_get_udev(struct udev_device* device);
const char* udev_device_get_action(struct udev_device* device) {
    return device->action;
}
const char* udev_device_get_devnode(struct udev_device* device) {
    return device->devnode;
}
const char* udev_device_get_sysname(struct udev_device* device) {
    return device->sysname;
}
const char* udev_device_get_syspath(struct udev_device* device) {
    return device->syspath;
}
const char* udev_device_get_subsystem(struct udev_device* device) {
    (void)device;
    return "usb";
}
const char* udev_device_get_devtype(struct udev_device* device) {
    (void)device;
    return "usb_device";
}
const char* udev_device_get_sysattr_value(struct udev_device* device, const char* name) {
    return attribute(device->syspath, name, device->value, sizeof device->value);
}
const char* udev_device_get_property_value(struct udev_device* device, const char* name) {
    (void)device;
    (void)name;
    return NULL;
}
struct udev_device* udev_device_get_parent(struct udev_device* device) {
    (void)device;
    return NULL;
}
struct udev_device* udev_device_get_parent_with_subsystem_devtype(struct udev_device* device,
                                                                  const char* subsystem,
                                                                  const char* devtype) {
    (void)device;
    (void)subsystem;
    (void)devtype;
    return NULL;
}
struct udev* udev_device_get_udev(struct udev_device* device) {
    return device->udev;
}

// Hot-plug.

PAL_PRELOAD_EXPORT struct udev_monitor* udev_monitor_new_from_netlink(struct udev* udev, const char* name);
PAL_PRELOAD_EXPORT struct udev_monitor* udev_monitor_unref(struct udev_monitor* monitor);
PAL_PRELOAD_EXPORT int udev_monitor_filter_add_match_subsystem_devtype(struct udev_monitor* monitor,
                                                                       const char* subsystem,
                                                                       const char* devtype);
PAL_PRELOAD_EXPORT int udev_monitor_enable_receiving(struct udev_monitor* monitor);
PAL_PRELOAD_EXPORT int udev_monitor_get_fd(struct udev_monitor* monitor);
PAL_PRELOAD_EXPORT struct udev_device* udev_monitor_receive_device(struct udev_monitor* monitor);

/// A descriptor that never becomes readable.
static int silent_fd(void) {
    return eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);  // nobody adds to it
}

struct udev_monitor* udev_monitor_new_from_netlink(struct udev* udev, const char* name) {
    (void)name;
    struct udev_monitor* monitor = calloc(1, sizeof *monitor);
    if (!monitor) return NULL;
    *monitor = (struct udev_monitor){.references = 1, .udev = udev, .fd = connect_events()};
    if (monitor->fd < 0) monitor->fd = silent_fd();  // no simulator: nothing will ever happen
    if (monitor->fd >= 0) return monitor;
    free(monitor);
    return NULL;
}
struct udev_monitor* udev_monitor_unref(struct udev_monitor* monitor) {
    if (!monitor || __atomic_sub_fetch(&monitor->references, 1, __ATOMIC_ACQ_REL) != 0) return NULL;
    (void)close(monitor->fd);
    free(monitor);
    return NULL;
}
int udev_monitor_filter_add_match_subsystem_devtype(struct udev_monitor* monitor, const char* subsystem,
                                                    const char* devtype) {
    (void)monitor;
    (void)subsystem;
    (void)devtype;
    return 0;
}
int udev_monitor_enable_receiving(struct udev_monitor* monitor) {
    (void)monitor;
    return 0;
}
int udev_monitor_get_fd(struct udev_monitor* monitor) {
    return monitor->fd;
}

static struct udev_device* told(struct udev_monitor* monitor, const pal_wire_event* event,
                                const char* action) {
    char sysname[NAME_MAX_BYTES];
    (void)snprintf(sysname, sizeof sysname, "1-%u", (unsigned)event->port);
    struct udev_device* device = make_device(monitor->udev, sysname, 1, (int)event->number);
    if (device) device->action = action;
    return device;
}

static void forget_device(struct udev_monitor* monitor, uint32_t port) {
    for (int i = 0; i < monitor->n_present; ++i) {
        if (monitor->present[i].port != port) continue;
        monitor->present[i] = monitor->present[--monitor->n_present];
        return;
    }
}

/// The simulator has ended: its devices leave one by one, then this is silent for ever.
static struct udev_device* lost(struct udev_monitor* monitor) {
    if (monitor->n_present > 0) return told(monitor, &monitor->present[--monitor->n_present], "remove");
    const int silent = silent_fd();
    if (silent >= 0) {
        (void)dup3(silent, monitor->fd, O_CLOEXEC);
        (void)close(silent);
    }
    return NULL;
}

struct udev_device* udev_monitor_receive_device(struct udev_monitor* monitor) {
    pal_wire_event event;
    const ssize_t n = recv(monitor->fd, &event, sizeof event, MSG_DONTWAIT);
    if (n == 0 || (n < 0 && errno == ECONNRESET)) return lost(monitor);
    if (n != (ssize_t)sizeof event) return NULL;
    forget_device(monitor, event.port);
    if (event.kind == PAL_WIRE_REMOVE) return told(monitor, &event, "remove");
    if (monitor->n_present < DEVICES_MAX) monitor->present[monitor->n_present++] = event;
    return event.kind == PAL_WIRE_ADD ? told(monitor, &event, "add") : NULL;
}
