/// A session whose segment somebody else writes to: a device of bytes, and what may be said of every request
/// that it gets, whatever lies in the segment.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <random>

#include "firmware/app/session.h"
#include "firmware/falcon/wire.h"
#include "tests/common/tables.hpp"

namespace hostile {

struct Device {
    std::array<std::uint8_t, PAL_WIRE_BYTES> reply{}, request{};
};

inline pal_device_news collect(void* context, std::uint8_t reply[16]) {
    std::memcpy(reply, static_cast<Device*>(context)->reply.data(), PAL_WIRE_BYTES);
    return PAL_DEVICE_FRESH;
}

inline pal_device_news send(void* context, const std::uint8_t request[16]) {
    std::memcpy(static_cast<Device*>(context)->request.data(), request, PAL_WIRE_BYTES);
    return PAL_DEVICE_FRESH;
}

inline std::uint64_t no_time() {
    return 0;
}

/// An uneven skin, so that every header field and coefficient counts.
inline std::unique_ptr<pal_table> uneven(std::uint64_t id) {
    tables::Fields fields;
    fields.s_m = [](double u, double v) { return 2e-4 * std::sin(300.0 * u) * std::cos(250.0 * v); };
    fields.k_n_per_m = [](double u, double v) { return 600.0 + 100.0 * std::sin(200.0 * u + 150.0 * v); };
    fields.h_per_m = [](double, double) { return 800.0; };
    auto table = tables::make(fields, 17, 20.0, id);
    table->psi[0] = 0.153F;
    table->psi[1] = 0.036F;
    table->psi[3] = 0.456F;
    pal_table_seal(table.get());
    return table;
}

class Bench {
public:
    /// A new loop behind a host that is well.
    explicit Bench(pal_link& link) : link_(&link) {
        pal_link_store(&link_->host.enable, 1);
        pal_device device{};
        device.context = &device_;
        device.collect = collect;
        device.send = send;
        pal_loop_config config = pal_loop_config_default();
        config.ramp_ticks = 0;
        pal_session_begin(&session, link_, &device, &config, no_time);
    }

    /// The next reply comes from there (workspace frame).
    void move(double x_m, double y_m, double z_m) {
        const float* centre = session.config.centre_m;
        const float at_m[3] = {static_cast<float>(x_m) + centre[0], static_cast<float>(y_m) + centre[1],
                               static_cast<float>(z_m) + centre[2]};
        float theta_rad[3];
        pal_drive counts{};
        if (!pal_delta_inverse(session.config.delta, at_m, theta_rad)) return;
        for (int i = 0; i < 3; ++i) {
            (void)pal_delta_counts(session.config.delta, theta_rad[i], &counts.motor_counts[i]);
        }
        pal_wire_encode(&counts, device_.reply.data());
        device_.reply[13] = 0x41 + 0x70;  // all arms homed
    }

    pal_session_end tick() {
        pal_link_store(&link_->host.heartbeat, n_ticks_ + 1U);
        pal_session_time when{};
        when.t_ns = 1000000ULL * ++n_ticks_;
        return pal_session_tick(&session, &when);
    }

    /// Motor words of the last request.
    [[nodiscard]] std::array<int, 3> words() const {
        pal_sense sense{};  // both directions write words alike
        std::array<std::uint8_t, PAL_WIRE_BYTES> packet = device_.request;
        packet[13] = 0x41;
        if (!pal_wire_decode(packet.data(), &sense)) return {1 << 20, 1 << 20, 1 << 20};
        return {sense.encoder_counts[0], sense.encoder_counts[1], sense.encoder_counts[2]};
    }

    /// |force| at the hand of those words, N: J' tau.
    [[nodiscard]] double force_n() const {
        float jacobian[9];
        const auto word = words();
        if (word == std::array<int, 3>{}) return 0.0;
        const pal_delta* delta = session.config.delta;
        if (!pal_delta_jacobian(delta, session.loop.position_m, jacobian))
            return static_cast<double>(INFINITY);
        double sum = 0.0;
        for (std::size_t c = 0; c < 3; ++c) {
            double part = 0.0;
            for (std::size_t i = 0; i < 3; ++i) {
                part += static_cast<double>(jacobian[3 * i + c]) * word[i] /
                        static_cast<double>(delta->units_per_n_m);
            }
            sum += part * part;
        }
        return std::sqrt(sum);
    }

    /// True when the last tick did no more than it may: words within the motors' range, the force within its
    /// limit (and the rounding of three words, 0.01 N), every number that it keeps or records finite.
    [[nodiscard]] bool is_safe() const {
        for (const int word : words()) {
            if (std::abs(word) > session.config.delta->motor_max) return false;
        }
        if (!(force_n() <= static_cast<double>(session.config.force_max_n) + 0.01)) return false;
        const pal_loop& loop = session.loop;
        bool ok = std::isfinite(loop.fade_work_j) && std::isfinite(loop.hand_work_j);
        for (const pal_touch* touch : {&loop.touch, &loop.before}) {
            ok = ok && std::isfinite(touch->potential_j) && std::isfinite(touch->depth_m) &&
                 std::isfinite(touch->k_n_per_m);
            for (const float f : touch->force_n) ok = ok && std::isfinite(f);
        }
        for (const float f : loop.commanded_n) ok = ok && std::isfinite(f);
        return ok;
    }

    pal_session session{};

private:
    pal_link* link_;
    Device device_;
    std::uint32_t n_ticks_ = 0;
};

}  // namespace hostile
