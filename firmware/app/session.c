#include "firmware/app/session.h"

#include <string.h>

#include "firmware/falcon/wire.h"

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
    sense->host_lost = host_lost(session) ? 1 : 0;
}

static pal_session_end outcome(const pal_session* session, pal_device_news news, const pal_sense* sense) {
    if (news == PAL_DEVICE_GONE) return PAL_SESSION_DEVICE_GONE;
    if (sense->host_lost != 0) return PAL_SESSION_HOST_LOST;
    const bool asked = pal_link_load(&session->link->host.stop) != 0 || pal_link_load(&session->asked) != 0;
    return asked ? PAL_SESSION_ASKED : PAL_SESSION_RUNS;
}

pal_session_end pal_session_tick(pal_session* session, uint64_t t_ns, uint32_t n_missed) {
    uint8_t packet[PAL_WIRE_BYTES];
    pal_sense sense = {.fresh = 0};
    pal_tick record;
    pal_drive drive;
    memset(&record, 0, sizeof record);
    record.t_ns = t_ns;
    record.n_missed = n_missed;
    record.stamp_ns[1] = t_ns;
    pal_device_news news = session->device.collect(session->device.context, packet);
    if (news == PAL_DEVICE_FRESH) (void)pal_wire_decode(packet, &sense);
    record.stamp_ns[0] = session->now_ns();
    read_words(session, &sense);
    const pal_loop_tables* tables =
        pal_intake_poll(&session->intake, pal_loop_fading(&session->config, &session->loop));
    record.stamp_ns[2] = session->now_ns();
    (void)pal_loop_step(&session->config, &session->loop, &sense, tables, &drive, &record);
    record.stamp_ns[3] = session->now_ns();
    pal_wire_encode(&drive, packet);
    if (session->device.send(session->device.context, packet) == PAL_DEVICE_GONE) news = PAL_DEVICE_GONE;
    record.stamp_ns[4] = session->now_ns();
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
