/// Modbus TCP for test rigs: what the loop does as input registers, the emergency stop as coil 0. One table in code
/// makes the map and docs/MODBUS.md. Loopback only. Its own thread; never in the way of the loop.
#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

namespace palpate::rig {

struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// What the registers show. Written by the host at will; each word is atomic on its own.
struct Shown {
    std::atomic<std::uint32_t> state{0}, tick{0}, faults{0}, stop{0}, n_missed{0}, table_age_ticks{0};
    std::atomic<float> rate_hz{0}, force_n{0}, depth_m{0}, k_n_per_m{0};
    std::atomic<float> x_m{0}, y_m{0}, z_m{0};
};

/// What a client asked for. Coil 0 latches estop: writing 0 does not release it.
struct Asked {
    std::atomic<bool> estop{false};
    std::atomic<bool> enable{true};
};

class Server {
public:
    /// `address` is ADDR:PORT, loopback only (127.0.0.0/8, localhost). Listens when this returns. Throws Error.
    Server(const std::string& address, const Shown& shown, Asked& asked);
    ~Server();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// docs/MODBUS.md, made from the register table.
[[nodiscard]] std::string modbus_markdown();

}  // namespace palpate::rig
