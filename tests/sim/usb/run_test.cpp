// palpate-falcon-sim run and env: what a program gets, and what becomes of it.
#include <sys/stat.h>

#include <array>
#include <fstream>

#include "tests/sim/usb/process.hpp"

using Catch::Contains;
using namespace usbtest;

namespace {

/// A new folder, gone with this.
struct Folder {
    std::string path = "/tmp/pal-run-XXXXXX";
    Folder() { REQUIRE(mkdtemp(path.data()) != nullptr); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder() { std::filesystem::remove_all(path); }
};

/// A shell's words in this folder.
Outcome shell(const std::string& script) {
    return call({"sh", "-c", "export ASAN_OPTIONS=verify_asan_link_order=0; " + script});
}

/// Runs or is a zombie: false when it has ended.
bool lives(pid_t pid) {
    std::ifstream status("/proc/" + std::to_string(pid) + "/stat");
    std::string number;
    std::string name;
    char state = 'X';
    status >> number >> name >> state;
    return state != 'X' && state != 'Z';
}

TEST_CASE("the program may go to another folder though the bus was named from this one", "[process]") {
    const Folder folder;
    const std::string plain = client("sim_usb_plain") + " 1";
    const Outcome outcome = shell("cd " + folder.path + " && " + kProgram +
                                  " run --timing immediate --bus here -- sh -c 'cd / && " + plain + "'");
    CHECK(outcome.words == "plain: 1 exchanges\n");
    CHECK(outcome.code == 0);
}

TEST_CASE("a bus whose whole path is too long for a socket is refused with the path", "[process]") {
    const Folder folder;
    const std::string deep = folder.path + "/" + std::string(80, 'd');
    REQUIRE(std::filesystem::create_directory(deep));
    const Outcome outcome = shell("cd " + deep + " && " + kProgram + " run --bus here -- true");
    CHECK(outcome.code == 3);
    CHECK_THAT(outcome.words, Contains(deep + "/here: too long") && Contains("at most 80 bytes"));
    CHECK_FALSE(std::filesystem::exists(deep + "/here"));
}

TEST_CASE("env is for any shell: whole paths, quotes, and what LD_PRELOAD was before", "[process]") {
    const Folder folder;
    Process served({kProgram, "serve", "--usb", "--timing", "immediate", "--bus", folder.path + "/it's"});
    REQUIRE(served.read_until("eval"));
    const std::string env = "cd " + folder.path + " && eval \"$(" + kProgram + " env --bus \"it's\")\"";
    CHECK(shell(env + "; cd /; exec " + client("sim_usb_plain") + " 1").words == "plain: 1 exchanges\n");
    const Outcome twice =
        shell("LD_PRELOAD=" + kPreload + " " + kProgram + " env --bus \"" + folder.path + "/it's\"");
    CHECK_THAT(twice.words, Contains("export LD_PRELOAD='" + kPreload + "'\n"));
    const Outcome after =
        shell("LD_PRELOAD=libdl.so.2 " + kProgram + " env --bus \"" + folder.path + "/it's\"");
    CHECK_THAT(after.words, Contains("export LD_PRELOAD='libdl.so.2:" + kPreload + "'\n"));
    served.send(SIGTERM);
    CHECK(served.wait() == 0);
}

TEST_CASE("--help after the program is the program's", "[process]") {
    const Outcome its = simulator({"run", "--timing=immediate", "sh", "-c", "echo \"$0\"", "--help"});
    CHECK(its.words == "--help\n");
    CHECK(its.code == 0);
    const std::string before = GENERATE(as<std::string>{}, "--help", "-h");
    CHECK_THAT(simulator({"run", "--running", before, "sh"}).words, Contains("Example:"));
    CHECK_THAT(simulator({"status", before}).words, Contains("Example:"));
}

TEST_CASE("a program does not outlive the run that was killed", "[process]") {
    const std::string folder = bus_folder();
    Process outer({kProgram, "run", "--bus", folder, "--", "sh", "-c", "echo I am $$.; exec sleep 1000"});
    REQUIRE(outer.read_until("."));
    const auto program = static_cast<pid_t>(std::stol(outer.so_far().substr(5)));
    REQUIRE(lives(program));
    outer.send(SIGKILL);
    CHECK(outer.wait() == 128 + SIGKILL);
    for (int ms = 0; ms < kLimitMs && (lives(program) || std::filesystem::exists(folder)); ++ms)
        poll(nullptr, 0, 1);
    CHECK_FALSE(lives(program));
    CHECK_FALSE(std::filesystem::exists(folder));
}

TEST_CASE("where LD_PRELOAD cannot name the library, run says so", "[process]") {
    const Folder folder;
    const std::string place = folder.path + "/a b";
    REQUIRE(std::filesystem::create_directory(place));
    std::filesystem::copy_file(kProgram, place + "/palpate-falcon-sim");
    std::filesystem::copy_file(kPreload, place + "/" + std::filesystem::path(kPreload).filename().string());
    const Outcome outcome = call({place + "/palpate-falcon-sim", "run", "--", "true"});
    CHECK(outcome.code == 3);
    CHECK_THAT(outcome.words, Contains("a folder without spaces and colons"));
}

}  // namespace
