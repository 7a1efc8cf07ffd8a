#include "host/app/doctor.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "host/app/udev_rule.hpp"
#include "host/latency/machine.hpp"
#include "host/record/record.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr unsigned long LOOP_MEMLOCK_BYTES = 64UL * 1024 * 1024;  // it maps some 20 MB
constexpr unsigned FULL_SPEED_MBIT_PER_S = 12;

std::vector<fs::path> entries_of(const fs::path& folder) {
    std::vector<fs::path> entries;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder, none)) entries.push_back(entry.path());
    std::sort(entries.begin(), entries.end());
    return entries;
}

/// The rules file that names the Falcon; empty when there is none.
fs::path rule_of(const Machine& machine) {
    for (const char* folder : {"etc/udev/rules.d", "run/udev/rules.d", "usr/local/lib/udev/rules.d",
                               "usr/lib/udev/rules.d", "lib/udev/rules.d"}) {
        for (const fs::path& file : entries_of(machine.root / folder)) {
            std::string text = record::text_in(file);
            std::transform(text.begin(), text.end(), text.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
            if (file.extension() == ".rules" && text.find("0403") != std::string::npos &&
                text.find("cb48") != std::string::npos) {
                return file;
            }
        }
    }
    return {};
}

Finding udev_rule(const Machine& machine) {
    const fs::path rule = rule_of(machine);
    if (!rule.empty()) return {"udev rule", Health::OK, rule.string(), ""};
    return {"udev rule", machine.is_root ? Health::NOTE : Health::FAIL,
            machine.is_root ? "none; root may use the Falcon without it, other users may not"
                            : "none: the Falcon's node will belong to root alone",
            "palpate doctor --install-udev"};
}

void look_at_device(const nlohmann::json& device, std::vector<Finding>& findings) {
    const std::string serial = device.value("serial", ""), access = device.value("access", ""),
                      words = device.value("words", ""), user = device.value("user", "");
    const std::string node = device.value("node", "");
    findings.push_back({"device " + serial, Health::OK, device.value("product", "") + " at " + node, ""});
    const bool denied = access == "denied", busy = access == "busy", free = access == "ok";
    if (free || busy || denied) {  // else it is not known
        findings.push_back({"permission", denied ? Health::FAIL : Health::OK,
                            denied ? "this user may not open " + node : "this user may open " + node,
                            denied ? words : ""});
    }
    if (free || busy) {
        findings.push_back(
            {"not in use", busy ? Health::FAIL : Health::OK,
             busy ? "in use by " + (user.empty() ? "another program" : user) : "no other program has it",
             busy ? words : ""});
    }
    if (!free && !denied && !busy) {
        findings.push_back({"opening", Health::FAIL, "it cannot be opened (" + access + ")", words});
    }
    const unsigned speed = device.value("speed_mbit_per_s", 0U);
    if (speed == 0) return;  // the system does not say
    const bool full = speed == FULL_SPEED_MBIT_PER_S;
    findings.push_back({"USB speed", full ? Health::OK : Health::NOTE, std::to_string(speed) + " Mbit/s",
                        full ? "" : "a Falcon runs at 12 Mbit/s; look at what else has its product number"});
}

void look_at_devices(const Machine& machine, std::vector<Finding>& findings) {
    const nlohmann::json list = machine.ask_falcon({"list"});
    if (!list.is_object() || !list.contains("devices")) {
        findings.push_back({"device", Health::FAIL, "palpate-falcon list gives no answer",
                            "palpate-falcon must lie beside palpate; run palpate-falcon list"});
        return;
    }
    const std::string none = list.value("words", "");
    if (!none.empty()) {
        findings.push_back({"device", Health::FAIL, none,
                            "give this machine, or this container, /dev/bus/usb; then palpate-falcon list"});
        return;
    }
    for (const nlohmann::json& device : list["devices"]) look_at_device(device, findings);
    if (list["devices"].empty()) {
        findings.push_back({"device", Health::FAIL, "no Falcon on the USB",
                            "plug in its USB cable and its power supply; without a Falcon: "
                            "palpate-falcon-sim run -- palpate doctor"});
    }
}

/// A kernel serial driver that holds a Falcon has a latency of its own: 16 ms unless told.
Finding latency(const Machine& machine) {
    for (const fs::path& port : entries_of(machine.root / "sys/bus/usb-serial/devices")) {
        std::error_code none;
        const fs::path device = fs::canonical(port, none).parent_path().parent_path();
        if (record::text_in(device / "idVendor") != "0403" || record::text_in(device / "idProduct") != "cb48")
            continue;
        return {"latency timer", Health::NOTE,
                port.filename().string() + " of a kernel serial driver holds it, at " +
                    record::text_in(port / "latency_timer") + " ms",
                "nothing: palpate takes the device over and sets its own; other programs on " +
                    port.filename().string() + " will not"};
    }
    return {"latency timer", Health::OK,
            "set at each start, with the event character; no kernel driver holds the device", ""};
}

Finding firmware(const Machine& machine) {
    const nlohmann::json file = machine.ask_falcon({"firmware"});
    if (!file.is_object()) {
        return {"firmware file", Health::FAIL, "palpate-falcon firmware gives no answer",
                "palpate-falcon must lie beside palpate; run palpate-falcon firmware"};
    }
    const std::string path = file.value("path", ""), name = file.value("name", "");
    if (!file.value("good", false)) {
        return {"firmware file", Health::FAIL, path + ": missing or damaged", file.value("words", "")};
    }
    const std::string digest = file.value("sha256", "");
    if (name.empty()) {
        return {"firmware file", Health::NOTE, path + ": whole, SHA-256 " + digest,
                "it is none of the published images; be sure that it is firmware for the Falcon"};
    }
    return {"firmware file", Health::OK, path + ": " + name, ""};
}

void look_at_rights(const Machine& machine, std::vector<Finding>& findings) {
    findings.push_back({"real-time priority", machine.may_fifo ? Health::OK : Health::NOTE,
                        machine.may_fifo ? "allowed"
                                         : "refused; the limit is " + std::to_string(machine.rtprio_max) +
                                               ", the loop wants " + std::to_string(LOOP_PRIORITY),
                        machine.may_fifo
                            ? ""
                            : "in /etc/security/limits.d/palpate.conf: @plugdev - rtprio 80; log in again"});
    const bool memory = machine.is_root || machine.memlock_bytes >= LOOP_MEMLOCK_BYTES;
    findings.push_back(
        {"locked memory", memory ? Health::OK : Health::NOTE,
         memory ? "allowed" : "limited to " + std::to_string(machine.memlock_bytes / 1024) + " KiB",
         memory ? "" : "in /etc/security/limits.d/palpate.conf: @plugdev - memlock 65536; log in again"});
}

Finding kernel(const Machine& machine) {
    const bool rt = latency::is_real_time_kernel(machine.root, machine.kernel);
    return {"kernel", rt ? Health::OK : Health::NOTE,
            rt ? "PREEMPT_RT" : "not a real-time kernel: " + machine.kernel,
            rt ? ""
               : "on Debian: apt install linux-image-rt-amd64; without it a tick may now and then come late"};
}

Finding governor(const Machine& machine) {
    const std::vector<latency::Governor> all = latency::governors(machine.root);
    const auto slow = std::find_if(all.begin(), all.end(),
                                   [](const latency::Governor& g) { return g.name != "performance"; });
    if (slow == all.end()) {
        return {"CPU frequency", Health::OK,
                all.empty() ? "not changed by Linux here" : "governor performance", ""};
    }
    return {"CPU frequency", Health::NOTE, slow->cpu + ": " + slow->name,
            "cpupower frequency-set -g performance"};
}

Finding timer_slack(const Machine& machine) {
    const bool fine = machine.timer_slack_ns <= 1;
    return {"timer slack", fine ? Health::OK : Health::NOTE,
            fine ? "the loop can set 1 ns" : std::to_string(machine.timer_slack_ns) + " ns and cannot be set",
            fine ? "" : "look for a container or service manager that forbids prctl"};
}

const char* word_of(Health health) {
    return health == Health::OK ? "ok" : health == Health::NOTE ? "note" : "fail";
}

}  // namespace

std::vector<Finding> examine(const Machine& machine) {
    std::vector<Finding> findings{udev_rule(machine)};
    look_at_devices(machine, findings);
    findings.push_back(latency(machine));
    findings.push_back(firmware(machine));
    look_at_rights(machine, findings);
    findings.push_back(kernel(machine));
    findings.push_back(governor(machine));
    findings.push_back(timer_slack(machine));
    return findings;
}

bool healthy(const std::vector<Finding>& findings) {
    return std::none_of(findings.begin(), findings.end(),
                        [](const Finding& finding) { return finding.health == Health::FAIL; });
}

nlohmann::json findings_json(const std::vector<Finding>& findings) {
    nlohmann::json lines = nlohmann::json::array();
    for (const Finding& finding : findings) {
        lines.push_back({{"name", finding.name},
                         {"health", word_of(finding.health)},
                         {"words", finding.words},
                         {"mend", finding.mend}});
    }
    return {{"schema", "palpate.doctor/1"}, {"healthy", healthy(findings)}, {"findings", lines}};
}

int install_udev(const Machine& machine, std::istream& in, std::ostream& out) {
    const fs::path target = machine.root / "etc/udev/rules.d" / UDEV_RULE_NAME;
    if (record::text_in(target) + "\n" == UDEV_RULE) {
        out << target.string()
            << " is there already. If a Falcon still cannot be opened, unplug it and plug it in.\n";
        return 0;
    }
    out << "This would write " << target.string() << ":\n\n"
        << UDEV_RULE << "\nand run:\n"
        << "  udevadm control --reload\n"
        << "  udevadm trigger --subsystem-match=usb --attr-match=idVendor=0403\n";
    if (!machine.is_root) {
        out << "Only root may do that: sudo palpate doctor --install-udev\n";
        return 1;
    }
    out << "Do it? Type yes: " << std::flush;
    std::string answer;
    if (!std::getline(in, answer) || answer != "yes") {
        out << "Nothing was changed.\n";
        return 1;
    }
    std::error_code none;
    fs::create_directories(target.parent_path(), none);
    std::ofstream file(target);
    file << UDEV_RULE << std::flush;
    if (!file) {
        out << target.string() << " cannot be written.\n";
        return 1;
    }
    const bool loaded =
        machine.root == "/" && std::system(
                                   "udevadm control --reload && "
                                   "udevadm trigger --subsystem-match=usb --attr-match=idVendor=0403") == 0;
    out << "Written. " << (loaded ? "" : "udev was not told: restart the machine. ")
        << "Unplug the Falcon and plug it in again.\n";
    return 0;
}

}  // namespace palpate::app
