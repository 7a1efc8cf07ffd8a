#include "sim/usb/usbfs_tree.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "sim/usb/preload_wire.h"

enum { FOLDER_MODE = 0700, FILE_MODE = 0600, LISTEN_BACKLOG = 16, DEPTH_MAX = 16 };

static const char MARK[] = "palpate-falcon-bus";  // a file by which a bus folder is known as one

static bool join(char out[PAL_TREE_PATH_BYTES], const char* folder, const char* rest) {
    const int n = snprintf(out, PAL_TREE_PATH_BYTES, "%s/%s", folder, rest);
    return n > 0 && n < PAL_TREE_PATH_BYTES;
}

static bool write_file(const char* folder, const char* name, const void* bytes, size_t n_bytes) {
    char path[PAL_TREE_PATH_BYTES];
    if (!join(path, folder, name)) return false;
    const int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, FILE_MODE);
    if (fd < 0) return false;
    const bool good = write(fd, bytes, n_bytes) == (ssize_t)n_bytes;
    return close(fd) == 0 && good;
}

static bool write_text(const char* folder, const char* name, const char* text) {
    char line[PAL_BUS_TEXT_BYTES + 2];
    const int n = snprintf(line, sizeof line, "%s\n", text);
    return n > 0 && (size_t)n < sizeof line && write_file(folder, name, line, (size_t)n);
}

static bool write_number(const char* folder, const char* name, const char* format, unsigned number) {
    char text[32];
    switch (format[0]) {
        case 'x':
            (void)snprintf(text, sizeof text, "%04x", number);
            break;
        case 'b':
            (void)snprintf(text, sizeof text, "%02x", number);
            break;
        default:
            (void)snprintf(text, sizeof text, "%u", number);
            break;
    }
    return write_text(folder, name, text);
}

static int remove_one(const char* path, const struct stat* found, int kind, struct FTW* place) {
    (void)found;
    (void)kind;
    (void)place;
    (void)remove(path);
    return 0;
}

static void remove_below(const char* folder, const char* name) {
    char path[PAL_TREE_PATH_BYTES];
    if (join(path, folder, name)) (void)nftw(path, remove_one, DEPTH_MAX, FTW_DEPTH | FTW_PHYS);
}

void pal_tree_clear(const char* folder) {
    static const char* const ours[] = {"sys", "dev", "new", "events", "control", MARK};
    char path[PAL_TREE_PATH_BYTES];
    if (!join(path, folder, MARK) || access(path, F_OK) != 0)
        return;  // not a bus folder: nothing of it is ours
    for (size_t i = 0; i < sizeof ours / sizeof ours[0]; ++i) remove_below(folder, ours[i]);
    (void)rmdir(folder);
}

/// A listening or connected socket at `path`; -1 with errno.
static int open_socket(const char* path, bool listens) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const size_t n = strlen(path);
    if (n >= sizeof address.sun_path) {
        errno = ENAMETOOLONG;
        return -1;
    }
    memcpy(address.sun_path, path, n + 1);
    const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0) return -1;
    const struct sockaddr* where = (const struct sockaddr*)&address;
    const bool good = listens ? fchmod(fd, FILE_MODE) == 0 && bind(fd, where, sizeof address) == 0 &&
                                    listen(fd, LISTEN_BACKLOG) == 0
                              : connect(fd, where, sizeof address) == 0;
    if (good) return fd;
    const int reason = errno;
    (void)close(fd);
    errno = reason;
    return -1;
}

int pal_tree_listen(const char* path) {
    (void)unlink(path);
    return open_socket(path, true);
}

/// Whether somebody listens there, even if too busy to say so.
static bool is_alive(const char* folder, const char* name) {
    char path[PAL_TREE_PATH_BYTES];
    if (!join(path, folder, name)) return false;
    const int fd = open_socket(path, false);
    if (fd < 0) return errno == EAGAIN;
    (void)close(fd);
    return true;
}

bool pal_tree_is_served(const char* folder) {
    return is_alive(folder, "events");
}

/// A folder that others can write to may lead anywhere by the time it is written to.
static bool is_private(const char* folder) {
    struct stat found;
    return lstat(folder, &found) == 0 && S_ISDIR(found.st_mode) && found.st_uid == geteuid() &&
           (found.st_mode & S_IWOTH) == 0;
}

/// False when something is in the folder that is not a bus.
static bool may_use(const char* folder) {
    char path[PAL_TREE_PATH_BYTES];
    if (join(path, folder, MARK) && access(path, F_OK) == 0) return true;
    DIR* open_folder = opendir(folder);
    if (!open_folder) return false;
    bool empty = true;
    for (const struct dirent* at = readdir(open_folder); at; at = readdir(open_folder)) {
        empty = empty && (strcmp(at->d_name, ".") == 0 || strcmp(at->d_name, "..") == 0);
    }
    (void)closedir(open_folder);
    return empty;
}

static bool refuse(char* why, size_t n_why, const char* folder, const char* what) {
    (void)snprintf(why, n_why, "%s: %s", folder, what);
    return false;
}

bool pal_tree_make(const char* folder, char* why, size_t n_why) {
    static const char* const parts[] = {"sys", "sys/bus", "sys/bus/usb", "sys/bus/usb/devices",
                                        "dev", "dev/bus", "dev/bus/usb", "dev/bus/usb/001"};
    if (strlen(folder) > PAL_TREE_FOLDER_MAX) {
        return refuse(why, n_why, folder,
                      "too long; name a bus folder of at most 80 bytes, e.g. /tmp/falcon");
    }
    if (mkdir(folder, FOLDER_MODE) != 0 && errno != EEXIST) {
        (void)snprintf(why, n_why, "%s: %s; name a bus folder that can be made", folder, strerror(errno));
        return false;
    }
    if (!is_private(folder)) {
        return refuse(why, n_why, folder,
                      "must be a folder of yours that others cannot write to; name a new one");
    }
    if (!may_use(folder)) return refuse(why, n_why, folder, "is there and is no bus folder; name a new one");
    if (pal_tree_is_served(folder) || is_alive(folder, "control")) {  // of usbip there is only this one
        return refuse(why, n_why, folder,
                      "another simulator serves it; end that (palpate-falcon-sim quit) or name a new one");
    }
    pal_tree_clear(folder);
    (void)mkdir(folder, FOLDER_MODE);
    bool good = write_text(folder, MARK, "made by palpate-falcon-sim");
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; ++i) {
        char path[PAL_TREE_PATH_BYTES];
        good = good && join(path, folder, parts[i]) && mkdir(path, FOLDER_MODE) == 0;
    }
    if (good) return true;
    (void)snprintf(why, n_why, "%s: %s; name a bus folder that can be written", folder, strerror(errno));
    return false;
}

void pal_tree_node(const char* folder, const pal_bus_port* device, char out[PAL_TREE_PATH_BYTES]) {
    (void)snprintf(out, PAL_TREE_PATH_BYTES, "%s" PAL_BUS_DEV "/001/%03u", folder, (unsigned)device->number);
}

static bool write_descriptors(const char* folder, const pal_bus_port* d) {
    uint8_t bytes[sizeof d->device_descriptor + PAL_BUS_DESCRIPTOR_BYTES];
    memcpy(bytes, d->device_descriptor, sizeof d->device_descriptor);
    memcpy(bytes + sizeof d->device_descriptor, d->configuration, d->n_configuration);
    return write_file(folder, "descriptors", bytes, sizeof d->device_descriptor + d->n_configuration);
}

static bool write_attributes(const char* folder, const pal_bus_port* d, uint32_t port) {
    const uint8_t* b = d->device_descriptor;
    char text[128];
    (void)snprintf(text, sizeof text, "DEVTYPE=usb_device\nBUSNUM=001\nDEVNUM=%03u\nDEVNAME=bus/usb/001/%03u",
                   (unsigned)d->number, (unsigned)d->number);
    return write_text(folder, "uevent", text) && write_number(folder, "busnum", "u", 1) &&
           write_number(folder, "devnum", "u", d->number) && write_number(folder, "devpath", "u", port + 1) &&
           write_text(folder, "speed", "12") && write_text(folder, "version", " 2.00") &&
           write_number(folder, "maxchild", "u", 0) &&
           write_number(folder, "bConfigurationValue", "u", d->configuration[5]) &&
           write_number(folder, "bmAttributes", "b", d->configuration[7]) &&
           write_text(folder, "configuration", "") && write_text(folder, "rx_lanes", "1") &&
           write_text(folder, "tx_lanes", "1") &&
           write_number(folder, "bNumInterfaces", "u", d->configuration[4]) &&
           write_number(folder, "bNumConfigurations", "u", b[17]) &&
           write_number(folder, "bDeviceClass", "b", b[4]) &&
           write_number(folder, "bDeviceSubClass", "b", b[5]) &&
           write_number(folder, "bDeviceProtocol", "b", b[6]) &&
           write_number(folder, "bMaxPacketSize0", "u", b[7]) &&
           write_number(folder, "idVendor", "x", b[8] | (unsigned)b[9] << 8) &&
           write_number(folder, "idProduct", "x", b[10] | (unsigned)b[11] << 8) &&
           write_number(folder, "bcdDevice", "x", b[12] | (unsigned)b[13] << 8) &&
           (d->manufacturer[0] == '\0' || write_text(folder, "manufacturer", d->manufacturer)) &&
           (d->product[0] == '\0' || write_text(folder, "product", d->product)) &&
           (d->serial[0] == '\0' || write_text(folder, "serial", d->serial));
}

static bool sys_path(char out[PAL_TREE_PATH_BYTES], const char* folder, uint32_t port) {
    const int n = snprintf(out, PAL_TREE_PATH_BYTES, "%s" PAL_BUS_SYS "/1-%u", folder, (unsigned)port + 1);
    return n > 0 && n < PAL_TREE_PATH_BYTES;
}

bool pal_tree_add(const char* folder, const pal_bus_port* device, uint32_t port) {
    char fresh[PAL_TREE_PATH_BYTES];
    char shown[PAL_TREE_PATH_BYTES];
    remove_below(folder, "new");
    if (!join(fresh, folder, "new") || !sys_path(shown, folder, port)) return false;
    // Nobody must see half of it.
    return mkdir(fresh, FOLDER_MODE) == 0 && write_attributes(fresh, device, port) &&
           write_descriptors(fresh, device) && rename(fresh, shown) == 0;
}

void pal_tree_remove(const char* folder, const pal_bus_port* device, uint32_t port) {
    char shown[PAL_TREE_PATH_BYTES];
    char gone[PAL_TREE_PATH_BYTES];
    remove_below(folder, "new");
    if (sys_path(shown, folder, port) && join(gone, folder, "new") && rename(shown, gone) == 0) {
        remove_below(folder, "new");
    }
    pal_tree_node(folder, device, gone);
    (void)unlink(gone);
}
