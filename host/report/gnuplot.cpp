#include "host/report/gnuplot.hpp"

#include <sys/wait.h>

#include <csignal>
#include <cstdio>

namespace palpate::report {
namespace {

/// A gnuplot that ends before it has read all must not end this program.
class NoPipeSignal {
public:
    NoPipeSignal() : before_(std::signal(SIGPIPE, SIG_IGN)) {}
    ~NoPipeSignal() {
        if (before_ != SIG_ERR) std::signal(SIGPIPE, before_);
    }
    NoPipeSignal(const NoPipeSignal&) = delete;
    NoPipeSignal& operator=(const NoPipeSignal&) = delete;

private:
    void (*before_)(int);
};

}  // namespace

std::string gnuplot_quoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) {
        const bool is_control = (c >= 0 && c < 0x20) || c == 0x7F;  // a line's end would end the quotes too
        out += c == '\'' ? std::string("''") : std::string(1, is_control ? '?' : c);
    }
    return out + "'";
}

std::string run_gnuplot(const std::string& script, const std::string& pictures) {
    const NoPipeSignal no_signal;
    FILE* gnuplot = popen("gnuplot 2>/dev/null", "w");
    if (gnuplot == nullptr) return "gnuplot could not be started; install gnuplot-nox for " + pictures;
    const bool written = std::fwrite(script.data(), 1, script.size(), gnuplot) == script.size();
    const int status = pclose(gnuplot);
    if (status == 0 && written) return "";
    return WIFEXITED(status) && WEXITSTATUS(status) == 127
               ? "gnuplot is not installed; install gnuplot-nox for " + pictures
               : "gnuplot failed; there is no " + pictures;
}

}  // namespace palpate::report
