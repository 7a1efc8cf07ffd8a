#include "host/record/record.hpp"

namespace palpate::record {

#define PAL_VALUE(expression) \
    [](const pal_tick& tick, double) { return static_cast<double>(tick.expression); }

std::span<const Column> columns() {
    static constexpr Column table[] = {
        {"t_s", "s", "scene time: 0 where the hand's path begins, negative before",
         [](const pal_tick&, double t_s) { return t_s; }},
        {"tick", "1", "ticks of 1 ms since the loop's start", PAL_VALUE(tick)},
        {"x_m", "m", "tool centre as sensed, workspace frame, to the right", PAL_VALUE(position_m[0])},
        {"y_m", "m", "tool centre as sensed, up", PAL_VALUE(position_m[1])},
        {"z_m", "m", "tool centre as sensed, towards the user", PAL_VALUE(position_m[2])},
        {"vx_m_per_s", "m/s", "velocity, low-passed", PAL_VALUE(velocity_m_per_s[0])},
        {"vy_m_per_s", "m/s", "velocity, low-passed", PAL_VALUE(velocity_m_per_s[1])},
        {"vz_m_per_s", "m/s", "velocity, low-passed", PAL_VALUE(velocity_m_per_s[2])},
        {"fx_n", "N", "force on the hand as commanded, before motor rounding", PAL_VALUE(force_n[0])},
        {"fy_n", "N", "force on the hand as commanded", PAL_VALUE(force_n[1])},
        {"fz_n", "N", "force on the hand as commanded", PAL_VALUE(force_n[2])},
        {"depth_m", "m", "tool's lowest point below the undeformed skin, positive inside",
         PAL_VALUE(depth_m)},
        {"k_n_per_m", "N/m", "linear stiffness under the tool; 0 without contact", PAL_VALUE(k_n_per_m)},
        {"table_id", "1", "table in use; 0: none", PAL_VALUE(table_id)},
        {"table_age_ticks", "ticks", "since a table was last taken", PAL_VALUE(table_age_ticks)},
        {"faults", "1", "bits of this tick, PAL_FAULT_*", PAL_VALUE(faults)},
        {"state", "1", "PAL_STATE_*: 0 disabled 1 homing 2 ramp 3 enabled 4 paused 5 fault",
         PAL_VALUE(state)},
        {"stop", "1", "the fault bit that latched the stop; 0: none", PAL_VALUE(stop)},
        {"gain", "1", "ladder and ramp: force is gain times what the tables say", PAL_VALUE(gain)},
        {"before_id", "1", "table that is being faded out; 0: none", PAL_VALUE(before_id)},
        {"fade_weight", "1", "share of table_id; before_id has the rest", PAL_VALUE(fade_weight)},
        {"table_fx_n", "N", "what the tables said", PAL_VALUE(table_force_n[0])},
        {"table_fy_n", "N", "what the tables said", PAL_VALUE(table_force_n[1])},
        {"table_fz_n", "N", "what the tables said", PAL_VALUE(table_force_n[2])},
        {"encoder_0_counts", "counts", "encoder of the first leg", PAL_VALUE(encoder_counts[0])},
        {"encoder_1_counts", "counts", "encoder of the second leg", PAL_VALUE(encoder_counts[1])},
        {"encoder_2_counts", "counts", "encoder of the third leg", PAL_VALUE(encoder_counts[2])},
        {"motor_0_counts", "counts", "motor word of the first leg", PAL_VALUE(motor_counts[0])},
        {"motor_1_counts", "counts", "motor word of the second leg", PAL_VALUE(motor_counts[1])},
        {"motor_2_counts", "counts", "motor word of the third leg", PAL_VALUE(motor_counts[2])},
        {"buttons", "1", "bits, one a button", PAL_VALUE(buttons)},
        {"homed", "1", "1: the device knows its origin", PAL_VALUE(homed)},
        {"potential_j", "J", "energy stored in the skin, from the tables", PAL_VALUE(potential_j)},
        {"fade_work_j", "J", "put in by table swaps since the start", PAL_VALUE(fade_work_j)},
        {"hand_work_j", "J", "done by the device on the hand since the start", PAL_VALUE(hand_work_j)},
        {"truth_valid", "1", "1: the true_ columns hold (simulated device)", PAL_VALUE(truth_valid)},
        {"true_x_m", "m", "where the tool centre really is at the end of the tick",
         PAL_VALUE(truth_position_m[0])},
        {"true_y_m", "m", "likewise, up", PAL_VALUE(truth_position_m[1])},
        {"true_z_m", "m", "likewise, towards the user", PAL_VALUE(truth_position_m[2])},
        {"true_fx_n", "N", "what the motor words of this tick do there", PAL_VALUE(truth_force_n[0])},
        {"true_fy_n", "N", "likewise", PAL_VALUE(truth_force_n[1])},
        {"true_fz_n", "N", "likewise", PAL_VALUE(truth_force_n[2])},
        {"target_x_m", "m", "where the hand wants to be (simulated hand)", PAL_VALUE(hand_target_m[0])},
        {"target_y_m", "m", "likewise, up", PAL_VALUE(hand_target_m[1])},
        {"target_z_m", "m", "likewise, towards the user", PAL_VALUE(hand_target_m[2])},
        {"path_ticks", "ticks", "since the hand's path began; 0 before", PAL_VALUE(path_tick)},
        {"missed_ticks", "ticks", "periods missed since the start", PAL_VALUE(n_missed)},
        {"wake_late_ns", "ns", "t_ns minus the programmed start of the tick; 0 in virtual time",
         PAL_VALUE(wake_late_ns)},
        {"t_ns", "ns", "start of the tick: CLOCK_MONOTONIC, or virtual time", PAL_VALUE(t_ns)},
    };
    return table;
}

#undef PAL_VALUE

std::vector<double> scene_times_s(std::span<const pal_tick> ticks) {
    constexpr double TICKS_PER_S = 1000.0;
    std::int64_t zero = ticks.empty() ? 0 : ticks[0].tick;
    for (const pal_tick& tick : ticks) {
        if (tick.path_tick == 0) continue;
        zero = std::int64_t{tick.tick} - std::int64_t{tick.path_tick};
        break;
    }
    std::vector<double> times;
    times.reserve(ticks.size());
    for (const pal_tick& tick : ticks) {
        const std::int64_t since = tick.path_tick > 0 ? tick.path_tick : std::int64_t{tick.tick} - zero;
        times.push_back(static_cast<double>(since) / TICKS_PER_S);
    }
    return times;
}

}  // namespace palpate::record
