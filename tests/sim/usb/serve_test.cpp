// palpate-falcon-sim serve and usbip as processes beside others: folders, sockets, signals.
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <array>
#include <memory>

#include "tests/sim/usb/process.hpp"

using Catch::Contains;
using namespace usbtest;

namespace {

Process usbip(const std::string& port) {
    return Process({kProgram, "usbip", "--port", port, "--bus", bus_folder()});
}

unsigned mode_of(const std::string& path) {
    struct stat found {};
    REQUIRE(lstat(path.c_str(), &found) == 0);
    return found.st_mode & 0777U;
}

TEST_CASE("a bus that an exporter serves is not taken from it", "[process]") {
    Process exporter = usbip("0");
    REQUIRE(exporter.read_until("sudo"));
    for (const char* verb : {"serve --usb", "usbip --port 0"}) {
        const Outcome rival = call({"sh", "-c", kProgram + " " + verb + " --bus " + bus_folder()});
        CHECK(rival.code == 3);
        CHECK_THAT(rival.words, Contains("another simulator serves it"));
    }
    CHECK(simulator({"quit", "--bus", bus_folder()}).code == 0);
    CHECK(exporter.wait() == 0);
    CHECK_FALSE(std::filesystem::exists(bus_folder()));
}

TEST_CASE("an exporter whose TCP port is taken says so and leaves no folder", "[process]") {
    const int taken = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t n_where = sizeof where;
    REQUIRE(bind(taken, reinterpret_cast<const sockaddr*>(&where), sizeof where) == 0);
    REQUIRE(listen(taken, 1) == 0);
    REQUIRE(getsockname(taken, reinterpret_cast<sockaddr*>(&where), &n_where) == 0);
    Process exporter = usbip(std::to_string(ntohs(where.sin_port)));
    CHECK_THAT(exporter.words(), Contains("Address already in use; choose another with --port"));
    CHECK(exporter.wait() == 3);
    CHECK_FALSE(std::filesystem::exists(bus_folder()));
    close(taken);
}

TEST_CASE("an exporter tells the commands for its own port", "[process]") {
    Process exporter = usbip("0");
    REQUIRE(exporter.read_until("-b 1-1\n"));
    const std::string& words = exporter.so_far();
    const auto at = words.find("TCP port ") + 9;
    const std::string port = words.substr(at, words.find('\n', at) - at);
    CHECK_THAT(words, Contains("usbip --tcp-port " + port + " list -r 127.0.0.1\n") &&
                          Contains("usbip --tcp-port " + port + " attach -r 127.0.0.1 -b 1-1\n"));
    exporter.send(SIGTERM);
    CHECK(exporter.wait() == 0);
}

TEST_CASE("a folder that others can write to is no bus", "[process]") {
    const std::string folder = bus_folder();
    std::filesystem::create_directory(folder);
    std::filesystem::create_directory(folder + ".there");
    SECTION("open to all") {
        REQUIRE(chmod(folder.c_str(), 0777) == 0);
    }
    SECTION("a link to elsewhere") {
        std::filesystem::remove(folder);
        std::filesystem::create_directory_symlink(folder + ".there", folder);
    }
    const Outcome refused = simulator({"serve", "--usb", "--bus", folder});
    CHECK(refused.code == 3);
    CHECK_THAT(refused.words, Contains("must be a folder of yours that others cannot write to"));
    CHECK(std::filesystem::is_empty(folder));
    std::filesystem::remove(folder);
    std::filesystem::remove(folder + ".there");
}

TEST_CASE("whatever the umask, sockets are their owner's", "[process]") {
    const std::string place = bus_folder();
    SECTION("of a bus") {
        Process bus({"sh", "-c", "umask 0; exec " + kProgram + " serve --usb --bus " + place});
        REQUIRE(bus.read_until("eval"));
        CHECK(mode_of(place) == 0700);
        for (const char* name : {"/control", "/events", "/dev/bus/usb/001/002"})
            CHECK(mode_of(place + name) == 0600);
        bus.send(SIGTERM);
        CHECK(bus.wait() == 0);
    }
    SECTION("of packets") {
        const Process packets({"sh", "-c", "umask 0; exec " + kProgram + " serve --socket " + place});
        for (int i = 0; i < kLimitMs && simulator({"status", "--socket", place}).code != 0; ++i) {
        }
        CHECK(mode_of(place) == 0600);
        CHECK(mode_of(place + ".control") == 0600);
        CHECK(simulator({"quit", "--socket", place}).code == 0);
    }
}

TEST_CASE("a closed terminal ends it well; what its starter wanted ignored does not", "[process]") {
    const std::string folder = bus_folder();
    const std::string script = GENERATE(as<std::string>{}, "", "trap '' HUP; ", "trap '' INT; ");
    Process bus({"sh", "-c", script + "exec " + kProgram + " serve --usb --bus " + folder});
    REQUIRE(bus.read_until("eval"));
    const int sent = script.empty() || script.find("HUP") != std::string::npos ? SIGHUP : SIGINT;
    bus.send(sent);
    if (!script.empty()) {
        CHECK(simulator({"status", "--bus", folder}).code == 0);
        bus.send(SIGTERM);
    }
    CHECK(bus.wait() == 0);
    CHECK_FALSE(std::filesystem::exists(folder));
}

TEST_CASE("nobody waits for ever for a simulator that was stopped, and nobody takes its place", "[process]") {
    Bus bus;
    bus.process().send(SIGSTOP);
    std::vector<std::unique_ptr<Process>> asks;
    asks.reserve(8);
    for (int i = 0; i < 8; ++i) {
        asks.push_back(
            std::make_unique<Process>(std::vector<std::string>{kProgram, "status", "--bus", bus_folder()}));
    }
    for (const auto& ask : asks) CHECK(ask->wait() == 3);
    const Outcome rival = simulator({"serve", "--usb", "--bus", bus_folder()});
    CHECK(rival.code == 3);
    CHECK_THAT(rival.words, Contains("another simulator serves it"));
    bus.process().send(SIGCONT);
    CHECK(simulator({"status", "--bus", bus_folder()}).code == 0);
}

TEST_CASE("the status is JSON whatever the serial number", "[process]") {
    const Bus bus({"--serial", "A\"B\\C"});
    CHECK_THAT(simulator({"status", "--bus", bus_folder()}).words,
               Contains(R"({"serial":"A\"B\\C","present":true,)"));
}

TEST_CASE("a fault as late as can be said comes as late as it says", "[process]") {
    const Bus bus;
    CHECK(simulator({"fault", "drop at_s=1000000", "--bus", bus_folder()}).words == "{\"fault\":\"drop\"}\n");
}

}  // namespace
