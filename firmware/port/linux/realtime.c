#include "firmware/port/linux/realtime.h"

#include <errno.h>
#include <fcntl.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { PAGE_BYTES = 4096, LATENCY_US = 0, DEADLINE_POLICY = 6 };

static const uint64_t RUNTIME_NS = 200000U;
static const uint64_t PERIOD_NS = 1000000U;

// struct sched_attr of the kernel, first version; glibc 2.36 has no call for it.
typedef struct deadline_attributes {
    uint32_t n_bytes, policy;
    uint64_t flags;
    int32_t nice;
    uint32_t priority;
    uint64_t runtime_ns, deadline_ns, period_ns;
} deadline_attributes;

void pal_realtime_prepare_process(void) {
    pthread_attr_t attributes;
    (void)mallopt(M_TRIM_THRESHOLD, -1);
    (void)mallopt(M_MMAP_MAX, 0);
    if (pthread_attr_init(&attributes) != 0) return;
    if (pthread_attr_setstacksize(&attributes, PAL_REALTIME_STACK_BYTES) == 0) {
        (void)pthread_setattr_default_np(&attributes);
    }
    (void)pthread_attr_destroy(&attributes);
}

// ---- the processor

static int pin(int cpu) {
    cpu_set_t wanted;
    CPU_ZERO(&wanted);
    CPU_SET((size_t)cpu, &wanted);
    return sched_setaffinity(0, sizeof wanted, &wanted) == 0 ? 0 : errno;
}

bool pal_realtime_possible(const pal_realtime_choice* choice, char why[PAL_REALTIME_WORDS_BYTES]) {
    const int cpu = choice->cpu;
    if (cpu == PAL_REALTIME_ANY_CPU) return true;
    const long n_cpus = sysconf(_SC_NPROCESSORS_CONF);
    if (cpu < 0 || cpu >= n_cpus || cpu >= CPU_SETSIZE) {
        (void)snprintf(why, PAL_REALTIME_WORDS_BYTES, "--cpu %d: this machine has processors 0 to %ld", cpu,
                       n_cpus - 1);
        return false;
    }
    cpu_set_t before;
    if (sched_getaffinity(0, sizeof before, &before) != 0) return true;
    const int error = pin(cpu);
    (void)sched_setaffinity(0, sizeof before, &before);
    if (error == 0) return true;
    (void)snprintf(why, PAL_REALTIME_WORDS_BYTES,
                   "--cpu %d: not for this process (%s); see cpuset and taskset", cpu, strerror(error));
    return false;
}

// ---- the steps

static int lock_memory(void) {
    return mlockall(MCL_CURRENT | MCL_FUTURE) == 0 ? 0 : errno;
}

static int hold_cpu_latency(int* file) {
    const int32_t latency_us = LATENCY_US;
    *file = open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
    if (*file < 0) return errno;
    if (write(*file, &latency_us, sizeof latency_us) == (ssize_t)sizeof latency_us) return 0;
    const int error = errno;
    (void)close(*file);
    *file = -1;
    return error;
}

static int cut_slack(void) {
    return prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL) == 0 ? 0 : errno;
}

static int use_fifo(int priority) {
    const struct sched_param wanted = {.sched_priority = priority};
    return pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
}

static int use_deadline(void) {
    const deadline_attributes wanted = {
        .n_bytes = sizeof wanted,
        .policy = DEADLINE_POLICY,
        .runtime_ns = RUNTIME_NS,
        .deadline_ns = PERIOD_NS,
        .period_ns = PERIOD_NS,
    };
    return syscall(SYS_sched_setattr, 0, &wanted, 0U) == 0 ? 0 : errno;
}

// Its own frame, so that the pages are below those of every tick's.
__attribute__((noinline)) static void write_stack(void) {
    volatile uint8_t bytes[PAL_REALTIME_STACK_BYTES];
    for (size_t i = 0; i < sizeof bytes; i += PAGE_BYTES) bytes[i] = 1;
}

static int touch_stack(void) {
    struct rlimit limit;
    if (getrlimit(RLIMIT_STACK, &limit) != 0) return errno;
    if (limit.rlim_cur < 2 * (rlim_t)PAL_REALTIME_STACK_BYTES) return ENOMEM;
    write_stack();
    return 0;
}

static void note(pal_realtime_grants* grants, pal_realtime step, int error, const char* what,
                 const char* how) {
    if (error == 0) {
        grants->granted |= (uint32_t)step;
        return;
    }
    grants->refused |= (uint32_t)step;
    (void)fprintf(stderr, "palpate-loop: no %s (%s); carrying on without it. To have it: %s\n", what,
                  strerror(error), how);
}

static void use_policy(const pal_realtime_choice* choice, pal_realtime_grants* grants) {
    if (choice->policy == PAL_POLICY_FIFO) {
        note(grants, PAL_REALTIME_FIFO, use_fifo(choice->priority), "real-time priority (SCHED_FIFO)",
             "\"@realtime - rtprio 99\" in /etc/security/limits.d/palpate.conf, this user in the group "
             "realtime, "
             "a new login");
    }
    if (choice->policy == PAL_POLICY_DEADLINE) {
        note(grants, PAL_REALTIME_DEADLINE, use_deadline(), "deadline scheduling (SCHED_DEADLINE)",
             "setcap cap_sys_nice+ep on palpate-loop; or use --policy fifo");
    }
}

void pal_realtime_begin(const pal_realtime_choice* choice, pal_realtime_grants* grants) {
    *grants = (pal_realtime_grants){.latency_file = -1};
    if (choice->lock_memory) {
        note(grants, PAL_REALTIME_MEMORY_LOCKED, lock_memory(), "locked memory",
             "ulimit -l unlimited; for good, \"@realtime - memlock unlimited\" in "
             "/etc/security/limits.d/palpate.conf");
    }
    note(grants, PAL_REALTIME_CPU_LATENCY, hold_cpu_latency(&grants->latency_file),
         "hold on /dev/cpu_dma_latency",
         "a udev rule KERNEL==\"cpu_dma_latency\", GROUP=\"realtime\", MODE=\"0660\"");
    note(grants, PAL_REALTIME_TIMER_SLACK, cut_slack(), "timer slack of 1 ns",
         "a kernel with PR_SET_TIMERSLACK");
    if (choice->cpu != PAL_REALTIME_ANY_CPU) {
        note(grants, PAL_REALTIME_CPU, pin(choice->cpu), "processor of its own", "see cpuset and taskset");
    }
    use_policy(choice, grants);
    note(grants, PAL_REALTIME_STACK_TOUCHED, touch_stack(), "touched stack", "ulimit -s 8192");
}

void pal_realtime_end(pal_realtime_grants* grants) {
    if (grants->latency_file >= 0) (void)close(grants->latency_file);
    grants->latency_file = -1;
}
