// palpate run on a Falcon on the USB: real libusb before the simulated device, real processes.
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <fstream>
#include <memory>

#include "host/app/run.hpp"
#include "host/record/record.hpp"
#include "tests/firmware/falcon_script.hpp"
#include "tests/host/app/processes.hpp"
#include "tests/host/app/sheet.hpp"

using namespace palpate;
using namespace palpate::test;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

/// What a user has: a boot image, and here a hand that presses as the sheet's scene says.
struct Desk {
    Desk() {
        const auto image = script::container();
        write_text(folder / "boot.bin", std::string(image.begin(), image.end()));
        const auto world = scene::build(sheet_scene(folder.path()));
        std::ofstream path(folder / "path");
        path << "palpate-path 1\n";
        for (const app::DevicePoint& p : app::device_path(*world)) {
            path << std::llround(1e6 * p.t_s);
            for (const double at_m : p.at_m) path << ' ' << std::llround(1e6 * at_m);
            path << '\n';
        }
    }
    [[nodiscard]] Outcome run(std::vector<std::string> more) const {
        std::vector<std::string> words{"run",
                                       "--grip",
                                       "firm",
                                       "--path",
                                       (folder / "path").string(),
                                       "--",
                                       PAL_PALPATE_PROGRAM,
                                       "run",
                                       write_sheet(folder.path()),
                                       "--out",
                                       (folder / "result").string()};
        words.insert(words.end(), more.begin(), more.end());
        return call(PAL_FALCON_SIM_PROGRAM, words, folder);
    }

    Folder folder;
};

/// A run with the motors under force, until a person or a fault ends it.
struct Felt {
    Felt() {
        simulator = std::make_unique<Program>(
            PAL_FALCON_SIM_PROGRAM,
            std::vector<std::string>{"run", "--bus", bus(), "--grip", "firm", "--path",
                                     (desk.folder / "path").string(), "--watchdog-ms", "60000", "--",
                                     PAL_PALPATE_PROGRAM, "run", write_sheet(desk.folder.path()), "--out",
                                     (desk.folder / "result").string(), "--device", "usb", "--firmware",
                                     (desk.folder / "boot.bin").string()},
            desk.folder);
        while (at_rest()) {
            look_again();
            INFO(simulator->err());
            REQUIRE(simulator->running());
        }
        palpate = child_of(simulator->pid(), "palpate");
        REQUIRE(palpate > 0);
    }
    [[nodiscard]] std::string bus() const { return (desk.folder / "bus").string(); }
    [[nodiscard]] Outcome ask(std::vector<std::string> words) const {
        words.insert(words.end(), {"--bus", bus()});
        return call(PAL_FALCON_SIM_PROGRAM, words, desk.folder);
    }
    [[nodiscard]] bool at_rest() const {
        const Outcome status = ask({"status"});
        if (status.code != 0) return true;
        return nlohmann::json::parse(status.out)["devices"][0]["motor_counts"] == nlohmann::json{0, 0, 0};
    }
    [[nodiscard]] nlohmann::json summary() const { return json_of(desk.folder / "result" / "summary.json"); }

    Desk desk;
    std::unique_ptr<Program> simulator;
    pid_t palpate = 0;
};

}  // namespace

TEST_CASE("a Falcon on the USB is booted, homed and felt through, in real time", "[usb]") {
    const Desk desk;
    const Outcome run =
        desk.run({"--device", "usb", "--firmware", (desk.folder / "boot.bin").string(), "--duration", "1.5"});
    INFO(run.err << text_of(desk.folder / "result" / "log.txt"));
    REQUIRE(run.code == 0);
    const nlohmann::json summary = json_of(desk.folder / "result" / "summary.json");
    CHECK(summary["verdict"] == "measured");
    CHECK(summary["clock"] == "real");
    CHECK(summary["n_contact_ticks"] > 0);
    CHECK_THAT(summary["command"].get<std::string>(),
               Contains("run.clock=real --set device.backend=usb --set 'device.firmware=\""));
    const record::Record kept = record::read(desk.folder / "result" / "run.palrec");
    CHECK(kept.header["device"] == "novint-falcon on the USB");
}

TEST_CASE("a Falcon on the USB whose loop is killed under force gets zero force, and the run says so",
          "[usb]") {
    const Felt felt;
    const pid_t loop = child_of(felt.palpate, "palpate-loop");
    REQUIRE(loop > 0);
    kill(loop, SIGKILL);
    while (!felt.at_rest()) look_again();  // long before its own watchdog; or ctest's limit ends this
    CHECK(felt.simulator->wait() == 3);
    const nlohmann::json summary = felt.summary();
    INFO(summary["supervision"]);
    CHECK(summary["failure"] == "palpate-loop ended in mid-run (signal 9); see log.txt");
    CHECK(summary["supervision"]["take_over"]["done"] == true);
    CHECK(summary["supervision"]["take_over"]["words"] == "palpate sent zero force in its place");
}

TEST_CASE("a Falcon on the USB that is lost and stays lost fails the run, also one that a person ends",
          "[usb]") {
    const Felt felt;
    REQUIRE(felt.ask({"fault", "unplug at_s=0 for_s=1000"}).code == 0);
    while (!std::filesystem::exists(felt.desk.folder / "result.partial" / "flight-1.palrec")) {
        look_again();
        REQUIRE(felt.simulator->running());
    }
    kill(felt.palpate, SIGINT);
    CHECK(felt.simulator->wait() == 3);
    const nlohmann::json summary = felt.summary();
    CHECK(summary["verdict"] == "fail");
    CHECK(summary["failure"] == "the device was lost, and forces stayed off to the end; see log.txt");
}

TEST_CASE("a Falcon that is not there, and one without its image, are said so", "[usb]") {
    const Desk desk;
    const Outcome absent =
        desk.run({"--device", "usb:NOBODY", "--firmware", (desk.folder / "boot.bin").string()});
    INFO(absent.err);
    CHECK(absent.code == 3);
    CHECK_THAT(text_of(desk.folder / "result" / "log.txt"), Contains("NOBODY"));
    const Outcome bare = desk.run({"--device", "usb", "--firmware", "/nowhere.bin"});
    INFO(bare.err);
    CHECK(bare.code == 2);
    CHECK_THAT(bare.err, StartsWith("palpate: /nowhere.bin: "));
    const Outcome lockstep = desk.run({"--device", "usb", "--clock", "virtual"});
    CHECK(lockstep.code == 2);
    CHECK_THAT(lockstep.err, Contains("run.clock = \"real\" is expected"));
    const Outcome unknown = desk.run({"--device", "bluetooth"});
    CHECK(unknown.code == 2);
    CHECK_THAT(unknown.err, Contains("usb:SERIAL is expected, not bluetooth"));
}
