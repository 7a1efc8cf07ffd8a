/// Modbus TCP for test rigs: what the loop does as input registers, the emergency stop as coil 0. One table
/// in code makes the map and docs/MODBUS.md. Loopback only. Its own thread; never in the way of the loop.
#pragma once
#include <atomic>
#include <cstddef>
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

/// What a client asked for; set before the client gets its answer. Coil 0 latches estop: the server never
/// clears it.
struct Asked {
    std::atomic<bool> estop{false};
    std::atomic<bool> enable{true};
};

/// How much of the server clients may hold.
struct Limits {
    std::size_t n_clients = 16;   ///< one more takes the place of the one silent longest; at least 1
    int frame_timeout_ms = 1000;  ///< a client that stops in mid-frame is dropped after this long
};

class Server {
public:
    /// `address` is ADDR:PORT, loopback only (127.0.0.0/8, localhost); port 0 takes a free one. Serves when
    /// this returns. `shown` and `asked` must outlive the server. Throws Error.
    Server(const std::string& address, const Shown& shown, Asked& asked, Limits limits = {});
    /// Closes every connection and joins the thread; waits for no client.
    ~Server();
    /// The port that is listened on.
    [[nodiscard]] std::uint16_t port() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// docs/MODBUS.md, made from the register table.
[[nodiscard]] std::string modbus_markdown();

}  // namespace palpate::rig
