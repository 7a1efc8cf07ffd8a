/// Which system calls one thread of a child makes.
#pragma once
#include <sched.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <map>
#include <optional>

namespace threadtrace {

using Counts = std::map<long, long>;  ///< times, by number

/// The next stop of `thread`; nullopt when it has ended, or after twenty seconds.
inline std::optional<int> next_stop(pid_t thread) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (std::chrono::steady_clock::now() < until) {
        int status = 0;
        const pid_t which = waitpid(thread, &status, WNOHANG | __WALL);
        if (which < 0 || (which == thread && !WIFSTOPPED(status))) return std::nullopt;
        if (which == thread) return status;
        sched_yield();
    }
    return std::nullopt;
}

/// The call that a thread, stopped so, enters; nullopt: it is stopped for something else.
inline std::optional<long> call_entered(pid_t thread, int status) {
    __ptrace_syscall_info info{};
    if (WSTOPSIG(status) != (SIGTRAP | 0x80)) return std::nullopt;
    if (ptrace(PTRACE_GET_SYSCALL_INFO, thread, sizeof info, &info) <= 0) return std::nullopt;
    if (info.op != PTRACE_SYSCALL_INFO_ENTRY) return std::nullopt;
    return static_cast<long>(info.entry.nr);
}

/// The calls of `thread` while more() holds, which is asked at each, from the first sleep on: being stopped
/// for the first time disturbs the one before. nullopt with errno: it cannot be traced.
template <typename More>
std::optional<Counts> calls_of(pid_t thread, More more) {
    if (ptrace(PTRACE_SEIZE, thread, 0, PTRACE_O_TRACESYSGOOD) != 0) return std::nullopt;
    (void)ptrace(PTRACE_INTERRUPT, thread, 0, 0);
    Counts counts;
    bool slept = false;
    while (const std::optional<int> status = next_stop(thread)) {
        const std::optional<long> call = call_entered(thread, *status);
        slept = slept || call == SYS_clock_nanosleep;
        if (call && slept) ++counts[*call];
        if (!more()) break;
        // A signal on its way to the thread goes on; stops of the tracing itself do not.
        const bool delivery = (*status >> 16) == 0 && WSTOPSIG(*status) != (SIGTRAP | 0x80);
        (void)ptrace(PTRACE_SYSCALL, thread, 0, delivery ? WSTOPSIG(*status) : 0);
    }
    (void)ptrace(PTRACE_DETACH, thread, 0, 0);
    return counts;
}

}  // namespace threadtrace
