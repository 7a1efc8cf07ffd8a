/// A Modbus client that sends any bytes at all, in any portions.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/rig/rig.hpp"
#include "host/rig/socket.hpp"

namespace palpate::rig::test {

using Bytes = std::vector<std::uint8_t>;

/// "00 01 FF" as bytes.
[[nodiscard]] Bytes hex(const std::string& text);
[[nodiscard]] Bytes operator+(Bytes a, const Bytes& b);

class Client {
public:
    explicit Client(const Server& server) : Client(server.port()) {}
    explicit Client(std::uint16_t port);
    /// False when the server has closed the connection.
    bool send(const Bytes& bytes);
    /// One answer; empty when the server has closed the connection.
    [[nodiscard]] Bytes receive();
    [[nodiscard]] Bytes ask(const Bytes& request);

private:
    bool receive_into(std::uint8_t* bytes, std::size_t n_bytes);
    Fd fd_;
};

/// Something to serve, on a free port.
struct Rig {
    explicit Rig(Limits limits = {}) : server("127.0.0.1:0", shown, asked, limits) {}
    Shown shown;
    Asked asked;
    Server server;
};

/// Limits under which no test machine is too slow to finish a frame.
inline constexpr Limits PATIENT{.n_clients = 16, .frame_timeout_ms = 3'600'000};

}  // namespace palpate::rig::test
