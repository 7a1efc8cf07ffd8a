/// A file descriptor that closes itself, and the address that --rig takes.
#pragma once
#include <unistd.h>

#include <cstdint>
#include <string>
#include <utility>

namespace palpate::rig {

class Fd {
public:
    Fd() = default;
    explicit Fd(int fd) : fd_(fd) {}
    Fd(Fd&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    Fd& operator=(Fd&& other) noexcept {
        std::swap(fd_, other.fd_);
        return *this;
    }
    Fd(const Fd&) = delete;
    Fd& operator=(const Fd&) = delete;
    ~Fd() {
        if (fd_ >= 0) ::close(fd_);
    }
    [[nodiscard]] int get() const { return fd_; }

private:
    int fd_ = -1;
};

struct Endpoint {
    std::string ip;  ///< dotted, in 127.0.0.0/8
    std::uint16_t port = 0;
};

/// Reads ADDR:PORT. Throws Error when it is not that, or not a loopback address.
[[nodiscard]] Endpoint loopback_endpoint(const std::string& address);

}  // namespace palpate::rig
