#include "firmware/app/session.h"

#include <string.h>

#include "firmware/falcon/wire.h"

static const uint64_t TICK_NS = 1000000U;

void pal_session_begin(pal_session* session, pal_link* link, const pal_device* device,
                       const pal_loop_config* config, uint64_t (*now_ns)(void)) {
    session->config = *config;
    session->link = link;
    session->device = *device;
    session->now_ns = now_ns;
    session->intake.ring = &link->tables;
    session->intake.limits = pal_table_limits_default();
    session->heartbeat_seen = pal_link_load(&link->host.heartbeat);
}

static bool segment_gone(const pal_session* session) {
    return pal_link_load(&session->segment_gone) != 0;
}

static bool host_lost(pal_session* session) {
    const uint32_t heartbeat = pal_link_load(&session->link->host.heartbeat);
    // Ticks, not time: a machine that stops both processes for a second has lost nobody.
    session->quiet_ticks = heartbeat == session->heartbeat_seen ? session->quiet_ticks + 1U : 0U;
    session->heartbeat_seen = heartbeat;
    return session->quiet_ticks >= PAL_SESSION_HOST_QUIET_TICKS || pal_link_load(&session->host_gone) != 0;
}

static void read_words(pal_session* session, pal_sense* sense) {
    const pal_link_host* host = &session->link->host;
    sense->enable = pal_link_load(&host->enable) != 0;
    sense->estop = pal_link_load(&host->estop) != 0;
    sense->host_lost = host_lost(session) || segment_gone(session) ? 1 : 0;
}

static pal_session_end outcome(const pal_session* session, pal_device_news news, const pal_sense* sense) {
    if (segment_gone(session)) return PAL_SESSION_SEGMENT_GONE;
    if (news == PAL_DEVICE_GONE) return PAL_SESSION_DEVICE_GONE;
    if (sense->host_lost != 0) return PAL_SESSION_HOST_LOST;
    const bool asked = pal_link_load(&session->link->host.stop) != 0 || pal_link_load(&session->asked) != 0;
    return asked ? PAL_SESSION_ASKED : PAL_SESSION_RUNS;
}

static pal_device_news collect(const pal_session* session, pal_sense* sense, pal_tick* record) {
    const pal_device* device = &session->device;
    uint8_t packet[PAL_WIRE_BYTES];
    const pal_device_news news = device->collect(device->context, packet);
    if (news != PAL_DEVICE_FRESH || !pal_wire_decode(packet, sense)) return news;
    pal_device_times times = {.reply_ns = 0};
    if (device->times != NULL) device->times(device->context, &times);
    record->stamp_ns[0] = device->times != NULL ? times.reply_ns : session->now_ns();
    return news;
}

static pal_device_news send(pal_session* session, const pal_drive* drive, pal_tick* record) {
    const pal_device* device = &session->device;
    uint8_t packet[PAL_WIRE_BYTES];
    pal_wire_encode(drive, packet);
    const pal_device_news news = device->send(device->context, packet);
    pal_device_times times = {.reply_ns = 0};
    if (device->times != NULL) device->times(device->context, &times);
    if (news == PAL_DEVICE_FRESH) {
        session->handed_ns = device->times != NULL ? times.sent_ns : session->now_ns();
        record->stamp_ns[4] = session->handed_ns;
    }
    record->stamp_ns[5] = device->times != NULL ? times.done_ns : session->handed_ns;
    return news;
}

// The process was stopped within the tick: what was worked out is as old as a force that would have faded.
static void drop_if_old(pal_session* session, pal_drive* drive, pal_tick* record) {
    const uint64_t most_ns = session->config.late_fade_ticks * TICK_NS;
    if (record->stamp_ns[3] < record->t_ns || record->stamp_ns[3] - record->t_ns < most_ns) return;
    memset(drive->motor_counts, 0, sizeof drive->motor_counts);
    memset(record->motor_counts, 0, sizeof record->motor_counts);
    memset(record->force_n, 0, sizeof record->force_n);
    memset(session->loop.commanded_n, 0, sizeof session->loop.commanded_n);
    record->faults |= PAL_FAULT_LATE;
}

pal_session_end pal_session_tick(pal_session* session, const pal_session_time* when) {
    pal_sense sense = {.n_missed = when->n_missed - session->n_missed_seen};
    pal_tick record;
    pal_drive drive;
    session->n_missed_seen = when->n_missed;
    memset(&record, 0, sizeof record);
    record.t_ns = when->t_ns;
    record.n_missed = when->n_missed;
    record.wake_late_ns = when->wake_late_ns;
    record.stamp_ns[1] = when->t_ns;
    pal_device_news news = collect(session, &sense, &record);
    read_words(session, &sense);
    const pal_loop_tables* tables =
        pal_intake_poll(&session->intake, pal_loop_fading(&session->config, &session->loop));
    record.stamp_ns[2] = session->now_ns();
    (void)pal_loop_step(&session->config, &session->loop, &sense, tables, &drive, &record);
    record.stamp_ns[3] = session->now_ns();
    drop_if_old(session, &drive, &record);
    if (send(session, &drive, &record) == PAL_DEVICE_GONE) news = PAL_DEVICE_GONE;
    pal_state_ring_push(&session->link->ticks, &record);
    pal_link_store(&session->link->loop.n_bad_tables, tables->n_bad);
    pal_link_store(&session->link->loop.heartbeat, record.tick);
    return outcome(session, news, &sense);
}

void pal_session_send_zero(const pal_session* session) {
    const pal_drive zero = {.motor_counts = {0, 0, 0}};
    uint8_t packet[PAL_WIRE_BYTES];
    pal_wire_encode(&zero, packet);
    (void)session->device.send(session->device.context, packet);
}

void pal_session_finish(const pal_session* session, pal_session_end end) {
    uint32_t reason = 0;
    if (end == PAL_SESSION_HOST_LOST) reason = PAL_FAULT_HOST_LOST;
    if (end == PAL_SESSION_DEVICE_GONE) reason = PAL_FAULT_DEVICE_LOST;
    pal_link_store(&session->link->loop.end_reason, reason);
    pal_link_store(&session->link->loop.ended, 1);
}
