// palpate doctor on machines made up for it, and on this one.
#include <algorithm>
#include <catch2/catch.hpp>
#include <climits>
#include <sstream>

#include "host/app/doctor.hpp"
#include "tests/host/app/processes.hpp"

using namespace palpate::app;
using Catch::Matchers::Contains;
using nlohmann::json;
using palpate::test::Folder;
using palpate::test::text_of;
using palpate::test::write_text;

namespace {

namespace fs = std::filesystem;

json device(const std::string& access) {
    return {{"serial", "12PZ657E"},          {"product", "FALCON HAPTIC"}, {"node", "/dev/bus/usb/001/007"},
            {"speed_mbit_per_s", 12},        {"access", access},           {"user", "chai (process 7)"},
            {"words", "what to do about it"}};
}

void write_file(const fs::path& file, const std::string& text) {
    fs::create_directories(file.parent_path());
    write_text(file, text);
}

/// A machine on which all is well.
struct Well {
    Well() {
        machine.root = folder.path();
        machine.rtprio_max = 99;
        machine.may_fifo = true;
        machine.memlock_bytes = ULONG_MAX;
        machine.timer_slack_ns = 1;
        machine.kernel = "#1 SMP PREEMPT_RT Debian";
        machine.ask_falcon = [this](const std::vector<std::string>& words) {
            return words.front() == "list" ? list : firmware;
        };
        write_file(folder / "etc/udev/rules.d/60-palpate-falcon.rules",
                   "ATTR{idVendor}==\"0403\", ATTR{idProduct}==\"CB48\"\n");
        write_file(folder / "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n");
    }
    [[nodiscard]] Finding find(const std::string& name) const {
        const std::vector<Finding> findings = examine(machine);
        const auto found =
            std::find_if(findings.begin(), findings.end(), [&](const Finding& f) { return f.name == name; });
        INFO(name);
        REQUIRE(found != findings.end());
        return *found;
    }

    Folder folder;
    Machine machine;
    json list = {{"devices", json::array({device("ok")})}};
    json firmware = {
        {"good", true}, {"path", "/home/u/nvent_firmware.bin"}, {"name", "nvent"}, {"sha256", "11"}};
};

}  // namespace

TEST_CASE("on a machine on which all is well every line is ok and nothing is to be mended") {
    const Well well;
    const std::vector<Finding> findings = examine(well.machine);
    for (const Finding& finding : findings) {
        INFO(finding.name << ": " << finding.words);
        CHECK(finding.health == Health::OK);
        CHECK(finding.mend.empty());
    }
    CHECK(findings.size() == 12);
    CHECK(healthy(findings));
    CHECK(findings_json(findings)["healthy"] == true);
}

TEST_CASE("each thing that is wrong makes its own line bad, with what to do") {
    Well sick;
    std::string name;
    Health health = Health::FAIL;
    SECTION("no udev rule") {
        fs::remove_all(sick.folder / "etc/udev");
        name = "udev rule";
    }
    SECTION("no udev rule, but root") {
        fs::remove_all(sick.folder / "etc/udev");
        sick.machine.is_root = true;
        name = "udev rule";
        health = Health::NOTE;
    }
    SECTION("a rule for another device") {
        write_file(sick.folder / "etc/udev/rules.d/60-palpate-falcon.rules", "ATTR{idVendor}==\"0403\"\n");
        name = "udev rule";
    }
    SECTION("no device") {
        sick.list["devices"] = json::array();
        name = "device";
    }
    SECTION("palpate-falcon is not there") {
        sick.list = nullptr;
        name = "device";
    }
    SECTION("no permission") {
        sick.list["devices"][0] = device("denied");
        name = "permission";
    }
    SECTION("in use") {
        sick.list["devices"][0] = device("busy");
        name = "not in use";
    }
    SECTION("cannot be opened") {
        sick.list["devices"][0] = device("failed");
        name = "opening";
    }
    SECTION("not at full speed") {
        sick.list["devices"][0]["speed_mbit_per_s"] = 480;
        name = "USB speed";
        health = Health::NOTE;
    }
    SECTION("a kernel serial driver holds it") {
        const fs::path port = sick.folder / "sys/devices/usb1/1-1/1-1:1.0/ttyUSB0";
        write_file(port / "latency_timer", "16\n");
        write_file(sick.folder / "sys/devices/usb1/1-1/idVendor", "0403\n");
        write_file(sick.folder / "sys/devices/usb1/1-1/idProduct", "cb48\n");
        fs::create_directories(sick.folder / "sys/bus/usb-serial/devices");
        fs::create_directory_symlink(port, sick.folder / "sys/bus/usb-serial/devices/ttyUSB0");
        name = "latency timer";
        health = Health::NOTE;
    }
    SECTION("no firmware") {
        sick.firmware = {{"good", false}, {"path", "/x"}, {"words", "put it there"}};
        name = "firmware file";
    }
    SECTION("firmware that nobody knows") {
        sick.firmware["name"] = "";
        name = "firmware file";
        health = Health::NOTE;
    }
    SECTION("no real-time priority") {
        sick.machine.may_fifo = false;
        name = "real-time priority";
        health = Health::NOTE;
    }
    SECTION("no locked memory") {
        sick.machine.memlock_bytes = 65536;
        name = "locked memory";
        health = Health::NOTE;
    }
    SECTION("an ordinary kernel") {
        sick.machine.kernel = "#1 SMP PREEMPT_DYNAMIC";
        name = "kernel";
        health = Health::NOTE;
    }
    SECTION("a governor that saves power") {
        write_file(sick.folder / "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave\n");
        name = "CPU frequency";
        health = Health::NOTE;
    }
    SECTION("timer slack") {
        sick.machine.timer_slack_ns = 50000;
        name = "timer slack";
        health = Health::NOTE;
    }
    const Finding finding = sick.find(name);
    CHECK(finding.health == health);
    CHECK_FALSE(finding.mend.empty());
    const std::vector<Finding> findings = examine(sick.machine);
    CHECK(healthy(findings) == (health != Health::FAIL));
    for (const Finding& other : findings) {
        INFO(other.name);
        CHECK((other.name == name || other.health == Health::OK));
    }
}

TEST_CASE("the udev rule is installed by root who says yes, and by nobody else") {
    Well well;
    const fs::path rule = well.folder / "etc/udev/rules.d/60-palpate-falcon.rules";
    fs::remove(rule);
    std::ostringstream out;
    std::istringstream in;
    SECTION("not root") {
        in.str("yes\n");
        CHECK(install_udev(well.machine, in, out) == 1);
        CHECK_THAT(out.str(), Contains("sudo palpate doctor --install-udev"));
        CHECK_FALSE(fs::exists(rule));
    }
    SECTION("no answer, no, y") {
        well.machine.is_root = true;
        in.str(GENERATE(as<std::string>{}, "", "no\n", "y\n", "\n"));
        CHECK(install_udev(well.machine, in, out) == 1);
        CHECK_THAT(out.str(),
                   Contains("This would write " + rule.string()) && Contains("Nothing was changed"));
        CHECK_FALSE(fs::exists(rule));
    }
    SECTION("yes") {
        well.machine.is_root = true;
        in.str("yes\n");
        CHECK(install_udev(well.machine, in, out) == 0);
        CHECK_THAT(text_of(rule),
                   Contains("ATTR{idVendor}==\"0403\", ATTR{idProduct}==\"cb48\"") && Contains("uaccess"));
        CHECK(well.find("udev rule").health == Health::OK);
        std::istringstream nothing;
        CHECK(install_udev(well.machine, nothing, out) == 0);
        CHECK_THAT(out.str(), Contains("is there already"));
    }
}

TEST_CASE("palpate doctor looks at a simulated Falcon and says what is missing", "[device]") {
    const Folder folder;
    const auto doctor = [&](const std::string& firmware) {
        write_text(folder / "none.bin", "");
        return palpate::test::call("/usr/bin/env",
                                   {"PALPATE_FALCON_FIRMWARE=" + firmware, PAL_FALCON_SIM_PROGRAM, "run",
                                    "--timing", "immediate", "--", PAL_PALPATE_PROGRAM, "doctor", "--json"},
                                   folder);
    };
    const auto outcome = doctor((folder / "none.bin").string());
    CHECK(outcome.code == 1);  // at least the firmware fails
    const json document = json::parse(outcome.out);
    CHECK(document["healthy"] == false);
    bool seen = false;
    for (const json& finding : document["findings"]) {
        seen = seen || finding["name"] == "device PALSIM01";
        if (finding["name"] == "firmware file") CHECK(finding["health"] == "fail");
    }
    CHECK(seen);
}
