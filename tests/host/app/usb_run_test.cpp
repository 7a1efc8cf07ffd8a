// palpate run on a Falcon on the USB: real libusb before the simulated device, real processes.
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <fstream>

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
    const Desk desk;
    const std::string bus = (desk.folder / "bus").string();
    Program simulator(PAL_FALCON_SIM_PROGRAM,
                      {"run", "--bus", bus, "--grip", "firm", "--path", (desk.folder / "path").string(),
                       "--watchdog-ms", "60000", "--", PAL_PALPATE_PROGRAM, "run",
                       write_sheet(desk.folder.path()), "--out", (desk.folder / "result").string(),
                       "--device", "usb", "--firmware", (desk.folder / "boot.bin").string()},
                      desk.folder);
    const auto at_rest = [&] {
        const Outcome status = call(PAL_FALCON_SIM_PROGRAM, {"status", "--bus", bus}, desk.folder);
        if (status.code != 0) return true;
        return nlohmann::json::parse(status.out)["devices"][0]["motor_counts"] == nlohmann::json{0, 0, 0};
    };
    while (at_rest()) {
        look_again();
        INFO(simulator.err());
        REQUIRE(simulator.running());
    }
    const pid_t palpate = child_of(simulator.pid(), "palpate");
    REQUIRE(palpate > 0);
    const pid_t loop = child_of(palpate, "palpate-loop");
    REQUIRE(loop > 0);
    kill(loop, SIGKILL);
    while (!at_rest()) look_again();  // long before its own watchdog; or ctest's limit ends this
    CHECK(simulator.wait() == 3);
    const nlohmann::json summary = json_of(desk.folder / "result" / "summary.json");
    INFO(summary["supervision"]);
    CHECK(summary["failure"] == "palpate-loop ended in mid-run (signal 9); see log.txt");
    CHECK(summary["supervision"]["take_over"]["done"] == true);
    CHECK(summary["supervision"]["take_over"]["words"] == "palpate sent zero force in its place");
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
