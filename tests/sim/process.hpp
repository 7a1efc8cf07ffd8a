// Processes for the tests here: each wait ends with what it waits for, or after a limit that no healthy run
// reaches.
#pragma once
#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

namespace usbtest {

constexpr int kLimitMs = 20000;
constexpr int kHung = -1;

/// A child whose output (both streams) is read through a pipe.
class Process {
public:
    explicit Process(std::vector<std::string> argv, const std::vector<std::string>& environment = {}) {
        int ends[2];
        REQUIRE(pipe2(ends, O_CLOEXEC) == 0);
        std::vector<char*> words;
        words.reserve(argv.size() + 1);
        for (auto& word : argv) words.push_back(word.data());
        words.push_back(nullptr);
        pid_ = fork();
        REQUIRE(pid_ >= 0);
        if (pid_ == 0) {
            for (const auto& variable : environment) putenv(const_cast<char*>(variable.c_str()));
            dup2(ends[1], 1);
            dup2(ends[1], 2);
            execvp(words[0], words.data());
            _exit(127);
        }
        close(ends[1]);
        out_ = ends[0];
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;
    ~Process() {
        if (pid_ > 0) {
            kill(pid_, SIGKILL);
            (void)wait();
        }
        close(out_);
    }
    [[nodiscard]] pid_t pid() const { return pid_; }
    void send(int signal_number) const {
        if (pid_ > 0) kill(pid_, signal_number);
    }
    /// As a terminal does: to all of the group that a program under setsid leads.
    void send_group(int signal_number) const {
        if (pid_ > 0) kill(-pid_, signal_number);
    }

    /// Output until a line holds `piece`, or the end. True when it came.
    bool read_until(const std::string& piece) {
        while (words_.find(piece) == std::string::npos) {
            if (!read_more()) return false;
        }
        return true;
    }
    [[nodiscard]] const std::string& so_far() const { return words_; }
    /// Exit code, 128 + signal, or kHung (then it is killed).
    int wait() {
        if (pid_ <= 0) return code_;
        int status = 0;
        for (int ms = 0; waitpid(pid_, &status, WNOHANG) == 0; ++ms) {
            if (ms >= kLimitMs) {
                kill(pid_, SIGKILL);
                waitpid(pid_, &status, 0);
                pid_ = 0;
                return code_ = kHung;
            }
            poll(nullptr, 0, 1);
        }
        pid_ = 0;
        return code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    /// All output; the process has ended or closes its output.
    const std::string& words() {
        while (read_more()) {
        }
        return words_;
    }

private:
    bool read_more() {
        char bytes[4096];
        pollfd news{out_, POLLIN, 0};
        if (poll(&news, 1, kLimitMs) <= 0) return false;
        const ssize_t n = ::read(out_, bytes, sizeof bytes);
        if (n > 0) words_.append(bytes, static_cast<size_t>(n));
        return n > 0;
    }
    pid_t pid_ = 0;
    int out_ = -1, code_ = 0;
    std::string words_;
};

struct Outcome {
    int code;
    std::string words;
};

inline Outcome call(std::vector<std::string> argv) {
    Process process(std::move(argv));
    std::string words = process.words();
    return {process.wait(), std::move(words)};
}

}  // namespace usbtest
