#include "host/app/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <iostream>

namespace palpate::app {

Progress::Progress(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
    leave();
}

void Progress::leave() {
    if (width_ != 0) std::cerr << '\n';
    width_ = 0;
}

void Progress::show(const std::string& line) {
    const auto now = std::chrono::steady_clock::now();
    if (quiet_ || !terminal_ || now - last_ < std::chrono::milliseconds(100)) return;
    last_ = now;
    std::cerr << '\r' << line << std::string(width_ > line.size() ? width_ - line.size() : 0, ' ')
              << std::flush;
    width_ = std::max(width_, line.size());
}

void Progress::done(const std::string& line) {
    if (quiet_) return;
    if (width_ != 0) std::cerr << '\r' << std::string(width_, ' ') << '\r';
    width_ = 0;
    std::cerr << line << std::endl;
}

}  // namespace palpate::app
