#include "sim/usb/host_controller.h"

#include <string.h>

enum { OUT_RETRY_US = 125, ENDPOINT_IN = 0x81, ENDPOINT_OUT = 0x02, REQUEST_IN = 0x80 };

static void append(pal_host_queue* queue, pal_urb* urb) {
    urb->next = NULL;
    if (queue->last) {
        queue->last->next = urb;
    } else {
        queue->first = urb;
    }
    queue->last = urb;
}

static pal_urb* take_first(pal_host_queue* queue) {
    pal_urb* urb = queue->first;
    if (!urb) return NULL;
    queue->first = urb->next;
    if (!queue->first) queue->last = NULL;
    urb->next = NULL;
    return urb;
}

static bool take(pal_host_queue* queue, pal_urb* urb) {
    pal_urb* before = NULL;
    for (pal_urb* at = queue->first; at; before = at, at = at->next) {
        if (at != urb) continue;
        if (before) {
            before->next = urb->next;
        } else {
            queue->first = urb->next;
        }
        if (queue->last == urb) queue->last = before;
        urb->next = NULL;
        return true;
    }
    return false;
}

static pal_host_queue* queue_of(pal_host* host, uint8_t endpoint) {
    if (endpoint == 0) return &host->control;
    if (endpoint == ENDPOINT_IN) return &host->in;
    return endpoint == ENDPOINT_OUT ? &host->out : NULL;
}

static void tell_watcher(const pal_host* host, pal_urb* urb) {
    if (host->watcher) host->watcher(host->watcher_context, urb, host->now_us);
}

/// `urb`, which is in no queue any more, has ended.
static void end(pal_host* host, pal_urb* urb, int32_t status) {
    urb->status = status;
    append(&host->done, urb);
    tell_watcher(host, urb);
}

/// The first of `queue` has ended.
static void finish(pal_host* host, pal_host_queue* queue, int32_t status) {
    pal_urb* urb = take_first(queue);
    if (status == PAL_HOST_OK && urb->short_is_error && urb->n_done < urb->n_bytes) status = PAL_HOST_SHORT;
    end(host, urb, status);
}

static bool refused(pal_host* host, pal_host_queue* queue, int answer) {
    if (answer >= 0) return false;
    finish(host, queue, answer == PAL_HOST_DEVICE_STALLS ? PAL_HOST_STALLED : PAL_HOST_GONE);
    return true;
}

/// May the first of `queue` meet the device now?
static bool may_serve(const pal_host* host, const pal_host_queue* queue) {
    if (!queue->first) return false;
    if (host->timing == PAL_HOST_IMMEDIATE) return true;
    return queue->first->frame < host->now_us / PAL_HOST_FRAME_US &&
           queue->n_served < host->packets_per_frame;
}

/// In frames an IN token goes out at certain times only.
static bool is_token_time(const pal_host* host, uint64_t at_us) {
    return host->timing == PAL_HOST_IMMEDIATE || at_us % PAL_HOST_TOKEN_US == 0;
}

static bool serve_control(pal_host* host) {
    if (!may_serve(host, &host->control)) return false;
    pal_urb* urb = host->control.first;
    size_t n = (size_t)urb->setup[6] | (size_t)urb->setup[7] << 8;
    if (n > urb->n_bytes) n = urb->n_bytes;
    const int answer = host->device.control(host->device.context, urb->setup, urb->data, n);
    ++host->control.n_served;
    if (refused(host, &host->control, answer)) return true;
    const bool reads = (urb->setup[0] & REQUEST_IN) != 0;
    urb->n_done = reads && (size_t)answer < n ? (uint32_t)answer : (uint32_t)n;
    finish(host, &host->control, PAL_HOST_OK);
    return true;
}

/// One packet to the device. False when it has no room.
static bool serve_out(pal_host* host) {
    if (!may_serve(host, &host->out) || host->now_us < host->out_retry_us) return false;
    pal_urb* urb = host->out.first;
    const uint32_t left = urb->n_bytes - urb->n_done;
    const uint32_t n = left < PAL_HOST_PACKET_BYTES ? left : PAL_HOST_PACKET_BYTES;
    const int answer =
        n == 0 ? 0 : host->device.out(host->device.context, urb->data + urb->n_done, n);  // no bytes: no news
    if (answer == 0 && n > 0) {
        host->out_retry_us = (host->now_us / OUT_RETRY_US + 1) * OUT_RETRY_US;
        return false;
    }
    ++host->out.n_served;
    if (refused(host, &host->out, answer)) return true;
    urb->n_done += (uint32_t)answer < n ? (uint32_t)answer : n;
    if (urb->n_done == urb->n_bytes) finish(host, &host->out, PAL_HOST_OK);
    return true;
}

/// One packet from the device. False when it has none.
static bool serve_in(pal_host* host) {
    if (!may_serve(host, &host->in) || !is_token_time(host, host->now_us)) return false;
    uint8_t packet[PAL_HOST_PACKET_BYTES];
    const int answer = host->device.in(host->device.context, packet);
    if (answer == 0) return false;
    ++host->in.n_served;
    if (refused(host, &host->in, answer)) return true;
    pal_urb* urb = host->in.first;
    const uint32_t room = urb->n_bytes - urb->n_done;
    const uint32_t n = (uint32_t)answer < PAL_HOST_PACKET_BYTES ? (uint32_t)answer : PAL_HOST_PACKET_BYTES;
    const uint32_t fits = n < room ? n : room;
    if (fits > 0) memcpy(urb->data + urb->n_done, packet, fits);
    urb->n_done += fits;
    if (n > room) {
        finish(host, &host->in, PAL_HOST_OVERFLOW);
    } else if (n < PAL_HOST_PACKET_BYTES || urb->n_done == urb->n_bytes) {
        finish(host, &host->in, PAL_HOST_OK);  // a packet that is not full ends a transfer
    }
    return true;
}

static void step_to(pal_host* host, uint64_t at_us) {
    if (at_us / PAL_HOST_FRAME_US != host->now_us / PAL_HOST_FRAME_US) {
        host->control.n_served = host->in.n_served = host->out.n_served = 0;
    }
    host->now_us = at_us;
    host->fresh = false;
    host->device.advance(host->device.context, at_us);
    if (!host->device.present(host->device.context)) {
        pal_host_end(host, NULL, PAL_HOST_GONE);
        return;
    }
    // Each round ends a packet of a URB, and none can be submitted meanwhile: it ends.
    bool served = true;
    while (served) {
        served = serve_control(host);
        served = serve_out(host) || served;
        served = serve_in(host) || served;
    }
}

void pal_host_init(pal_host* host, const pal_host_device* device, pal_host_timing timing,
                   uint32_t packets_per_frame) {
    memset(host, 0, sizeof *host);
    host->device = *device;
    host->timing = timing;
    const uint32_t most = PAL_HOST_PACKETS_PER_FRAME_MAX;
    host->packets_per_frame = packets_per_frame < 1 ? 1 : packets_per_frame > most ? most : packets_per_frame;
}

void pal_host_watch(pal_host* host, pal_host_watcher watcher, void* context) {
    host->watcher = watcher;
    host->watcher_context = context;
}

int pal_host_submit(pal_host* host, pal_urb* urb, uint64_t now_us) {
    pal_host_queue* queue = queue_of(host, urb->endpoint);
    if (!queue) return PAL_HOST_NO_ENDPOINT;
    pal_host_advance(host, now_us);
    if (!host->device.present(host->device.context)) return PAL_HOST_GONE;
    urb->status = PAL_HOST_PENDING;
    urb->n_done = 0;
    urb->frame = host->now_us / PAL_HOST_FRAME_US;
    append(queue, urb);
    tell_watcher(host, urb);
    host->fresh = true;
    return PAL_HOST_OK;
}

bool pal_host_cancel(pal_host* host, pal_urb* urb) {
    pal_host_queue* queue = queue_of(host, urb->endpoint);
    if (!queue || !take(queue, urb)) return false;
    end(host, urb, PAL_HOST_CANCELLED);
    return true;
}

pal_urb* pal_host_find(const pal_host* host, const void* owner, uint64_t tag) {
    const pal_host_queue* queues[] = {&host->control, &host->in, &host->out, &host->done};
    for (int i = 0; i < 4; ++i) {
        for (pal_urb* urb = queues[i]->first; urb; urb = urb->next) {
            if (urb->owner == owner && urb->tag == tag) return urb;
        }
    }
    return NULL;
}

void pal_host_end(pal_host* host, const void* owner, int32_t status) {
    pal_host_queue* queues[] = {&host->control, &host->in, &host->out};
    for (int i = 0; i < 3; ++i) {
        pal_urb* following;
        for (pal_urb* urb = queues[i]->first; urb; urb = following) {
            following = urb->next;
            if (owner && urb->owner != owner) continue;
            (void)take(queues[i], urb);
            end(host, urb, status);
        }
    }
}

void pal_host_advance(pal_host* host, uint64_t now_us) {
    if (now_us < host->now_us) return;
    for (uint64_t at = pal_host_next_us(host); at < now_us; at = pal_host_next_us(host)) step_to(host, at);
    step_to(host, now_us);
}

static uint64_t earlier(uint64_t a, uint64_t b) {
    return a < b ? a : b;
}

/// The first IN token that is not before `at_us`.
static uint64_t token_us(const pal_host* host, uint64_t at_us) {
    if (is_token_time(host, at_us) || at_us > UINT64_MAX - PAL_HOST_TOKEN_US) return at_us;
    return (at_us / PAL_HOST_TOKEN_US + 1) * PAL_HOST_TOKEN_US;
}

uint64_t pal_host_next_us(const pal_host* host) {
    uint64_t at = UINT64_MAX;
    const pal_host_queue* queues[] = {&host->control, &host->in, &host->out};
    for (int i = 0; i < 3; ++i) {
        if (queues[i]->first && !may_serve(host, queues[i])) {
            at = (host->now_us / PAL_HOST_FRAME_US + 1) * PAL_HOST_FRAME_US;
        }
    }
    if (may_serve(host, &host->in)) {
        const uint64_t ready_us = host->device.next_us(host->device.context);
        // A device that says "now" and then has nothing must not stop the time.
        at = earlier(at, token_us(host, ready_us > host->now_us ? ready_us : host->now_us + 1));
    }
    if (may_serve(host, &host->out)) at = earlier(at, host->out_retry_us);
    if (host->fresh && host->timing == PAL_HOST_IMMEDIATE) return host->now_us;
    return at;
}

pal_urb* pal_host_reap(pal_host* host) {
    return take_first(&host->done);
}
