/// A program started by this one, and always ended with it.
#pragma once
#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace palpate::app {

/// A program beside this one that cannot be started, or that does not do what it is there for.
struct ChildError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// "exit 3" or "signal 9", from what waitpid says.
[[nodiscard]] std::string how_ended(int status);

class Child {
public:
    /// Starts `program` with `arguments`; its stdout and stderr are appended to `log`. Throws
    /// ChildError.
    Child(const std::filesystem::path& program, const std::vector<std::string>& arguments,
          const std::filesystem::path& log);
    /// Sends SIGTERM if it still runs, and SIGKILL when it does not end within a second.
    ~Child();
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    [[nodiscard]] pid_t pid() const { return pid_; }
    /// "exit 3", "signal 9", or nullopt while it runs. Never waits.
    [[nodiscard]] std::optional<std::string> ended();
    /// Waits at most `timeout_ms`; whether it ended.
    bool wait(int timeout_ms);

private:
    pid_t pid_ = -1;
    std::optional<std::string> how_;
};

/// A program beside this one (palpate-loop, palpate-falcon-sim, ...).
[[nodiscard]] std::filesystem::path program_beside(const std::string& name);

}  // namespace palpate::app
