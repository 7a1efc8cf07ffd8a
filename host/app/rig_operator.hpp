/// The Modbus server as the operator of a run.
#pragma once
#include <cmath>
#include <string>

#include "host/app/progress.hpp"
#include "host/app/run.hpp"
#include "host/rig/rig.hpp"

namespace palpate::app {

class RigOperator {
public:
    RigOperator(const std::string& address, Progress& progress) : server_(address, shown_, asked_) {
        progress.done("rig: Modbus TCP on port " + std::to_string(server_.port()) + " (docs/MODBUS.md)");
    }

    [[nodiscard]] std::uint16_t port() const { return server_.port(); }
    [[nodiscard]] Operator as_operator() {
        return {.show = [this](const pal_tick& tick, double rate_hz) { show(tick, rate_hz); },
                .estop = [this] { return asked_.estop.load(); },
                .enable = [this] { return asked_.enable.load(); }};
    }

private:
    void show(const pal_tick& tick, double rate_hz) {
        shown_.state = tick.state;
        shown_.tick = tick.tick;
        shown_.faults = tick.faults;
        shown_.stop = tick.stop;
        shown_.n_missed = tick.n_missed;
        shown_.table_age_ticks = tick.table_age_ticks;
        shown_.rate_hz = static_cast<float>(rate_hz);
        shown_.force_n = std::sqrt(tick.force_n[0] * tick.force_n[0] + tick.force_n[1] * tick.force_n[1] +
                                   tick.force_n[2] * tick.force_n[2]);
        shown_.depth_m = tick.depth_m;
        shown_.k_n_per_m = tick.k_n_per_m;
        shown_.x_m = tick.position_m[0];
        shown_.y_m = tick.position_m[1];
        shown_.z_m = tick.position_m[2];
    }

    rig::Shown shown_;
    rig::Asked asked_;
    rig::Server server_;
};

}  // namespace palpate::app
