#include "sim/falcon/falcon_sim.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "sim/falcon/codec.h"
#include "sim/falcon/kinematics.h"
#include "sim/falcon/random.h"

static const double TICK_S = 1e-3;
// 320 slots x 4 a motor turn, 110 mm sector on a 14.25 mm shaft: 1572.56 counts/rad; zero at 35 degrees.
static const double COUNTS_PER_RAD = 1280.0 * (110.0 / 14.25) / 6.28318530717958648;
static const double THETA_ZERO_RAD = 0.61086523819801535;
static const double SCALE_MIN = 0.25, SCALE_MAX = 4.0;
// Elastic stops 2 degrees before the ends of the travel. Assumed: hard enough for 40 N, well damped.
static const double STOP_BEFORE_RAD = 0.035, STOP_N_M_PER_RAD = 100.0, STOP_N_M_S_PER_RAD = 0.3;
enum { ALL_HOMED = 7, HOMING_FLAG = 1, HOMED_SHIFT = 4, SPARE_AT = 14, N_SUBSTEPS_MAX = 1000 };

pal_falcon_sim_config pal_falcon_sim_config_default(void) {
    const pal_falcon_sim_config config = {
        .scale = 1.0,
        .mass_kg = 0.2,
        .gravity_m_per_s2 = 9.81,
        .viscous_n_s_per_m = 2.0,
        .coulomb_n = 0.3,
        .units_per_n_m = 4200.0,
        .home_theta_rad = -0.26179938779914944,
        .start_m = {0.0, 0.0, 0.12},
        .start_offset_counts = {731, -1290, 88},
        .watchdog_ticks = 100,
        .delay_ticks = 1,
        .n_substeps = 40,
    };
    return config;
}

void pal_falcon_sim_resize(pal_falcon_sim_config* config, double scale) {
    for (int i = 0; i < 3; ++i) config->start_m[i] *= scale / config->scale;
    config->scale = scale;
}

void pal_falcon_sim_seed(pal_falcon_sim_config* config, uint64_t seed) {
    for (int i = 0; i < 3; ++i) {
        config->start_offset_counts[i] = (int16_t)((int32_t)(pal_sim_random(&seed) & 0xFFFF) - 0x8000);
    }
}

/// In 1 - spread .. 1 + spread.
static double next_factor(uint64_t* state, double spread) {
    const double in_unit = (double)(pal_sim_random(state) >> 11) / 9007199254740992.0;  // 2^53
    return 1.0 + spread * (2.0 * in_unit - 1.0);
}

void pal_falcon_sim_vary(pal_falcon_sim_config* config, uint64_t seed, double spread) {
    pal_falcon_sim_seed(config, seed);
    uint64_t state = ~seed;  // another sequence
    config->mass_kg *= next_factor(&state, spread);
    config->viscous_n_s_per_m *= next_factor(&state, spread);
    config->coulomb_n *= next_factor(&state, spread);
    config->units_per_n_m *= next_factor(&state, spread);
}

static bool is_sane(const pal_falcon_sim_config* c) {
    return c->scale >= SCALE_MIN && c->scale <= SCALE_MAX && c->mass_kg > 0.0 && c->mass_kg < 100.0 &&
           fabs(c->gravity_m_per_s2) < 100.0 && c->viscous_n_s_per_m >= 0.0 && c->viscous_n_s_per_m < 1e4 &&
           c->coulomb_n >= 0.0 && c->coulomb_n < 1e3 && c->units_per_n_m > 0.0 && c->units_per_n_m < 1e9 &&
           c->home_theta_rad > PAL_FALCON_THETA_MIN_RAD && c->home_theta_rad < PAL_FALCON_THETA_MAX_RAD &&
           c->watchdog_ticks > 0 && c->delay_ticks <= PAL_FALCON_DELAY_MAX && c->n_substeps > 0 &&
           c->n_substeps <= N_SUBSTEPS_MAX && c->reply_spare < 16;
}

// A delta `scale` times as large has the same angles where everything is `scale` times as far.

static bool solve_theta(double scale, const double at_m[3], const double near_rad[3], double theta_rad[3]) {
    const double as_falcon_m[3] = {at_m[0] / scale, at_m[1] / scale, at_m[2] / scale};
    return pal_falcon_solve_theta(as_falcon_m, near_rad, theta_rad);
}

static void theta_gradient(double scale, const double at_m[3], const double theta_rad[3],
                           double jacobian[9]) {
    const double as_falcon_m[3] = {at_m[0] / scale, at_m[1] / scale, at_m[2] / scale};
    pal_falcon_theta_gradient(as_falcon_m, theta_rad, jacobian);
    for (int i = 0; i < 9; ++i) jacobian[i] /= scale;
}

static const double NEAR_RAD[3] = {0.5, 0.5, 0.5};  // somewhere in the travel

bool pal_falcon_sim_init(pal_falcon_sim* sim, const pal_falcon_sim_config* config) {
    memset(sim, 0, sizeof *sim);
    if (!is_sane(config) || !solve_theta(config->scale, config->start_m, NEAR_RAD, sim->theta_rad))
        return false;
    sim->config = *config;
    for (int i = 0; i < 3; ++i) {
        sim->position_m[i] = config->start_m[i];
        sim->offset_counts[i] = config->start_offset_counts[i];
    }
    return true;
}

/// Nearest count.
static int32_t counts_at(double theta_rad) {
    const double counts = (theta_rad - THETA_ZERO_RAD) * COUNTS_PER_RAD + 0.5;
    const int32_t towards_zero = (int32_t)counts;
    return towards_zero - (counts < (double)towards_zero ? 1 : 0);
}

/// A 16-bit counter wraps.
static int16_t wrapped(int32_t counts) {
    const int32_t low = (int32_t)((uint32_t)counts & 0xFFFFU);
    return (int16_t)(low >= 0x8000 ? low - 0x10000 : low);
}

static int16_t saturated(int16_t counts) {
    if (counts > PAL_FALCON_MOTOR_MAX) return PAL_FALCON_MOTOR_MAX;
    if (counts < -PAL_FALCON_MOTOR_MAX) return -PAL_FALCON_MOTOR_MAX;
    return counts;
}

/// An arm that is at or inside its reference while homing is on: its counter jumps to the true reading.
static void home(pal_falcon_sim* sim) {
    if (!sim->homing) return;
    for (int i = 0; i < 3; ++i) {
        if ((sim->homed >> i & 1) || !(sim->theta_rad[i] <= sim->config.home_theta_rad)) continue;
        sim->homed = (uint8_t)(sim->homed | (1 << i));
        sim->offset_counts[i] = 0;
    }
}

static void take_packet(pal_falcon_sim* sim) {
    const pal_falcon_request request = pal_falcon_request_decode(sim->rx);
    for (int i = 0; i < 3; ++i) sim->queued_counts[0][i] = saturated(request.motor_counts[i]);
    sim->homing = request.flags & HOMING_FLAG;
    sim->leds = (uint8_t)(request.flags & ~HOMING_FLAG);
    sim->spare = request.spare;
    sim->silent_ticks = 0;
    sim->has_reply = true;
}

void pal_falcon_sim_receive(pal_falcon_sim* sim, const uint8_t* bytes, size_t n_bytes) {
    for (size_t i = 0; i < n_bytes; ++i) {
        // '<' never occurs inside a packet, so a byte that does not fit may only begin the next one.
        if (!pal_falcon_request_byte_ok(bytes[i], sim->n_rx)) sim->n_rx = 0;
        if (!pal_falcon_request_byte_ok(bytes[i], sim->n_rx)) continue;
        sim->rx[sim->n_rx++] = bytes[i];
        if (sim->n_rx < PAL_FALCON_PACKET_BYTES) continue;
        sim->n_rx = 0;
        take_packet(sim);
    }
}

bool pal_falcon_sim_reply(pal_falcon_sim* sim, uint8_t reply[16]) {
    if (!sim->has_reply) return false;
    sim->has_reply = false;
    int16_t counts[3];
    pal_falcon_sim_read(sim, counts);
    const bool told = sim->homing || !sim->config.homed_needs_bit;
    const unsigned homed = told ? sim->homed & ALL_HOMED : 0U;
    pal_falcon_reply_encode(counts, (uint8_t)((sim->buttons & 0x0FU) | homed << HOMED_SHIFT), reply);
    reply[SPARE_AT] = (uint8_t)(reply[SPARE_AT] + sim->config.reply_spare);
    return true;
}

void pal_falcon_sim_read(const pal_falcon_sim* sim, int16_t encoder_counts[3]) {
    for (int i = 0; i < 3; ++i) {
        encoder_counts[i] = (sim->frozen >> i & 1)
                                ? sim->frozen_counts[i]
                                : wrapped(counts_at(sim->theta_rad[i]) + sim->offset_counts[i]);
    }
}

void pal_falcon_sim_freeze(pal_falcon_sim* sim, uint8_t axes) {
    int16_t counts[3];
    pal_falcon_sim_read(sim, counts);
    memcpy(sim->frozen_counts, counts, sizeof counts);
    sim->frozen = axes;
}

void pal_falcon_sim_restart(pal_falcon_sim* sim, const int16_t offset_counts[3]) {
    memset(sim->queued_counts, 0, sizeof sim->queued_counts);
    memset(sim->motor_counts, 0, sizeof sim->motor_counts);
    memset(sim->force_n, 0, sizeof sim->force_n);
    sim->homing = sim->leds = sim->homed = sim->spare = sim->n_rx = 0;
    sim->has_reply = false;
    sim->silent_ticks = 0;
    for (int i = 0; i < 3; ++i) sim->offset_counts[i] = offset_counts[i];
}

bool pal_falcon_sim_watchdog(const pal_falcon_sim* sim) {
    return sim->silent_ticks >= sim->config.watchdog_ticks;
}

/// The words that act in this tick; the others move up by one.
static void take_words(pal_falcon_sim* sim) {
    if (pal_falcon_sim_watchdog(sim)) memset(sim->queued_counts, 0, sizeof sim->queued_counts);
    memcpy(sim->motor_counts, sim->queued_counts[sim->config.delay_ticks], sizeof sim->motor_counts);
    for (int i = PAL_FALCON_DELAY_MAX; i > 0; --i) {
        memcpy(sim->queued_counts[i], sim->queued_counts[i - 1], sizeof sim->queued_counts[i]);
    }
    if (sim->silent_ticks < UINT32_MAX) ++sim->silent_ticks;
}

/// Virtual work: F = J^T tau. Positive words pull towards smaller angles.
static void motor_force(const double jacobian[9], const int16_t counts[3], double units_per_n_m,
                        double force_n[3]) {
    for (int axis = 0; axis < 3; ++axis) {
        force_n[axis] = 0.0;
        for (int i = 0; i < 3; ++i) {
            force_n[axis] -= jacobian[3 * i + axis] * (double)saturated(counts[i]) / units_per_n_m;
        }
    }
}

static void add_stops(const pal_falcon_sim* sim, const double jacobian[9], double force_n[3]) {
    const double hardness =
        sim->config.scale * sim->config.scale;  // of torque over angle: at the grip the same
    for (int i = 0; i < 3; ++i) {
        const double* row = jacobian + 3 * i;
        double over = sim->theta_rad[i] - (PAL_FALCON_THETA_MAX_RAD - STOP_BEFORE_RAD);
        if (!(over > 0.0)) over = sim->theta_rad[i] - (PAL_FALCON_THETA_MIN_RAD + STOP_BEFORE_RAD);
        const bool at_inner = over < 0.0;
        const bool at_outer = sim->theta_rad[i] > PAL_FALCON_THETA_MAX_RAD - STOP_BEFORE_RAD;
        if (!at_inner && !at_outer) continue;
        double rate = 0.0;
        for (int axis = 0; axis < 3; ++axis) rate += row[axis] * sim->velocity_m_per_s[axis];
        const double torque = hardness * (-STOP_N_M_PER_RAD * over - STOP_N_M_S_PER_RAD * rate);
        for (int axis = 0; axis < 3; ++axis) force_n[axis] += row[axis] * torque;
    }
}

/// Velocity after `dt_s` under `force_n`: implicit in both frictions, so that the effector sticks exactly.
static void accelerate(pal_falcon_sim* sim, const double force_n[3], double mass_kg, double dt_s) {
    double* v = sim->velocity_m_per_s;
    const double damp = 1.0 / (1.0 + dt_s * sim->config.viscous_n_s_per_m / mass_kg);
    for (int i = 0; i < 3; ++i) v[i] = (v[i] + dt_s * force_n[i] / mass_kg) * damp;
    const double speed = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const double lost = dt_s * sim->config.coulomb_n / mass_kg * damp;
    const double kept = speed > lost ? 1.0 - lost / speed : 0.0;
    for (int i = 0; i < 3; ++i) v[i] *= kept;
}

/// Semi-implicit Euler. Where the mechanism has no answer it stands still.
static void move(pal_falcon_sim* sim, double dt_s) {
    double to[3];
    for (int i = 0; i < 3; ++i) to[i] = sim->position_m[i] + dt_s * sim->velocity_m_per_s[i];
    if (solve_theta(sim->config.scale, to, sim->theta_rad, sim->theta_rad)) {
        memcpy(sim->position_m, to, sizeof to);
    } else {
        memset(sim->velocity_m_per_s, 0, sizeof sim->velocity_m_per_s);
    }
}

void pal_falcon_sim_advance(pal_falcon_sim* sim, pal_falcon_push push, const void* context,
                            double extra_mass_kg) {
    assert(extra_mass_kg >= 0.0);
    take_words(sim);
    const double dt_s = TICK_S / (double)sim->config.n_substeps;
    double jacobian[9];
    for (uint32_t n = 0; n < sim->config.n_substeps; ++n) {
        double force_n[3];
        double hand_n[3] = {0.0, 0.0, 0.0};
        theta_gradient(sim->config.scale, sim->position_m, sim->theta_rad, jacobian);
        motor_force(jacobian, sim->motor_counts, sim->config.units_per_n_m, force_n);
        add_stops(sim, jacobian, force_n);
        if (push) push(context, sim->position_m, sim->velocity_m_per_s, hand_n);
        for (int i = 0; i < 3; ++i) force_n[i] += hand_n[i];
        force_n[1] -= sim->config.mass_kg * sim->config.gravity_m_per_s2;
        accelerate(sim, force_n, sim->config.mass_kg + extra_mass_kg, dt_s);
        move(sim, dt_s);
        home(sim);
    }
    theta_gradient(sim->config.scale, sim->position_m, sim->theta_rad, jacobian);
    motor_force(jacobian, sim->motor_counts, sim->config.units_per_n_m, sim->force_n);
}

bool pal_falcon_sim_theta(const double at_m[3], double theta_rad[3]) {
    return solve_theta(1.0, at_m, NEAR_RAD, theta_rad);
}

bool pal_falcon_sim_jacobian(const double at_m[3], double jacobian[9]) {
    double theta_rad[3];
    if (!pal_falcon_sim_theta(at_m, theta_rad)) return false;
    theta_gradient(1.0, at_m, theta_rad, jacobian);
    return true;
}

bool pal_falcon_sim_motor_force(const pal_falcon_sim_config* config, const double at_m[3],
                                const int16_t motor_counts[3], double force_n[3]) {
    double theta_rad[3];
    double jacobian[9];
    if (!solve_theta(config->scale, at_m, NEAR_RAD, theta_rad)) return false;
    theta_gradient(config->scale, at_m, theta_rad, jacobian);
    motor_force(jacobian, motor_counts, config->units_per_n_m, force_n);
    return true;
}

bool pal_falcon_sim_counts(const double at_m[3], int16_t counts[3]) {
    double theta_rad[3];
    if (!pal_falcon_sim_theta(at_m, theta_rad)) return false;
    for (int i = 0; i < 3; ++i) counts[i] = wrapped(counts_at(theta_rad[i]));
    return true;
}
