// Unmodified programs on libusb, libftdi and pyusb see the simulated Falcon through the preload library.
#include <filesystem>
#include <fstream>

#include "tests/sim/usb/process.hpp"

using Catch::Contains;
using namespace usbtest;

namespace {

std::string timing() {
    return GENERATE(as<std::string>{}, "immediate", "frames");
}

TEST_CASE("the program's exit code is passed on", "[process]") {
    CHECK(run({}, {client("sim_usb_probe"), "exit", "0"}).code == 0);
    CHECK(run({}, {client("sim_usb_probe"), "exit", "7"}).code == 7);
    CHECK(run({}, {"sh", "-c", "kill -9 $$"}).code == 128 + SIGKILL);
    const Outcome none = run({}, {"/no/such/program"});
    CHECK(none.code == 127);
    CHECK_THAT(none.words, Contains("name a program after --"));
}

TEST_CASE("a program sees one Falcon, with the texts and numbers of a real one", "[process]") {
    const Outcome list = run({"--serial", "FT123456"}, {client("sim_usb_probe"), "list"});
    CHECK(list.code == 0);
    CHECK_THAT(list.words,
               Contains("0403:cb48 bcd 0600 speed 2 config 1: ") && Contains(", FALCON HAPTIC, FT123456\n"));
}

TEST_CASE("several Falcons have serials that count up", "[process]") {
    const Outcome list = run({"--devices", "3", "--serial", "FTX00009"}, {client("sim_usb_probe"), "list"});
    CHECK(list.code == 0);
    CHECK_THAT(list.words, Contains("FTX00009\n") && Contains("FTX00010\n") && Contains("FTX00011\n"));
}

TEST_CASE("standard requests, stalls, overflow, time-out, cancel, claims and threads are as with a kernel",
          "[process]") {
    const std::string how = timing();
    const std::string what = GENERATE(as<std::string>{}, "standard", "overflow", "timeout", "cancel", "async",
                                      "claims", "threads", "forks");
    CAPTURE(how, what);
    const Outcome probe = run({"--timing", how}, {client("sim_usb_probe"), what});
    CHECK(probe.words.empty());
    CHECK(probe.code == 0);
}

TEST_CASE("a live unplug ends transfers, is told by hot-plug, and the device comes back", "[process]") {
    const std::string how = timing();
    CAPTURE(how);
    const Outcome probe = run({"--timing", how}, {client("sim_usb_probe"), "hotplug", kProgram});
    CHECK(probe.words.empty());
    CHECK(probe.code == 0);
}

TEST_CASE("foreign clients boot the device and exchange packets with it", "[process]") {
    const std::string how = timing();
    const std::string n = soak() ? "3000" : "60";
    CAPTURE(how);
    const Outcome plain = run({"--timing", how}, {client("sim_usb_plain"), n});
    CHECK(plain.words == "plain: " + n + " exchanges\n");
    CHECK(plain.code == 0);
    const Outcome ftdi = run({"--timing", how}, {client("sim_usb_ftdi"), n});
    CHECK(ftdi.words == "ftdi: " + n + " exchanges\n");
    CHECK(ftdi.code == 0);
    const Outcome pyusb = run({"--timing", how}, {PAL_PYTHON, PAL_PYUSB_CLIENT, n});
    CHECK(pyusb.words == "pyusb: " + n + " exchanges\n");
    CHECK(pyusb.code == 0);
}

TEST_CASE("what no source tells about the boot can be switched on", "[process]") {
    // Clients that take no leading byte fail then; one that skips what it does not know does not.
    const Outcome zero = run({"--zero-before-answer"}, {client("sim_usb_plain"), "1"});
    CHECK_THAT(zero.words, Contains("the PIC's answer"));
    const Outcome xoff = run({"--xoff-before-echo"}, {client("sim_usb_plain"), "1"});
    CHECK_THAT(xoff.words, Contains("the ROM's echo"));
}

TEST_CASE("two terminals: serve, env, status, fault, quit", "[process]") {
    Bus bus;
    const std::string folder = bus_folder();
    const Outcome env = simulator({"env", "--bus", folder});
    CHECK(env.code == 0);
    CHECK(env.words == "export PALPATE_FALCON_BUS='" + folder + "'\nexport LD_PRELOAD='" + kPreload + "'\n");
    Process plain({client("sim_usb_plain"), "20"}, Bus::environment());
    CHECK(plain.words() == "plain: 20 exchanges\n");
    CHECK(plain.wait() == 0);
    const Outcome status = simulator({"status", "--bus", folder});
    CHECK_THAT(status.words, Contains("\"present\":true") && Contains("\"running\":true") &&
                                 Contains("\"boots\":1,") && Contains("\"requests\":20,\"replies\":20,"));
    CHECK(simulator({"fault", "unplug at_s=0 for_s=100", "--bus", folder}).words ==
          "{\"fault\":\"unplug\"}\n");
    std::string now;
    do now = simulator({"status", "--bus", folder}).words;
    while (now.find("\"present\":true") != std::string::npos);
    CHECK_THAT(now, Contains("\"present\":false"));
    CHECK(simulator({"heal", "--bus", folder}).code == 0);
    do now = simulator({"status", "--bus", folder}).words;
    while (now.find("\"present\":false") != std::string::npos);
    const Outcome bad = simulator({"fault", "explode", "--bus", folder});
    CHECK(bad.code == 2);
    CHECK_THAT(bad.words, Contains("error"));
    const Outcome rival = simulator({"serve", "--usb", "--bus", folder});
    CHECK(rival.code == 3);
    CHECK_THAT(rival.words, Contains("another simulator serves it"));
    CHECK(simulator({"quit", "--bus", folder}).code == 0);
    CHECK(bus.process().wait() == 0);
    CHECK_FALSE(std::filesystem::exists(folder));
    CHECK(simulator({"status", "--bus", folder}).code == 3);
    CHECK(simulator({"env", "--bus", folder}).code == 3);
}

TEST_CASE("a file of faults strikes when it says, and a bad line is named", "[process]") {
    const std::string file = bus_folder() + ".faults";
    std::ofstream(file) << "# the PIC says nothing once\nboot-fail stage=1\n";
    const Outcome struck = run({"--faults", file}, {client("sim_usb_plain"), "1"});
    CHECK(struck.code == 1);  // this client does not try again
    std::ofstream(file) << "unplug at_s=2 for_s=0.1\nunplug at_s=never\n";
    const Outcome bad = run({"--faults", file}, {client("sim_usb_plain"), "1"});
    CHECK(bad.code == 2);
    CHECK_THAT(bad.words, Contains(file + ": line 2: "));
    std::filesystem::remove(file);
}

TEST_CASE("run leaves nothing behind, also when it is ended from outside", "[process]") {
    const std::string folder = bus_folder();
    Process outer({kProgram, "run", "--bus", folder, "--", "sh", "-c", "echo here; exec sleep 1000"});
    REQUIRE(outer.read_until("here"));
    CHECK(std::filesystem::exists(folder));
    outer.send(SIGTERM);
    CHECK(outer.wait() == 128 + SIGTERM);
    CHECK_FALSE(std::filesystem::exists(folder));
}

TEST_CASE("Ctrl-C is the program's, and the program still has its device", "[process]") {
    const std::string script =
        "trap '" + client("sim_usb_plain") + " 3; exit 9' INT; echo here; while :; do sleep 0.01; done";
    Process outer({"setsid", kProgram, "run", "--", "sh", "-c", script});
    REQUIRE(outer.read_until("here"));
    outer.send_group(SIGINT);
    CHECK_THAT(outer.words(), Contains("plain: 3 exchanges\n"));
    CHECK(outer.wait() == 9);
}

TEST_CASE("a folder that is no bus is left alone", "[process]") {
    const std::string folder = bus_folder();
    std::filesystem::create_directory(folder);
    std::filesystem::create_directory(folder + "/sys");
    const Outcome refused = simulator({"serve", "--usb", "--bus", folder});
    CHECK(refused.code == 3);
    CHECK_THAT(refused.words, Contains("is there and is no bus folder"));
    CHECK(std::filesystem::exists(folder + "/sys"));
    std::filesystem::remove_all(folder);
}

TEST_CASE("bad command lines are refused with one line that says what would be right", "[process]") {
    const auto bad = GENERATE(
        values<std::vector<std::string>>({{"run"},
                                          {"run", "--devices", "9", "--", "true"},
                                          {"run", "--timing", "soon", "--", "true"},
                                          {"run", "--faults", "/no/such/file", "--", "true"},
                                          {"run", "--socket", "/tmp/x", "--", "true"},
                                          {"run", "--serial", "", "--", "true"},
                                          {"run", "--modem-lines", "1", "--", "true"},
                                          {"run", "--scale", "0.2", "--", "true"},
                                          {"run", "--scale", "nan", "--", "true"},
                                          {"run", "--home-deg", "-24", "--", "true"},
                                          {"run", "--faults", "/", "--", "true"},
                                          {"run", "--devices", "3", "--serial", "FALCON", "--", "true"},
                                          {"run", "--devices", "3", "--serial", "F8", "--", "true"},
                                          {"serve", "--usb", "--socket", "/tmp/x"},
                                          {"serve", "--usb", "--port", "1"},
                                          {"serve", "--usb", "more"},
                                          {"usbip", "--port", "70000"},
                                          {"usbip", "--listen", "localhost"},
                                          {"press", "4", "--device", "2"},
                                          {"fault"}}));
    CAPTURE(bad);
    const Outcome refused = simulator(bad);
    CHECK(refused.code == 2);
    CHECK(std::count(refused.words.begin(), refused.words.end(), '\n') == 1);
}

}  // namespace
