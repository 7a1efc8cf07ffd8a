// palpate-falcon rate.
#include <stdio.h>
#include <string.h>

#include "firmware/app/falcon_cli.h"

// Times between replies by 10 us, so that quantiles need no list of them.
enum { BIN_US = 10, N_BINS = 10000, N_CLASSES = 9 };
static const double SUCCESS_MIN = 0.999;

typedef struct rate {
    uint32_t bins[N_BINS];  ///< the last one: all that is longer
    uint32_t n_intervals;
    uint64_t longest_us;
    uint64_t begun_us, last_us;
    pal_falcon_sense begun, now;
} rate;

static uint32_t n_requests_of(const pal_falcon_sense* s) {
    return s->n_exchanges + s->n_timeouts;
}

static void note_interval(rate* r) {
    const uint64_t interval_us = r->now.time_us - r->last_us;
    const uint64_t bin = interval_us / BIN_US;
    r->bins[bin < N_BINS - 1 ? bin : N_BINS - 1] += 1U;
    r->n_intervals += 1U;
    if (interval_us > r->longest_us) r->longest_us = interval_us;
    r->last_us = r->now.time_us;
}

// The time that a share `q` of the intervals does not exceed, to BIN_US; the longest one when it lies in the
// last bin.
static unsigned long long quantile_us(const rate* r, double q) {
    const double wanted = q * (double)r->n_intervals;
    double passed = 0.0;
    for (uint32_t i = 0; i < N_BINS - 1; ++i) {
        passed += (double)r->bins[i];
        if (passed >= wanted) return (i + 1ULL) * BIN_US;
    }
    return r->longest_us;
}

typedef struct verdict {
    double seconds, rate_hz, success;
    uint32_t n_requests, n_replies, n_timeouts, n_unasked;
    bool device_failed;  ///< on the way
    bool good;
} verdict;

static verdict judge(const rate* r, const pal_falcon_options* options, bool device_failed) {
    verdict v = {.seconds = (double)(r->last_us - r->begun_us) * 1e-6, .device_failed = device_failed};
    v.n_replies = r->now.n_exchanges - r->begun.n_exchanges;
    v.n_timeouts = r->now.n_timeouts - r->begun.n_timeouts;
    v.n_unasked = r->now.n_unasked - r->begun.n_unasked;
    v.n_requests = v.n_replies + v.n_timeouts;
    v.rate_hz = v.seconds > 0.0 ? (double)v.n_replies / v.seconds : 0.0;
    v.success = v.n_requests > 0 ? (double)v.n_replies / (double)v.n_requests : 0.0;
    v.good = !device_failed && v.success >= SUCCESS_MIN && v.rate_hz >= options->rate_min_hz;
    return v;
}

static void print_histogram(const rate* r) {
    static const uint32_t EDGES_US[N_CLASSES + 1] = {0,    500,  900,  1100,  1500,
                                                     2000, 3000, 5000, 10000, N_BINS * BIN_US};
    (void)printf("time from reply to reply:\n");
    for (int c = 0; c < N_CLASSES; ++c) {
        uint32_t n = 0;
        for (uint32_t i = EDGES_US[c] / BIN_US; i < EDGES_US[c + 1] / BIN_US; ++i) n += r->bins[i];
        const double share = r->n_intervals > 0 ? (double)n / (double)r->n_intervals : 0.0;
        (void)printf("  %5.1f to %5.1f ms %9u %6.2f %% ", (double)EDGES_US[c] * 1e-3,
                     (double)EDGES_US[c + 1] * 1e-3, n, 100.0 * share);
        for (int bar = 0; bar < (int)(40.0 * share + 0.5); ++bar) (void)putchar('#');
        (void)putchar('\n');
    }
}

static void print_words(const rate* r, const verdict* v, const pal_falcon_options* options) {
    (void)printf("%u requests in %.2f s: %u replies (%.3f %%), %u without a reply, %u replies too many\n",
                 v->n_requests, v->seconds, v->n_replies, 100.0 * v->success, v->n_timeouts, v->n_unasked);
    (void)printf(
        "%.1f exchanges a second; from reply to reply: median %llu us, 99 %% within %llu us, longest %llu "
        "us\n",
        v->rate_hz, quantile_us(r, 0.5), quantile_us(r, 0.99), (unsigned long long)r->longest_us);
    print_histogram(r);
    if (v->good) {
        (void)printf("good: at least %.1f %% of the requests answered, at least %g exchanges a second\n",
                     100.0 * SUCCESS_MIN, options->rate_min_hz);
    } else if (v->device_failed) {
        (void)printf("bad: the device failed on the way\n");
    } else if (v->success < SUCCESS_MIN) {
        (void)printf("bad: too many requests without a reply. Use another cable or port, without a hub.\n");
    } else {
        (void)printf(
            "bad: fewer than %g exchanges a second. Close other programs, use a port without a hub, try "
            "--no-event-char.\n",
            options->rate_min_hz);
    }
}

static void print_json(const pal_falcon_cli* cli, const rate* r, const verdict* v) {
    (void)printf("{\"schema\": \"palpate.falcon_rate/1\", \"serial\": ");
    pal_cli_json_text(stdout, cli->serial);
    (void)printf(", \"good\": %s, \"seconds\": %.6f, \"rate_hz\": %.3f, \"success\": %.6f,",
                 v->good ? "true" : "false", v->seconds, v->rate_hz, v->success);
    (void)printf(" \"n_requests\": %u, \"n_replies\": %u, \"n_timeouts\": %u, \"n_unasked\": %u,",
                 v->n_requests, v->n_replies, v->n_timeouts, v->n_unasked);
    (void)printf(
        " \"interval_us\": {\"p50\": %llu, \"p90\": %llu, \"p99\": %llu, \"p999\": %llu, \"max\": %llu},",
        quantile_us(r, 0.5), quantile_us(r, 0.9), quantile_us(r, 0.99), quantile_us(r, 0.999),
        (unsigned long long)r->longest_us);
    (void)printf(" \"bin_us\": %d, \"bins\": [", BIN_US);
    uint32_t n_bins = N_BINS;
    while (n_bins > 1 && r->bins[n_bins - 1] == 0) n_bins -= 1U;
    for (uint32_t i = 0; i < n_bins; ++i) (void)printf("%s%u", i > 0 ? "," : "", r->bins[i]);
    (void)printf("]}\n");
}

static int measure(pal_falcon_cli* cli, rate* r) {
    const pal_falcon_options* options = cli->options;
    (void)pal_falcon_read(&cli->falcon, &r->begun);
    r->now = r->begun;
    r->begun_us = r->last_us = r->begun.time_us;
    const uint64_t until_us = pal_usb_now_us() + (uint64_t)(1e6 * options->seconds);
    while (!pal_cli_interrupted()) {
        const uint32_t n_wanted = options->n_exchanges;
        if (n_wanted > 0 && n_requests_of(&r->now) - n_requests_of(&r->begun) >= n_wanted) break;
        if (n_wanted == 0 && pal_usb_now_us() >= until_us) break;
        const uint32_t n_before = r->now.n_exchanges;
        (void)pal_cli_turn(cli);
        if (pal_falcon_read(&cli->falcon, &r->now) == PAL_FALCON_FAULT) return pal_cli_tell_fault(cli);
        if (r->now.n_exchanges != n_before) note_interval(r);
    }
    return pal_cli_interrupted() ? PAL_EXIT_INTERRUPTED : PAL_EXIT_DONE;
}

int pal_falcon_rate(pal_falcon_cli* cli) {
    static rate r;
    memset(&r, 0, sizeof r);
    int code = pal_cli_boot(cli);
    if (code == PAL_EXIT_DONE) code = measure(cli, &r);
    if (r.n_intervals == 0 && code == PAL_EXIT_DONE) {
        (void)fprintf(stderr, "palpate-falcon: nothing was measured; give more --seconds\n");
        return PAL_EXIT_VERDICT;
    }
    if (r.n_intervals == 0) return code;
    const verdict v = judge(&r, cli->options, code == PAL_EXIT_DEVICE);
    if (cli->options->json) {
        print_json(cli, &r, &v);
    } else {
        print_words(&r, &v, cli->options);
    }
    return code == PAL_EXIT_DONE && !v.good ? PAL_EXIT_VERDICT : code;
}
