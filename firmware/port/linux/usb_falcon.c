#include "firmware/port/linux/usb_falcon.h"

#include <errno.h>
#include <libusb.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
    STEP_TIMEOUT_MS = 1000,  // of one control or bulk OUT transfer
    BAD_READS_MAX = 20,      // in a row: as good as unplugged
    US_PER_S = 1000000,
    NS_PER_S = 1000000000,
    STEPS_MAX = 16  // of one send: a bound; each is one finished transfer
};

static uint64_t clock_ns(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (uint64_t)now.tv_sec * NS_PER_S + (uint64_t)now.tv_nsec;
}

uint64_t pal_usb_now_us(void) {
    return clock_ns(CLOCK_MONOTONIC) / 1000U;
}

// ---- the record

static int32_t errno_of(enum libusb_transfer_status status) {
    switch (status) {
        case LIBUSB_TRANSFER_COMPLETED:
            return 0;
        case LIBUSB_TRANSFER_CANCELLED:
        case LIBUSB_TRANSFER_TIMED_OUT:
            return -ENOENT;
        case LIBUSB_TRANSFER_STALL:
            return -EPIPE;
        case LIBUSB_TRANSFER_NO_DEVICE:
            return -ESHUTDOWN;
        case LIBUSB_TRANSFER_OVERFLOW:
            return -EOVERFLOW;
        default:
            return -EPROTO;
    }
}

static void record(const pal_usb_falcon* port, const struct libusb_transfer* transfer, pal_pcap_event event) {
    if (port->pcap == NULL) return;
    const bool control = transfer->type == LIBUSB_TRANSFER_TYPE_CONTROL;
    const bool in = (transfer->endpoint & LIBUSB_ENDPOINT_IN) != 0;
    const bool submitted = event == PAL_PCAP_SUBMIT;
    const int n_head_bytes = control ? LIBUSB_CONTROL_SETUP_SIZE : 0;
    const pal_pcap_record line = {
        .id = (uint64_t)(uintptr_t)transfer,
        .time_us = clock_ns(CLOCK_REALTIME) / 1000U,
        .event = event,
        .endpoint = transfer->endpoint,
        .bus = port->link.about.bus,
        .address = port->link.about.address,
        .status = submitted ? -EINPROGRESS : errno_of(transfer->status),
        .n_bytes = (uint32_t)(submitted ? transfer->length - n_head_bytes : transfer->actual_length),
        .setup = control && submitted ? transfer->buffer : NULL,
        .data = !control && in != submitted ? transfer->buffer : NULL,
    };
    pal_pcap_write(port->pcap, &line);
}

// ---- transfers

static void lose(pal_usb_falcon* port) {
    if (port->gone) return;
    port->gone = true;
    pal_falcon_transfer_failed(port->falcon, true, pal_usb_now_us());
}

static void fail(pal_usb_falcon* port) {
    if (!port->gone) pal_falcon_transfer_failed(port->falcon, false, pal_usb_now_us());
}

// False: it is not under way, and the driver knows why.
static bool submit(pal_usb_falcon* port, struct libusb_transfer* transfer) {
    const int error = libusb_submit_transfer(transfer);
    if (error == LIBUSB_ERROR_NO_DEVICE) {
        lose(port);
    } else if (error != 0) {
        fail(port);
    } else {
        port->n_under_way += 1U;
        port->n_submitted += 1U;
        record(port, transfer, PAL_PCAP_SUBMIT);
    }
    return error == 0;
}

static void on_bad_read(pal_usb_falcon* port, const struct libusb_transfer* transfer) {
    port->n_bad += 1U;
    if (transfer->status == LIBUSB_TRANSFER_NO_DEVICE || port->n_bad >= BAD_READS_MAX) {
        lose(port);
        return;
    }
    fail(port);
    // A halted endpoint stays so until it is cleared: one control transfer that this thread waits for.
    if (transfer->status == LIBUSB_TRANSFER_STALL) {
        if (libusb_clear_halt(transfer->dev_handle, transfer->endpoint) == LIBUSB_ERROR_NO_DEVICE) lose(port);
    }
}

static void LIBUSB_CALL on_read(struct libusb_transfer* transfer) {
    pal_usb_falcon* port = (pal_usb_falcon*)transfer->user_data;
    port->n_under_way -= 1U;
    record(port, transfer, PAL_PCAP_COMPLETE);
    if (transfer->actual_length > 0) {
        const uint64_t now_ns = clock_ns(CLOCK_MONOTONIC);
        port->n_packets += 1U;
        if (transfer->actual_length > PAL_FTDI_STATUS_BYTES) port->came_ns = now_ns;
        pal_falcon_feed(port->falcon, transfer->buffer, (size_t)transfer->actual_length, now_ns / 1000U);
    }
    if (transfer->status == LIBUSB_TRANSFER_COMPLETED) {
        port->n_bad = 0;
    } else if (transfer->status != LIBUSB_TRANSFER_CANCELLED || !port->closing) {
        on_bad_read(port, transfer);
    }
    if (!port->gone && !port->closing && !submit(port, transfer)) lose(port);
}

static void LIBUSB_CALL on_step(struct libusb_transfer* transfer) {
    pal_usb_falcon* port = (pal_usb_falcon*)transfer->user_data;
    port->n_under_way -= 1U;
    port->busy = false;
    record(port, transfer, PAL_PCAP_COMPLETE);
    const bool control = transfer->type == LIBUSB_TRANSFER_TYPE_CONTROL;
    const bool whole = control || transfer->actual_length == transfer->length;
    if (transfer->status == LIBUSB_TRANSFER_COMPLETED && whole) {
        if (!control) port->done_ns = clock_ns(CLOCK_MONOTONIC);
        return;
    }
    if (transfer->status == LIBUSB_TRANSFER_NO_DEVICE) {
        lose(port);
        return;
    }
    fail(port);
    if (transfer->status == LIBUSB_TRANSFER_STALL && !control) {
        (void)libusb_clear_halt(transfer->dev_handle, transfer->endpoint);
    }
}

static void begin(pal_usb_falcon* port, const pal_usb_step* step) {
    if (step->kind == PAL_USB_CONTROL) {
        libusb_fill_control_setup(port->step_bytes, PAL_FTDI_REQUEST_TYPE, step->request, step->value,
                                  step->index, 0);
        libusb_fill_control_transfer(port->step, port->link.handle, port->step_bytes, on_step, port,
                                     STEP_TIMEOUT_MS);
    } else {
        memcpy(port->step_bytes, step->bytes, step->n_bytes);
        libusb_fill_bulk_transfer(port->step, port->link.handle, PAL_FTDI_ENDPOINT_OUT, port->step_bytes,
                                  (int)step->n_bytes, on_step, port, STEP_TIMEOUT_MS);
    }
    port->busy = submit(port, port->step);
    if (port->busy && step->kind == PAL_USB_WRITE) port->sent_ns = clock_ns(CLOCK_MONOTONIC);
}

// ---- events

static void handle_events(pal_usb_falcon* port) {
    struct timeval at_once = {0, 0};
    if (port->link.context != NULL) {
        (void)libusb_handle_events_timeout_completed(port->link.context, &at_once, NULL);
    }
}

void pal_usb_falcon_collect(pal_usb_falcon* port) {
    handle_events(port);
}

uint32_t pal_usb_falcon_send(pal_usb_falcon* port) {
    for (int i = 0; i < STEPS_MAX && !port->gone && !port->busy; ++i) {
        const pal_usb_step step = pal_falcon_next(port->falcon, pal_usb_now_us());
        if (step.kind == PAL_USB_IDLE) return step.wake_us;
        begin(port, &step);
        if (port->busy) handle_events(port);  // it may have ended already
        if (step.kind == PAL_USB_WRITE && !port->busy)
            return 0;  // one request in a call, so that none is missed
    }
    return port->busy || port->gone ? PAL_USB_WAIT_MAX_US : 0;
}

// libusb's own waits have whole milliseconds; the exchange's times are finer.
static void wait_for_event(const pal_usb_falcon* port, uint32_t most_us) {
    struct pollfd files[PAL_USB_FDS_MAX];
    nfds_t n = 0;
    const struct libusb_pollfd** list = libusb_get_pollfds(port->link.context);
    for (int i = 0; list != NULL && list[i] != NULL && n < PAL_USB_FDS_MAX; ++i) {
        files[n++] = (struct pollfd){.fd = list[i]->fd, .events = list[i]->events};
    }
    libusb_free_pollfds(list);
    const struct timespec wait = {.tv_sec = most_us / US_PER_S,
                                  .tv_nsec = (long)(most_us % US_PER_S) * 1000L};
    (void)ppoll(files, n, &wait, NULL);
}

void pal_usb_falcon_turn(pal_usb_falcon* port, uint32_t most_us) {
    uint32_t wait_us = pal_usb_falcon_send(port);
    if (wait_us > most_us) wait_us = most_us;
    if (wait_us > PAL_USB_WAIT_MAX_US) wait_us = PAL_USB_WAIT_MAX_US;
    if (wait_us > 0 && !port->gone) wait_for_event(port, wait_us);
    pal_usb_falcon_collect(port);
}

// ---- open and close

static bool make_transfers(pal_usb_falcon* port) {
    port->step = libusb_alloc_transfer(0);
    bool all = port->step != NULL;
    for (int i = 0; i < PAL_USB_IN_POSTED; ++i) {
        port->in[i] = libusb_alloc_transfer(0);
        all = all && port->in[i] != NULL;
        if (port->in[i] == NULL) continue;
        libusb_fill_bulk_transfer(port->in[i], port->link.handle, PAL_FTDI_ENDPOINT_IN, port->in_bytes[i],
                                  PAL_FTDI_PACKET_BYTES, on_read, port, 0);
    }
    return all;
}

// Cancels what is under way and waits for its end. What does not end is left to the process' end.
static void take_back(pal_usb_falcon* port) {
    const uint64_t until_us = pal_usb_now_us() + PAL_USB_CLOSE_MAX_US;
    port->closing = true;
    for (int i = 0; i < PAL_USB_IN_POSTED; ++i) {
        if (port->in[i] != NULL) (void)libusb_cancel_transfer(port->in[i]);
    }
    if (port->busy) (void)libusb_cancel_transfer(port->step);
    handle_events(port);
    while (port->n_under_way > 0 && pal_usb_now_us() < until_us) {
        wait_for_event(port, 10000);
        handle_events(port);
    }
    if (port->n_under_way > 0) return;
    for (int i = 0; i < PAL_USB_IN_POSTED; ++i) libusb_free_transfer(port->in[i]);
    libusb_free_transfer(port->step);
}

pal_usb_problem pal_usb_falcon_adopt(pal_usb_falcon* port, pal_falcon* falcon, const pal_usb_link* link,
                                     pal_pcap* pcap, char why[PAL_USB_WORDS_BYTES]) {
    memset(port, 0, sizeof *port);
    port->link = *link;
    port->falcon = falcon;
    port->pcap = pcap;
    bool all = make_transfers(port);
    for (int i = 0; i < PAL_USB_IN_POSTED && all; ++i) all = submit(port, port->in[i]);
    if (all) return PAL_USB_OK;
    const pal_usb_problem problem = port->gone ? PAL_USB_NONE : PAL_USB_FAILED;
    pal_usb_explain(problem, &link->about, why);
    take_back(port);
    pal_usb_link_close(&port->link);
    return problem;
}

pal_usb_problem pal_usb_falcon_open(pal_usb_falcon* port, pal_falcon* falcon, const char* serial,
                                    pal_pcap* pcap, char why[PAL_USB_WORDS_BYTES]) {
    pal_usb_link link;
    memset(port, 0, sizeof *port);
    const pal_usb_problem problem = pal_usb_link_open(&link, serial, why);
    return problem == PAL_USB_OK ? pal_usb_falcon_adopt(port, falcon, &link, pcap, why) : problem;
}

void pal_usb_falcon_abandon(pal_usb_falcon* port, pal_usb_link* link) {
    take_back(port);
    *link = port->link;
    memset(&port->link, 0, sizeof port->link);
}

void pal_usb_falcon_close(pal_usb_falcon* port) {
    if (port->link.context == NULL) return;
    const uint64_t until_us = pal_usb_now_us() + PAL_USB_CLOSE_MAX_US;
    pal_falcon_stop(port->falcon);
    while (!port->gone && !pal_falcon_done(port->falcon) && pal_usb_now_us() < until_us) {
        pal_usb_falcon_turn(port, PAL_USB_WAIT_MAX_US);
    }
    pal_usb_link link;
    pal_usb_falcon_abandon(port, &link);
    pal_usb_link_close(&link);
}
