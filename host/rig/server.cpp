// libmodbus opens the port and makes the answers. Its modbus_receive() is not used: a client that stops in
// mid-frame holds it for the byte timeout; and its modbus_reply() is given only requests that frame.cpp found
// answerable: it sleeps for the response timeout (0.5 s) before an exception for an unknown function or a bad
// quantity.
#include <modbus.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>
#include <vector>

#include "host/rig/frame.hpp"
#include "host/rig/map.hpp"
#include "host/rig/rig.hpp"
#include "host/rig/socket.hpp"

namespace palpate::rig {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int BACKLOG = 16;
constexpr auto ACCEPT_REST = std::chrono::milliseconds(100);  // after the process ran out of descriptors

struct ModbusFree {
    void operator()(modbus_t* context) const { modbus_free(context); }
    void operator()(modbus_mapping_t* mapping) const { modbus_mapping_free(mapping); }
};

struct Client {
    Fd fd;
    std::uint64_t heard = 0;  ///< larger: heard from more recently
    std::array<std::uint8_t, FRAME_MAX_BYTES> bytes{};
    std::size_t n_bytes = 0;
    Clock::time_point frame_began{};  ///< when the first of `bytes` came
};

/// Keeps signals for the program's own threads while a thread is started.
class SignalsBlocked {
public:
    SignalsBlocked() {
        sigset_t all;
        sigfillset(&all);
        pthread_sigmask(SIG_SETMASK, &all, &before_);
    }
    ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    SignalsBlocked(const SignalsBlocked&) = delete;
    SignalsBlocked& operator=(const SignalsBlocked&) = delete;

private:
    sigset_t before_{};
};

std::uint16_t port_of(int socket, const std::string& address) {
    sockaddr_in bound{};
    socklen_t n_bytes = sizeof bound;
    if (::getsockname(socket, reinterpret_cast<sockaddr*>(&bound), &n_bytes) != 0) {
        throw Error("cannot find the port of " + address + ": " + std::strerror(errno));
    }
    return ntohs(bound.sin_port);
}

}  // namespace

struct Server::Impl {
    Impl(const std::string& address, const Shown& shown_by_host, Asked& asked_by_clients, Limits given);
    ~Impl();
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void run();
    [[nodiscard]] std::vector<pollfd> watched() const;
    [[nodiscard]] int wait_ms() const;
    void accept_one();
    bool serve(Client& client);
    bool answer(std::span<const std::uint8_t> frame, int socket);
    [[nodiscard]] bool late(const Client& client, Clock::time_point now) const;
    [[nodiscard]] bool estop_latched() const;
    void show();

    const Shown& shown;
    Asked& asked;
    const Limits limits;
    std::unique_ptr<modbus_t, ModbusFree> context;
    std::unique_ptr<modbus_mapping_t, ModbusFree> mapping;
    Fd listener, wake;
    std::uint16_t port = 0;
    std::vector<Client> clients;
    std::uint64_t n_heard = 0;
    bool resting = false;  ///< no descriptor left for another client
    std::thread thread;
};

Server::Impl::Impl(const std::string& address, const Shown& shown_by_host, Asked& asked_by_clients,
                   Limits given)
    : shown(shown_by_host), asked(asked_by_clients), limits(given) {
    const Endpoint endpoint = loopback_endpoint(address);
    context.reset(modbus_new_tcp(endpoint.ip.c_str(), endpoint.port));
    mapping.reset(modbus_mapping_new(N_COILS, 0, 0, N_WORDS));
    if (!context || !mapping)
        throw Error("cannot prepare Modbus for " + address + ": " + modbus_strerror(errno));
    listener = Fd(modbus_tcp_listen(context.get(), BACKLOG));
    if (listener.get() < 0) {
        const char* const hint = errno == EADDRINUSE ? "; another program has this port, give another one"
                                 : errno == EACCES   ? "; ports below 1024 need root, give a higher one"
                                                     : "";
        throw Error("cannot listen on " + address + ": " + std::strerror(errno) + hint);
    }
    port = port_of(listener.get(), address);
    wake = Fd(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
    if (wake.get() < 0) throw Error("cannot serve " + address + ": " + std::strerror(errno));
    const SignalsBlocked blocked;
    thread = std::thread([this] { run(); });
}

Server::Impl::~Impl() {
    if (!thread.joinable()) return;
    eventfd_write(wake.get(), 1);
    thread.join();
}

/// One round: wait, read from each client what is there, drop the late ones, let one new client in. Never
/// waits for a client; a round costs each of them at most one read and the answers to it.
void Server::Impl::run() {
    for (;;) {
        std::vector<pollfd> fds = watched();
        if (::poll(fds.data(), fds.size(), wait_ms()) < 0) {
            if (errno == EINTR || errno == ENOMEM) continue;
            return;
        }
        if (fds[0].revents != 0) return;
        resting = false;
        const Clock::time_point now = Clock::now();
        std::vector<Client> kept;
        for (std::size_t i = 0; i < clients.size(); ++i) {
            const bool alive = fds[i + 2].revents == 0 || serve(clients[i]);
            if (alive && !late(clients[i], now)) kept.push_back(std::move(clients[i]));
        }
        clients = std::move(kept);
        if (fds[1].revents != 0) accept_one();
    }
}

/// The wake-up, the listener, then the clients in their order.
std::vector<pollfd> Server::Impl::watched() const {
    std::vector<pollfd> fds{{wake.get(), POLLIN, 0}, {resting ? -1 : listener.get(), POLLIN, 0}};
    for (const Client& c : clients) fds.push_back({c.fd.get(), POLLIN, 0});
    return fds;
}

/// Until the first unfinished frame is late; -1: no end.
int Server::Impl::wait_ms() const {
    using std::chrono::milliseconds;
    auto wait = milliseconds::max();
    const Clock::time_point now = Clock::now();
    for (const Client& c : clients) {
        if (c.n_bytes == 0) continue;
        const auto due = c.frame_began + milliseconds(limits.frame_timeout_ms);
        wait = std::min(wait, std::max(milliseconds(0), std::chrono::ceil<milliseconds>(due - now)));
    }
    if (resting) wait = std::min(wait, milliseconds(ACCEPT_REST));
    return wait == milliseconds::max() ? -1 : static_cast<int>(wait.count());
}

void Server::Impl::accept_one() {
    Fd fd(::accept4(listener.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (fd.get() < 0) {
        resting = errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM;
        return;
    }
    const int on = 1;
    ::setsockopt(fd.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    if (!clients.empty() && clients.size() >= limits.n_clients) {
        clients.erase(std::min_element(clients.begin(), clients.end(),
                                       [](const Client& a, const Client& b) { return a.heard < b.heard; }));
    }
    clients.push_back(Client{.fd = std::move(fd), .heard = ++n_heard});
}

/// Reads once and answers every frame that is whole. False: the client is to be dropped.
bool Server::Impl::serve(Client& client) {
    std::uint8_t* const bytes = client.bytes.data();
    const ssize_t n =
        ::recv(client.fd.get(), bytes + client.n_bytes, client.bytes.size() - client.n_bytes, 0);
    if (n < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
    if (n == 0) return false;
    client.heard = ++n_heard;
    if (client.n_bytes == 0) client.frame_began = Clock::now();
    client.n_bytes += static_cast<std::size_t>(n);
    std::size_t done = 0;
    for (;;) {
        const std::span<const std::uint8_t> rest(bytes + done, client.n_bytes - done);
        const std::optional<std::size_t> length = frame_bytes(rest);
        if (!length) return false;
        if (*length == 0) break;
        if (!answer(rest.first(*length), client.fd.get())) return false;
        done += *length;
    }
    if (done > 0) {
        std::memmove(bytes, bytes + done, client.n_bytes - done);
        client.n_bytes -= done;
        client.frame_began = Clock::now();
    }
    return true;
}

/// False when the answer could not be sent whole at once: the client does not take its answers.
bool Server::Impl::answer(std::span<const std::uint8_t> frame, int socket) {
    constexpr unsigned ESTOP = 1U << COIL_ESTOP;
    constexpr unsigned ENABLE = 1U << COIL_ENABLE;
    modbus_set_socket(context.get(), socket);
    Verdict verdict = verdict_on(frame, {.n_words = N_WORDS, .n_coils = N_COILS});
    if (verdict == Verdict::Answer) {
        const CoilWrite write = coil_write(frame);
        const bool releases = (write.mask & ESTOP) != 0 && (write.values & ESTOP) == 0;
        if (releases && estop_latched()) {
            verdict = Verdict::IllegalValue;
        } else {
            if ((write.values & ESTOP) != 0) asked.estop = true;
            if ((write.mask & ENABLE) != 0) asked.enable = (write.values & ENABLE) != 0;
        }
    }
    if (verdict != Verdict::Answer) {
        return modbus_reply_exception(context.get(), frame.data(), static_cast<unsigned>(verdict)) > 0;
    }
    show();
    return modbus_reply(context.get(), frame.data(), static_cast<int>(frame.size()), mapping.get()) > 0;
}

bool Server::Impl::late(const Client& client, Clock::time_point now) const {
    return client.n_bytes > 0 &&
           now - client.frame_began >= std::chrono::milliseconds(limits.frame_timeout_ms);
}

bool Server::Impl::estop_latched() const {
    return asked.estop || (shown.stop & PAL_FAULT_ESTOP) != 0;
}

void Server::Impl::show() {
    mapping->tab_bits[COIL_ESTOP] = estop_latched() ? 1 : 0;
    mapping->tab_bits[COIL_ENABLE] = asked.enable ? 1 : 0;
    std::ranges::copy(words(shown), mapping->tab_input_registers);
}

Server::Server(const std::string& address, const Shown& shown, Asked& asked, Limits limits)
    : impl_(std::make_unique<Impl>(address, shown, asked, limits)) {}

Server::~Server() = default;

std::uint16_t Server::port() const {
    return impl_->port;
}

}  // namespace palpate::rig
