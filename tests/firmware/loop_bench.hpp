/// A loop with nothing around it: counts from a position, one step, drive and record kept.
#pragma once
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "firmware/core/step.h"
#include "tests/common/tables.hpp"

struct LoopBench {
    pal_loop_config config = pal_loop_config_default();
    pal_loop loop{};
    pal_sense sense{};
    pal_loop_tables given{};
    pal_drive drive{};
    pal_tick record{};
    std::uint32_t faults = 0;

    LoopBench() {
        config.ramp_ticks = 0;
        sense.fresh = 1;
        sense.enable = 1;
        sense.homed = 7;
        move(0.0, 0.0, 0.0);
    }
    /// Puts the tool there (workspace frame, to the nearest encoder count).
    void move(double x_m, double y_m, double z_m) {
        const float at[3] = {static_cast<float>(x_m) + config.centre_m[0],
                             static_cast<float>(y_m) + config.centre_m[1],
                             static_cast<float>(z_m) + config.centre_m[2]};
        float theta[3];
        if (!pal_delta_inverse(config.delta, at, theta)) throw std::logic_error("outside the workspace");
        for (int i = 0; i < 3; ++i) {
            if (!pal_delta_counts(config.delta, theta[i], &sense.encoder_counts[i]))
                throw std::logic_error("counts");
        }
    }
    std::uint32_t step(int n_ticks = 1) {
        for (int n = 0; n < n_ticks; ++n) {
            faults = pal_loop_step(&config, &loop, &sense, &given, &drive, &record);
        }
        return faults;
    }
    [[nodiscard]] bool motors_are_zero() const {
        return drive.motor_counts[0] == 0 && drive.motor_counts[1] == 0 && drive.motor_counts[2] == 0;
    }
    [[nodiscard]] double force_n() const {
        return std::sqrt(static_cast<double>(record.force_n[0]) * static_cast<double>(record.force_n[0]) +
                         static_cast<double>(record.force_n[1]) * static_cast<double>(record.force_n[1]) +
                         static_cast<double>(record.force_n[2]) * static_cast<double>(record.force_n[2]));
    }
};
