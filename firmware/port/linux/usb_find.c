#include "firmware/port/linux/usb_find.h"

#include <ctype.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { PATH_BYTES = 320 };

static bool has_open(const char* pid, const char* node) {
    char folder[PATH_BYTES];
    (void)snprintf(folder, sizeof folder, "/proc/%.16s/fd", pid);
    DIR* files = opendir(folder);
    if (files == NULL) return false;
    bool found = false;
    for (struct dirent* file = readdir(files); file != NULL && !found; file = readdir(files)) {
        char link[PATH_BYTES];
        char target[PATH_BYTES];
        (void)snprintf(link, sizeof link, "/proc/%.16s/fd/%.16s", pid, file->d_name);
        const ssize_t n = readlink(link, target, sizeof target - 1);
        if (n <= 0) continue;
        target[n] = '\0';
        found = strcmp(target, node) == 0;
    }
    closedir(files);
    return found;
}

static void name_process(const char* pid, char user[PAL_USB_TEXT_BYTES]) {
    char path[PATH_BYTES];
    char name[PAL_USB_TEXT_BYTES / 2] = "a program";
    (void)snprintf(path, sizeof path, "/proc/%.16s/comm", pid);
    FILE* file = fopen(path, "re");
    if (file != NULL) {
        if (fgets(name, sizeof name, file) != NULL) name[strcspn(name, "\n")] = '\0';
        (void)fclose(file);
    }
    (void)snprintf(user, PAL_USB_TEXT_BYTES, "%s (process %.16s)", name, pid);
}

void pal_usb_who(const char* node, char user[PAL_USB_TEXT_BYTES]) {
    user[0] = '\0';
    DIR* processes = opendir("/proc");
    if (processes == NULL) return;
    const long self = (long)getpid();
    for (struct dirent* one = readdir(processes); one != NULL; one = readdir(processes)) {
        if (!isdigit((unsigned char)one->d_name[0]) || strtol(one->d_name, NULL, 10) == self) continue;
        if (!has_open(one->d_name, node)) continue;
        name_process(one->d_name, user);
        break;
    }
    closedir(processes);
}

void pal_usb_explain(pal_usb_problem problem, const pal_usb_found* about, char why[PAL_USB_WORDS_BYTES]) {
    char which[PAL_USB_TEXT_BYTES + 24] = "";
    if (about->serial[0] != '\0')
        (void)snprintf(which, sizeof which, " with serial number %s", about->serial);
    switch (problem) {
        case PAL_USB_OK:
            why[0] = '\0';
            return;
        case PAL_USB_NONE:
            (void)snprintf(why, PAL_USB_WORDS_BYTES,
                           "No Falcon%s is on the USB. Plug in its USB cable and its power supply; "
                           "palpate-falcon list shows what is there.",
                           which);
            return;
        case PAL_USB_DENIED:
            (void)snprintf(
                why, PAL_USB_WORDS_BYTES,
                "The Falcon%s is at %s, but this user may not open it: the udev rule %s is missing "
                "or not yet loaded. palpate doctor --install-udev installs it; then unplug the Falcon "
                "and plug it in again.",
                which, about->node, PAL_USB_RULE_FILE);
            return;
        case PAL_USB_BUSY: {
            char user[PAL_USB_TEXT_BYTES];
            pal_usb_who(about->node, user);
            (void)snprintf(why, PAL_USB_WORDS_BYTES,
                           "The Falcon%s is in use by %s. End that program and start again.", which,
                           user[0] != '\0' ? user : "another program");
            return;
        }
        case PAL_USB_FAILED:
            break;
    }
    (void)snprintf(why, PAL_USB_WORDS_BYTES,
                   "The Falcon%s cannot be opened. Unplug its USB cable, plug it in again and start again.",
                   which);
}
