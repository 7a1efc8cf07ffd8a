#include "sim/hand/hand.h"

#include <string.h>

static const double TICK_S = 1e-3;
enum { HOMING_MOVE_TICKS = 400 };
// The helper's grip: assumed, stiff enough to hold an effector of 0.2 kg up within 1 mm, without a mass of
// its own.
static const double HELPER_N_PER_M = 2000.0, HELPER_N_S_PER_M = 30.0;

void pal_hand_init(pal_hand* hand, const pal_hand_config* config) {
    memset(hand, 0, sizeof *hand);
    hand->config = *config;
}

/// From from_m to `to_m` along s = 3 x^2 - 2 x^3, where x is `part` of the way in time, 0..1.
static void move_smoothly(pal_hand* hand, const double to_m[3], double part, double duration_s) {
    const double s = part * part * (3.0 - 2.0 * part);
    const double s_per_s = 6.0 * part * (1.0 - part) / duration_s;
    for (int i = 0; i < 3; ++i) {
        const double way_m = to_m[i] - hand->from_m[i];
        hand->target_m[i] = hand->from_m[i] + s * way_m;
        hand->target_velocity_m_per_s[i] = s_per_s * way_m;
    }
}

static void stay_at(pal_hand* hand, const double at_m[3]) {
    for (int i = 0; i < 3; ++i) {
        hand->target_m[i] = at_m[i];
        hand->target_velocity_m_per_s[i] = 0.0;
    }
}

static void go_home(pal_hand* hand) {
    if (hand->tick <= HOMING_MOVE_TICKS) {
        move_smoothly(hand, hand->config.home_in_m, (double)hand->tick / HOMING_MOVE_TICKS,
                      HOMING_MOVE_TICKS * TICK_S);
    } else {
        stay_at(hand, hand->config.home_in_m);
    }
}

static void follow_path(pal_hand* hand) {
    const pal_hand_point* path = hand->config.path;
    const double t_s = (double)hand->path_tick * TICK_S;
    while (hand->segment + 1 < hand->config.n_points && path[hand->segment + 1].t_s <= t_s) ++hand->segment;
    const pal_hand_point* from = path + hand->segment;
    if (t_s < from->t_s || hand->segment + 1 == hand->config.n_points) {
        stay_at(hand, from->at_m);
        return;
    }
    const pal_hand_point* to = from + 1;
    const double duration_s = to->t_s - from->t_s;
    const double part = (t_s - from->t_s) / duration_s;
    for (int i = 0; i < 3; ++i) {
        hand->target_m[i] = from->at_m[i] + part * (to->at_m[i] - from->at_m[i]);
        hand->target_velocity_m_per_s[i] = (to->at_m[i] - from->at_m[i]) / duration_s;
    }
}

void pal_hand_advance(pal_hand* hand, bool homed, const double at_m[3]) {
    if (hand->homed_tick != 0 && !homed) {  // it was started anew: home it again, then the path again
        hand->tick = hand->homed_tick = hand->path_tick = 0;
        hand->segment = 0;
    }
    if (hand->tick == 0) memcpy(hand->from_m, at_m, sizeof hand->from_m);
    ++hand->tick;
    if (hand->homed_tick == 0 && !homed) {
        go_home(hand);
        return;
    }
    if (hand->homed_tick == 0) {
        hand->homed_tick = hand->tick;
        if (hand->tick > 1) memcpy(hand->from_m, hand->target_m, sizeof hand->from_m);
    }
    if (hand->config.n_points == 0) {
        stay_at(hand, hand->from_m);
        return;
    }
    const uint32_t since = hand->tick - hand->homed_tick;
    const uint32_t wait = hand->config.wait_ticks;
    if (since < wait) {
        move_smoothly(hand, hand->config.path[0].at_m, (double)(since + 1) / (double)wait,
                      (double)wait * TICK_S);
        return;
    }
    hand->path_tick = since - wait + 1;
    follow_path(hand);
}

/// Until the path begins; without a path until the device is homed.
static bool needs_help(const pal_hand* hand) {
    const bool over = hand->config.n_points > 0 ? hand->path_tick > 0 : hand->homed_tick > 0;
    return !over && !(hand->config.stiffness_n_per_m > 0.0);
}

void pal_hand_push(const void* context, const double position_m[3], const double velocity_m_per_s[3],
                   double force_n[3]) {
    const pal_hand* hand = context;
    const bool helped = needs_help(hand);
    const double stiffness_n_per_m = helped ? HELPER_N_PER_M : hand->config.stiffness_n_per_m;
    const double damping_n_s_per_m = helped ? HELPER_N_S_PER_M : hand->config.damping_n_s_per_m;
    for (int i = 0; i < 3; ++i) {
        force_n[i] = stiffness_n_per_m * (hand->target_m[i] - position_m[i]) +
                     damping_n_s_per_m * (hand->target_velocity_m_per_s[i] - velocity_m_per_s[i]);
    }
    force_n[1] += hand->config.weight_n;
}
