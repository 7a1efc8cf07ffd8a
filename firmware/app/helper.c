#include "firmware/app/helper.h"

#include <errno.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

#include "firmware/port/linux/disturbance.h"

enum {
    ROUND_NS = 1000000,
    HOST_LOOKS_APART = 10,      // rounds
    COUNTING_LOOKS_APART = 100  // rounds
};

static bool host_process_gone(const pal_session* session) {
    const uint32_t pid = pal_link_load(&session->link->host.pid);
    return pid != 0 && kill((pid_t)pid, 0) != 0 && errno == ESRCH;
}

static void tell_counts(const pal_helper* self, const pal_disturbance* disturbance) {
    pal_link_loop* words = &self->session->link->loop;
    pal_disturbance_counts counts;
    if (!pal_disturbance_read(disturbance, &counts)) return;
    pal_link_store(&words->n_minor_faults, counts.n_minor_faults);
    pal_link_store(&words->n_major_faults, counts.n_major_faults);
    pal_link_store(&words->n_preempted, counts.n_preempted);
}

static void* run_helper(void* context) {
    pal_helper* self = (pal_helper*)context;
    const struct timespec pause = {.tv_nsec = ROUND_NS};
    pal_disturbance disturbance = {.stat_file = -1, .status_file = -1};
    bool counting = false;
    for (uint32_t round = 0; pal_link_load(&self->stop) == 0; ++round) {
        (void)pal_intake_check(&self->session->intake);
        if (*self->signal_seen != 0) pal_link_store(&self->session->asked, 1);
        if (round % HOST_LOOKS_APART == 0 && host_process_gone(self->session)) {
            pal_link_store(&self->session->host_gone, 1);
        }
        const uint32_t thread = pal_link_load(&self->watched_thread);
        if (!counting && thread != 0) counting = pal_disturbance_open(&disturbance, (int)thread);
        if (counting && round % COUNTING_LOOKS_APART == 0) tell_counts(self, &disturbance);
        nanosleep(&pause, NULL);
    }
    if (counting) tell_counts(self, &disturbance);
    pal_disturbance_close(&disturbance);
    return NULL;
}

bool pal_helper_start(pal_helper* helper, pal_session* session, const volatile sig_atomic_t* signal_seen) {
    *helper = (pal_helper){.session = session, .signal_seen = signal_seen};
    return pthread_create(&helper->thread, NULL, run_helper, helper) == 0;
}

void pal_helper_watch_me(pal_helper* helper) {
    pal_link_store(&helper->watched_thread, (uint32_t)gettid());
}

void pal_helper_stop(pal_helper* helper) {
    pal_link_store(&helper->stop, 1);
    pthread_join(helper->thread, NULL);
}
