/// One line on a terminal that tells how far long work is.
#pragma once
#include <chrono>
#include <string>

namespace palpate::app {

/// Rewrites its line at most ten times a second where stderr is a terminal; elsewhere it prints only the last
/// state of each phase. Silent when told to be.
class Progress {
public:
    explicit Progress(bool quiet);
    ~Progress();
    void show(const std::string& line);
    /// Leaves the present line as it stands: what others print begins on a line of its own.
    void leave();
    /// Puts `line` in the place of the present one and goes to the next.
    void done(const std::string& line);

private:
    bool quiet_, terminal_;
    std::chrono::steady_clock::time_point last_;
    std::size_t width_ = 0;
};

}  // namespace palpate::app
