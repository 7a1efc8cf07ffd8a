#include "tests/host/app/processes.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace palpate::test {

namespace fs = std::filesystem;

namespace {

constexpr useconds_t LOOK_AGAIN_US = 2000;

int code_of(int status) {
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

/// Name and parent of a process; empty when it is gone.
std::pair<std::string, pid_t> name_and_parent(const std::string& pid) {
    const std::string stat = text_of(fs::path("/proc") / pid / "stat");
    const std::size_t open = stat.find('('), close = stat.rfind(')');
    if (open == std::string::npos || close == std::string::npos) return {"", 0};
    std::istringstream rest(stat.substr(close + 2));
    std::string state;
    pid_t parent = 0;
    rest >> state >> parent;
    return {stat.substr(open + 1, close - open - 1), parent};
}

[[noreturn]] void become(const std::string& program, std::vector<std::string> words, const fs::path& tmp,
                         const fs::path& out, const fs::path& err) {
    setenv("TMPDIR", tmp.c_str(), 1);
    for (const char* display : {"DISPLAY", "WAYLAND_DISPLAY"}) unsetenv(display);
    const int nothing = open("/dev/null", O_RDONLY);
    const int to_out = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    const int to_err = open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    if (dup2(nothing, 0) < 0 || dup2(to_out, 1) < 0 || dup2(to_err, 2) < 0) _exit(126);
    words.insert(words.begin(), program);
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    execvp(program.c_str(), argv.data());
    _exit(127);
}

}  // namespace

Folder::Folder() {
    std::string name = "/tmp/pal-e2e-XXXXXX";
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path_ = name;
    fs::create_directory(path_ / "tmp");
}

Folder::~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

std::string text_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

void write_text(const fs::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
}

nlohmann::json json_of(const fs::path& file) {
    INFO(file);
    const nlohmann::json json = nlohmann::json::parse(text_of(file), nullptr, false);
    REQUIRE_FALSE(json.is_discarded());
    return json;
}

std::map<std::string, std::string> files_below(const fs::path& folder) {
    std::map<std::string, std::string> files;
    if (!fs::exists(folder)) return files;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        files[entry.path().string()] = entry.is_regular_file() ? text_of(entry.path()) : "";
    }
    return files;
}

Program::Program(const std::string& program, const std::vector<std::string>& arguments,
                 const Folder& folder) {
    static int n_started = 0;
    const std::string number = std::to_string(++n_started);
    out_ = folder / ("stdout-" + number);
    err_ = folder / ("stderr-" + number);
    pid_ = fork();
    REQUIRE(pid_ >= 0);
    if (pid_ == 0) become(program, arguments, folder / "tmp", out_, err_);
}

Program::~Program() {
    if (!running()) return;
    send(SIGKILL);
    wait();
}

void Program::send(int signal) const {
    if (!ended_) kill(pid_, signal);
}

int Program::wait() {
    int status = 0;
    if (!ended_ && waitpid(pid_, &status, 0) == pid_) {
        ended_ = true;
        code_ = code_of(status);
    }
    return code_;
}

bool Program::running() {
    int status = 0;
    if (!ended_ && waitpid(pid_, &status, WNOHANG) == pid_) {
        ended_ = true;
        code_ = code_of(status);
    }
    return !ended_;
}

Outcome call(const std::string& program, const std::vector<std::string>& arguments, const Folder& folder) {
    Program started(program, arguments, folder);
    const int code = started.wait();
    return {code, started.out(), started.err()};
}

void look_again() {
    usleep(LOOK_AGAIN_US);
}

void adopt_orphans() {
    REQUIRE(prctl(PR_SET_CHILD_SUBREAPER, 1) == 0);
}

int wait_for_orphan(pid_t pid) {
    int status = 0;
    REQUIRE(waitpid(pid, &status, 0) == pid);
    return code_of(status);
}

bool no_children() {
    return waitpid(-1, nullptr, WNOHANG) < 0 && errno == ECHILD;
}

pid_t child_of(pid_t parent, const std::string& name) {
    constexpr std::size_t COMM_BYTES = 15;  // the kernel keeps no more of a name
    for (const auto& entry : fs::directory_iterator("/proc")) {
        const std::string pid = entry.path().filename().string();
        if (pid.find_first_not_of("0123456789") != std::string::npos) continue;
        const auto [found, its_parent] = name_and_parent(pid);
        if (its_parent == parent && found == name.substr(0, COMM_BYTES)) return std::stoi(pid);
    }
    return 0;
}

std::vector<std::string> segments_of(pid_t owner) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator("/dev/shm")) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with("palpate-") && name.ends_with("-" + std::to_string(owner)))
            names.push_back(name);
    }
    return names;
}

std::vector<std::string> scratch_in(const Folder& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder / "tmp"))
        names.push_back(entry.path().filename().string());
    return names;
}

nlohmann::json device_status(const Folder& folder) {
    for (const std::string& name : scratch_in(folder)) {
        const fs::path socket = folder / "tmp" / name / "falcon";
        const Outcome answer = call(PAL_FALCON_SIM_PROGRAM, {"status", "--socket", socket.string()}, folder);
        if (answer.code == 0) return nlohmann::json::parse(answer.out);
    }
    return nullptr;
}

bool motors_at_rest(const nlohmann::json& status) {
    const nlohmann::json zero = {0, 0, 0};
    return status.at("motor_counts") == zero && status.at("motor_torque_n_m") == zero &&
           status.at("force_n") == zero;
}

}  // namespace palpate::test
