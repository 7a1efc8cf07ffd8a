// The simulated Falcon as a process. Nothing here asserts a time: each wait ends with what it waits for.
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/sim/process.hpp"

namespace {

const std::string kProgram = PAL_FALCON_SIM_PROGRAM;
const std::string kSocket = "/tmp/pal-sim-test-" + std::to_string(getpid());

/// The simulator with these words, which are parted by spaces.
usbtest::Outcome call(const std::string& arguments) {
    std::istringstream words(arguments);
    std::vector<std::string> argv{kProgram};
    for (std::string word; words >> word;) argv.push_back(word);
    return usbtest::call(argv);
}

int connect_to(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
    close(fd);
    return -1;
}

class Served {
public:
    explicit Served(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {kProgram, "serve", "--socket", kSocket});
        std::vector<char*> argv;
        argv.reserve(arguments.size() + 1);
        for (auto& argument : arguments) argv.push_back(argument.data());
        argv.push_back(nullptr);
        pid_ = fork();
        REQUIRE(pid_ >= 0);
        if (pid_ == 0) {
            execv(kProgram.c_str(), argv.data());
            _exit(127);
        }
        for (int tries = 0; control_ < 0 && tries < 2000000 && kill(pid_, 0) == 0; ++tries) {
            control_ = connect_to(kSocket + ".control");
        }
        REQUIRE(control_ >= 0);
    }
    Served(const Served&) = delete;
    Served& operator=(const Served&) = delete;
    ~Served() {
        if (pid_ > 0) {
            kill(pid_, SIGKILL);
            waitpid(pid_, nullptr, 0);
        }
        close(control_);
        unlink(kSocket.c_str());
        unlink((kSocket + ".control").c_str());
    }
    std::string ask(const std::string& word) const {
        char answer[1024] = "";
        if (send(control_, word.data(), word.size(), MSG_NOSIGNAL) < 0) return "";
        const ssize_t n = recv(control_, answer, sizeof answer - 1, 0);
        return n > 0 ? std::string(answer, static_cast<std::size_t>(n)) : "";
    }
    /// Asks until the status holds `piece`; false when the process is gone.
    bool wait_for(const std::string& piece) const {
        while (true) {
            const std::string status = ask("status");
            if (status.empty()) return false;
            if (status.find(piece) != std::string::npos) return true;
        }
    }
    int end(int signal) {
        if (signal != 0) kill(pid_, signal);
        int status = 0;
        waitpid(pid_, &status, 0);
        pid_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }

private:
    pid_t pid_ = -1;
    int control_ = -1;
};

bool left_behind() {
    return std::filesystem::exists(kSocket) || std::filesystem::exists(kSocket + ".control");
}

std::string path_file(const std::string& text) {
    std::string name = std::string(PAL_TEST_FOLDER) + "/path.txt";
    std::ofstream(name) << text;
    return name;
}

/// The whole number that a status names so.
long number(const std::string& status, const std::string& name) {
    const std::string key = "\"" + name + "\":";
    const auto at = status.find(key);
    REQUIRE(at != std::string::npos);
    return std::stol(status.substr(at + key.size()));
}

const std::string kPush = "<IODAIODAIODABA>";  // 1000 1000 1000, homing

}  // namespace

TEST_CASE("the process answers packets, and its watchdog lets go when they stop", "[process]") {
    Served process({"--grip", "firm", "--watchdog-ms", "30"});
    const int device = connect_to(kSocket);
    REQUIRE(device >= 0);
    std::string status;
    while (status.find("\"motor_counts\":[1000,1000,1000]") == std::string::npos) {
        REQUIRE(send(device, kPush.data(), kPush.size(), MSG_NOSIGNAL) == 16);
        char reply[64];
        REQUIRE(recv(device, reply, sizeof reply, 0) == 16);
        CHECK(reply[0] == '<');
        CHECK(reply[15] == '>');
        status = process.ask("status");
        REQUIRE_FALSE(status.empty());
    }
    CHECK(status.find("\"motor_torque_n_m\":[-0.238095238,-0.238095238,-0.238095238]") != std::string::npos);
    CHECK(status.find("\"connected\":true") != std::string::npos);
    SECTION("while the host is silent") {}
    SECTION("and when it is gone") {
        close(device);
    }
    CHECK(process.wait_for("\"watchdog\":true"));
    CHECK(process.wait_for("\"motor_torque_n_m\":[0,0,0]"));
    CHECK(process.ask("status").find("\"force_n\":[0,0,0]") != std::string::npos);
    CHECK(process.ask("quit").find("quit") != std::string::npos);
    CHECK(process.end(0) == 0);
    CHECK_FALSE(left_behind());
}

TEST_CASE("the process homes when it is asked to, then the hand follows its path", "[process]") {
    const std::string file = path_file("palpate-path 1\n0 0 0 125000\n50000 1000 -1000 125000\n");
    Served process({"--grip", "firm", "--path", file, "--ramp-ticks", "20", "--seed", "7"});
    const int device = connect_to(kSocket);
    REQUIRE(device >= 0);
    const std::string homing = "<AAAAAAAAAAAABA>";
    char reply[64] = "";
    while (static_cast<unsigned char>(reply[13]) != 'A' + 0x70) {
        REQUIRE(send(device, homing.data(), homing.size(), MSG_NOSIGNAL) == 16);
        REQUIRE(recv(device, reply, sizeof reply, 0) == 16);
    }
    CHECK(process.wait_for("\"homed\":true"));
    CHECK(process.wait_for("\"path_tick\":1"));
    close(device);
    CHECK(process.end(SIGTERM) == 0);
    CHECK_FALSE(left_behind());
}

TEST_CASE("by default the path begins one second after homing", "[process]") {
    Served process({});
    const int device = connect_to(kSocket);
    REQUIRE(device >= 0);
    const std::string homing = "<AAAAAAAAAAAABA>";
    REQUIRE(send(device, homing.data(), homing.size(), MSG_NOSIGNAL) == 16);
    long not_yet = 0;  // the last tick that was seen before homing, and the first after it
    long homed = 0;
    while (homed == 0) {
        const std::string status = process.ask("status");
        REQUIRE_FALSE(status.empty());
        const bool is_homed = status.find("\"homed\":true") != std::string::npos;
        (is_homed ? homed : not_yet) = number(status, "tick");
    }
    std::string status;
    do status = process.ask("status");
    while (!status.empty() && number(status, "path_tick") == 0);
    const long begins = number(status, "tick") - number(status, "path_tick") + 1;
    // The hand learns of homing in the next tick; from then on it waits.
    CHECK(begins - 1000 > not_yet + 1);
    CHECK(begins - 1000 <= homed + 1);
    CHECK(call("--help").words.find("; 1000\n") != std::string::npos);
    close(device);
}

TEST_CASE("without a hand the process homes all the same, and lets go when the path begins", "[process]") {
    Served process({"--grip", "none", "--ramp-ticks", "300"});
    const int device = connect_to(kSocket);
    REQUIRE(device >= 0);
    const std::string homing = "<AAAAAAAAAAAABA>";
    REQUIRE(send(device, homing.data(), homing.size(), MSG_NOSIGNAL) == 16);
    // 5000 ticks are ten times what it takes.
    std::string status;
    do status = process.ask("status");
    while (!status.empty() && number(status, "tick") < 5000 && number(status, "path_tick") < 1000);
    CHECK(status.find("\"homed\":true") != std::string::npos);
    CHECK(number(status, "path_tick") >= 1000);
    const auto at = status.find("\"position_m\":[");
    REQUIRE(at != std::string::npos);
    double x = 0;
    double y = 0;
    REQUIRE(std::sscanf(status.c_str() + at, "\"position_m\":[%lf,%lf", &x, &y) == 2);
    CHECK(y < -0.03);
    close(device);
}

TEST_CASE("a second client is hung up on while the first one stays", "[process]") {
    Served process({});
    const int first = connect_to(kSocket);
    const int second = connect_to(kSocket);
    REQUIRE(first >= 0);
    REQUIRE(second >= 0);
    char reply[64];
    REQUIRE(send(first, kPush.data(), kPush.size(), MSG_NOSIGNAL) == 16);
    CHECK(recv(first, reply, sizeof reply, 0) == 16);
    CHECK(recv(second, reply, sizeof reply, 0) <= 0);
    close(second);
    close(first);
    const int third = connect_to(kSocket);
    REQUIRE(send(third, kPush.data(), kPush.size(), MSG_NOSIGNAL) == 16);
    CHECK(recv(third, reply, sizeof reply, 0) == 16);
    close(third);
}

TEST_CASE("what a killed process left is replaced, what a living one serves is not", "[process]") {
    {
        Served killed({});
        CHECK(killed.end(SIGKILL) == -SIGKILL);
        CHECK(left_behind());
        Served next({});
        const usbtest::Outcome rival = call("serve --socket " + kSocket);
        CHECK(rival.code == 3);
        CHECK(rival.words.find("another process serves it") != std::string::npos);
        const usbtest::Outcome status = call("status --socket " + kSocket);
        CHECK(status.code == 0);
        CHECK(status.words.find("\"watchdog\":") != std::string::npos);
        CHECK(call("quit --socket " + kSocket).code == 0);
        CHECK(next.end(0) == 0);
    }
    CHECK_FALSE(left_behind());
    CHECK(call("status --socket " + kSocket).code == 3);
    const std::string file = path_file("precious\n");
    CHECK(call("serve --socket " + file).code == 3);
    CHECK(std::filesystem::exists(file));
}

TEST_CASE("a bad path is refused with its line and what would be right", "[process]") {
    struct Bad {
        const char* text;
        const char* words;
    };
    const auto bad = GENERATE(values<Bad>(
        {{"", ":1: empty; the first line must be \"palpate-path 1\""},
         {"palpate-path 2\n", ":1: not a path; the first line must be \"palpate-path 1\""},
         {"palpate-path 1\n", ":2: no points"},
         {"palpate-path 1\n0 0 0\n", ":2: not four whole numbers"},
         {"palpate-path 1\n0 0 0 0.12\n", ":2: not four whole numbers"},
         {"palpate-path 1\n0 0 0 nan\n", ":2: not four whole numbers"},
         {"palpate-path 1\n0 0 0 1 2\n", ":2: more than four numbers"},
         {"palpate-path 1\n0 0 0 120000\n0 0 0 120000\n", ":3: time 0 us is not after the line before"},
         {"palpate-path 1\n-1 0 0 120000\n", ":2: time -1 us"},
         {"palpate-path 1\n0 0 9000000 120000\n", ":2: y is 9000000 um"},
         {"palpate-path 1\n0 0 0 99999999999999999999\n", ":2: not four whole numbers"}}));
    const std::string file = path_file(bad.text);
    const usbtest::Outcome outcome = call("serve --socket " + kSocket + " --path " + file);
    CHECK(outcome.code == 2);
    CHECK(outcome.words.find(file + bad.words) != std::string::npos);
    CHECK(std::count(outcome.words.begin(), outcome.words.end(), '\n') == 1);
    CHECK_FALSE(left_behind());
}

TEST_CASE("bad options are refused and help teaches", "[process]") {
    const std::string bad = GENERATE(
        as<std::string>{}, "serve", "serve --socket /tmp/x --grip huge", "serve --socket /tmp/x --grip 1,2",
        "serve --socket /tmp/x --grip 1,2,-3", "serve --socket /tmp/x --watchdog-ms 0",
        "serve --socket /tmp/x --ramp-ticks -1", "serve --socket /tmp/x --nonsense",
        "serve --socket /tmp/x more", "", "sing", "serve --socket /tmp/x --path /no/such/file");
    CHECK(call(bad).code == 2);
    const usbtest::Outcome help = call("--help");
    CHECK(help.code == 0);
    CHECK(help.words.find("Example:") != std::string::npos);
}
