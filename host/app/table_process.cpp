#include "host/app/table_process.hpp"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "host/app/child.hpp"

namespace palpate::app {
namespace {

constexpr useconds_t LOOK_EVERY_US = 1000;
constexpr std::uint64_t ALIVE_EVERY_NS = 100'000'000;
constexpr std::uint64_t HUNG_AFTER_NS =
    3'000'000'000;                       // a table takes 14 ms, and 0.3 s where nothing is solved yet
constexpr std::size_t VAIN_MAX = 5;      // builders in a row that died without a table
constexpr std::size_t FOLLOW_EVERY = 8;  // ticks: as close as a builder at work looks itself
constexpr int GENERATION_SHIFT = 32;     // of ids: a new builder's are above all earlier ones
constexpr int SOCKET_BYTES = 1 << 20;

enum class Kind : std::uint32_t { table, refused, alive, failed };

/// What a message begins with; a table's bytes or words for a person follow.
struct Head {
    Kind kind;
    std::uint32_t n_built, n_refused_places;
    float made_for_m[3];      // refused
    std::uint64_t id, at_ns;  // table
};

/// Ends of an unnamed socket whose messages arrive whole or not at all.
std::array<int, 2> make_sockets() {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0)
        throw ChildError(std::string("no socket for the table builder: ") + std::strerror(errno));
    for (const int end : ends) setsockopt(end, SOL_SOCKET, SO_SNDBUF, &SOCKET_BYTES, sizeof SOCKET_BYTES);
    return ends;
}

/// A copied connection of a rig would stay open when this process's original closes it.
void close_all_but(int file) {
    const auto kept = static_cast<unsigned>(file);
    if (kept > STDERR_FILENO + 1U) close_range(STDERR_FILENO + 1U, kept - 1U, 0);
    close_range(kept + 1U, ~0U, 0);
}

/// The builder's side of one life.
class Builder {
public:
    Builder(const Prepared& prepared, pal_link& link, int socket, std::uint64_t last_id)
        : prepared_(&prepared),
          link_(&link),
          socket_(socket),
          server_(*prepared.world, *prepared.field, prepared.options),
          publisher_(link, last_id) {}

    void follow(std::span<const pal_tick> ticks) {
        for (std::size_t i = 0; i < ticks.size(); i += FOLLOW_EVERY) server_.follow(ticks[i]);
    }

    /// Until the process that forked this one is gone.
    void work(pid_t parent) {
        while (getppid() == parent) {
            if (monotonic_ns() - said_ns_ > ALIVE_EVERY_NS) say(Kind::alive, prepared_->field->why_not());
            if (!newest_record()) {
                usleep(LOOK_EVERY_US);
                continue;
            }
            publish(server_.update(record_));
        }
    }

    void say_failed(const char* why) { say(Kind::failed, why); }

private:
    bool newest_record() {
        const std::uint32_t waiting = pal_state_ring_waiting(&link_->ticks, &reader_);
        if (waiting == 0) return false;
        reader_.next += waiting - 1U;  // only the newest counts
        return pal_state_ring_read(&link_->ticks, &reader_, &record_);
    }

    void publish(std::unique_ptr<pal_table> table) {
        const std::uint64_t at_ns = monotonic_ns();
        const std::size_t n_refused = publisher_.refused().size();
        const pal_table* published =
            table ? publisher_.publish(std::move(table), record_.tick) : publisher_.refresh(record_.tick);
        if (published != nullptr) {
            const record::TableBytes bytes = record::table_bytes(*published);
            Head head = this->head(Kind::table);
            head.id = published->id;
            head.at_ns = at_ns;
            send(head, bytes.data(), bytes.size());
        }
        if (publisher_.refused().size() > n_refused) {
            const link::Refused& refused = publisher_.refused().back();
            Head head = this->head(Kind::refused);
            std::copy(refused.made_for_m.begin(), refused.made_for_m.end(), head.made_for_m);
            send(head, refused.why.data(), refused.why.size());
        }
    }

    [[nodiscard]] Head head(Kind kind) const {
        Head head{};
        head.kind = kind;
        head.n_built = static_cast<std::uint32_t>(server_.n_built());
        head.n_refused_places = static_cast<std::uint32_t>(server_.n_refused());
        return head;
    }

    void say(Kind kind, const std::string& words) { send(head(kind), words.data(), words.size()); }

    void send(const Head& head, const void* rest, std::size_t n_bytes) {
        iovec parts[2] = {{const_cast<Head*>(&head), sizeof head}, {const_cast<void*>(rest), n_bytes}};
        msghdr message{};
        message.msg_iov = parts;
        message.msg_iovlen = 2;
        while (sendmsg(socket_, &message, MSG_NOSIGNAL) < 0 && errno == EINTR) {
        }
        said_ns_ = monotonic_ns();
    }

    const Prepared* prepared_;
    pal_link* link_;
    int socket_;
    table::Server server_;
    link::Publisher publisher_;
    pal_state_reader reader_{};
    pal_tick record_{};
    std::uint64_t said_ns_ = 0;
};

/// From the last tick that was clear of everything, so that the proxy is led in as the tool was.
std::span<const pal_tick> contact_so_far(std::span<const pal_tick> ticks) {
    std::size_t first = ticks.size();
    while (first > 0 && ticks[first - 1].depth_m > 0.0F && ticks[first - 1].table_id != 0) --first;
    constexpr std::size_t APPROACH_TICKS = 200;
    first -= std::min(first, APPROACH_TICKS);
    return ticks.subspan(first);
}

}  // namespace

TableProcess::TableProcess(const Prepared& prepared, pal_link& link) : prepared_(&prepared), link_(&link) {
    start({});
}

TableProcess::~TableProcess() {
    stop();
}

void TableProcess::start(std::span<const pal_tick> ticks) {
    const std::array<int, 2> ends = make_sockets();
    const pid_t parent = getpid();
    const pid_t pid = fork();
    if (pid < 0) {
        close(ends[0]);
        close(ends[1]);
        throw ChildError(std::string("the table builder cannot be started: ") + std::strerror(errno));
    }
    if (pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        prctl(PR_SET_NAME, "palpate-tables");
        setpgid(0, 0);  // Ctrl-C is for the process that watches
        close_all_but(ends[1]);
        Builder builder(*prepared_, *link_, ends[1], generation_ << GENERATION_SHIFT);
        try {
            builder.follow(contact_so_far(ticks));
            builder.work(parent);
        } catch (const std::exception& error) {
            builder.say_failed(error.what());
        }
        _exit(0);  // nothing of the process that it is a copy of may be ended twice
    }
    close(ends[1]);
    pid_ = pid;
    socket_ = ends[0];
    heard_ns_ = monotonic_ns();
}

void TableProcess::take_in() {
    constexpr std::size_t MESSAGE_BYTES = sizeof(Head) + sizeof(pal_table);
    std::vector<std::byte> message(MESSAGE_BYTES);
    for (;;) {
        const ssize_t n = recv(socket_, message.data(), message.size(), MSG_DONTWAIT);
        if (n < static_cast<ssize_t>(sizeof(Head))) return;
        Head head{};
        std::memcpy(&head, message.data(), sizeof head);
        const auto rest = std::span(message).subspan(sizeof head, static_cast<std::size_t>(n) - sizeof head);
        const std::string words(reinterpret_cast<const char*>(rest.data()), rest.size());
        heard_ns_ = monotonic_ns();
        report_.n_built = n_built_before_ + head.n_built;
        report_.n_refused_places = n_refused_before_ + head.n_refused_places;
        if (head.kind == Kind::table) {
            report_.tables[head.id] = record::TableBytes(rest.begin(), rest.end());
            report_.published_ns[head.id] = head.at_ns;
            n_vain_ = 0;
            if (!restarts_.empty() && restarts_.back().served_ns == 0)
                restarts_.back().served_ns = head.at_ns;
        } else if (head.kind == Kind::refused) {
            report_.refused.push_back({{head.made_for_m[0], head.made_for_m[1], head.made_for_m[2]}, words});
        } else if (head.kind == Kind::failed) {
            failure_ = "building a table failed: " + words;
        } else if (!words.empty()) {
            report_.why_no_plate = words;
        }
    }
}

void TableProcess::look(std::span<const pal_tick> ticks) {
    if (pid_ < 0) return;
    take_in();
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) == pid_) {
        take_in();  // what it said last
        pid_ = -1;
        if (failure_.empty()) restart(how_ended(status), ticks);
    } else if (monotonic_ns() - heard_ns_ > HUNG_AFTER_NS) {
        restart("no sign of life for 3 s", ticks);
    }
}

void TableProcess::restart(const std::string& why, std::span<const pal_tick> ticks) {
    stop();
    ++generation_;
    n_built_before_ = report_.n_built;
    n_refused_before_ = report_.n_refused_places;
    if (++n_vain_ > VAIN_MAX) {
        failure_ = "the table builder died " + std::to_string(n_vain_) + " times in a row without a table (" +
                   why + ")";
        return;
    }
    restarts_.push_back({why, ticks.empty() ? 0U : ticks.back().tick, monotonic_ns()});
    start(ticks);
}

void TableProcess::stop() {
    if (pid_ > 0) {
        kill(pid_, SIGKILL);  // it holds nothing that would have to be put down first
        waitpid(pid_, nullptr, 0);
        take_in();
    }
    if (socket_ >= 0) close(socket_);
    pid_ = socket_ = -1;
}

}  // namespace palpate::app
