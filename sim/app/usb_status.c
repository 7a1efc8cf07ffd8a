#include "sim/app/usb_status.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ALL_HOMED = 7 };

__attribute__((format(printf, 3, 4))) static void add(char* out, size_t* n, const char* format, ...) {
    va_list values;
    va_start(values, format);
    const int more = vsnprintf(out + *n, PAL_STATUS_BYTES - *n, format, values);
    va_end(values);
    if (more > 0) *n += (size_t)more < PAL_STATUS_BYTES - *n ? (size_t)more : PAL_STATUS_BYTES - *n - 1;
}

static const char* json_bool(bool value) {
    return value ? "true" : "false";
}

/// Text in JSON's quotes.
static void add_text(char* out, size_t* n, const char* text) {
    add(out, n, "\"");
    for (; *text != '\0'; ++text) add(out, n, *text == '"' || *text == '\\' ? "\\%c" : "%c", *text);
    add(out, n, "\"");
}

static void add_device(const pal_status_source* source, uint32_t port, char* out, size_t* n) {
    const pal_bus_port* p = &source->bus->ports[port];
    const pal_usb_device_truth t = pal_usb_device_read(&p->device);
    add(out, n, "%s{\"serial\":", port == 0 ? "" : ",");
    add_text(out, n, p->serial);
    add(out, n, ",\"present\":%s,\"powered\":%s,\"open\":%u,\"running\":%s,\"boots\":%u,",
        json_bool(p->present), json_bool(t.powered), (unsigned)source->n_open(source->context, port),
        json_bool(t.running), (unsigned)t.n_boots);
    add(out, n, "\"requests\":%u,\"replies\":%u,\"motor_counts\":[%d,%d,%d],\"encoder_counts\":[%d,%d,%d],",
        (unsigned)t.n_requests, (unsigned)t.n_replies, t.motor_counts[0], t.motor_counts[1],
        t.motor_counts[2], t.encoder_counts[0], t.encoder_counts[1], t.encoder_counts[2]);
    add(out, n, "\"force_n\":[%.9g,%.9g,%.9g],\"position_m\":[%.9g,%.9g,%.9g],", t.force_n[0], t.force_n[1],
        t.force_n[2], t.position_m[0], t.position_m[1], t.position_m[2]);
    add(out, n,
        "\"homed\":%s,\"homing\":%s,\"leds\":%u,\"buttons\":%u,\"watchdog\":%s,\"faults_struck\":%u,"
        "\"baud\":%u,\"latency_ms\":%u}",
        json_bool(t.homed == ALL_HOMED), json_bool(t.homing), t.leds, t.buttons, json_bool(t.watchdog),
        (unsigned)t.n_strikes, (unsigned)t.baud, t.latency_ms);
}

static void status(const pal_status_source* source, char* out) {
    size_t n = 0;
    add(out, &n, "{\"t_us\":%llu,\"lost_us\":%llu,\"devices\":[", (unsigned long long)source->bus->now_us,
        (unsigned long long)source->bus->lost_us);
    for (uint32_t port = 0; port < source->bus->n_ports; ++port) add_device(source, port, out, &n);
    add(out, &n, "]}\n");
}

static void fail(char* out, const char* what) {
    // The words may hold a piece of the question: no quotes of JSON in them.
    size_t n = 0;
    add(out, &n, "{\"error\":\"");
    for (; *what != '\0' && n + 8 < PAL_STATUS_BYTES; ++what) {
        const bool plain = *what >= ' ' && *what <= '~' && *what != '"' && *what != '\\';
        out[n++] = plain ? *what : '\'';
    }
    out[n] = '\0';
    add(out, &n, "\"}\n");
}

/// "N rest": only device N, else all. What follows; NULL when there is no such device.
static const char* choose(const pal_status_source* source, const char* text, uint32_t* first,
                          uint32_t* last) {
    *first = 0;
    *last = source->bus->n_ports;
    if (*text < '0' || *text > '9') return text;
    char* end;
    const unsigned long device = strtoul(text, &end, 10);
    if (device < 1 || device > source->bus->n_ports) return NULL;
    *first = (uint32_t)device - 1;
    *last = *first + 1;
    while (*end == ' ') ++end;
    return end;
}

/// Times of a fault that comes while all runs count from now.
static void inject(const pal_status_source* source, const char* text, char* out) {
    uint32_t first;
    uint32_t last;
    pal_usb_fault fault;
    pal_usb_fault_error error = {0};
    text = choose(source, text, &first, &last);
    if (!text) {
        fail(out, "no such device; they are numbered from 1");
        return;
    }
    const int n = pal_usb_faults_parse(text, strlen(text), &fault, 1, &error);
    if (n != 1) {
        fail(out, n < 0 ? error.message : "no fault; write one such as unplug at_s=0 for_s=0.5");
        return;
    }
    for (uint32_t port = first; port < last; ++port) {
        pal_usb_device* device = &source->bus->ports[port].device;
        if (!pal_usb_device_inject_now(device, &fault)) {
            fail(out, "no room for one more fault; heal ends all that there are");
            return;
        }
    }
    (void)snprintf(out, PAL_STATUS_BYTES, "{\"fault\":\"%s\"}\n", pal_usb_fault_name(fault.kind));
}

static void heal(const pal_status_source* source, char* out) {
    for (uint32_t port = 0; port < source->bus->n_ports; ++port) {
        pal_usb_device_heal(&source->bus->ports[port].device);
    }
    (void)snprintf(out, PAL_STATUS_BYTES, "{\"healed\":true}\n");
}

static void press(const pal_status_source* source, const char* text, char* out) {
    char* end;
    const unsigned long buttons = strtoul(text, &end, 0);
    if (end == text || *end != '\0' || buttons > 15) {
        fail(out, "buttons are 0..15: 1 right, 2 front, 4 middle, 8 left, added up");
        return;
    }
    for (uint32_t port = 0; port < source->bus->n_ports; ++port) {
        pal_usb_device_press(&source->bus->ports[port].device, (uint8_t)buttons);
    }
    (void)snprintf(out, PAL_STATUS_BYTES, "{\"buttons\":%lu}\n", buttons);
}

void pal_status_answer(const pal_status_source* source, const char* question, char out[PAL_STATUS_BYTES]) {
    if (strcmp(question, "status") == 0) {
        status(source, out);
    } else if (strncmp(question, "fault ", 6) == 0) {
        inject(source, question + 6, out);
    } else if (strcmp(question, "heal") == 0) {
        heal(source, out);
    } else if (strncmp(question, "press ", 6) == 0) {
        press(source, question + 6, out);
    } else {
        fail(out, "unknown word; there are status, fault, heal, press and quit");
    }
}
