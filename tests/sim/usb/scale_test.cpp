// A simulated delta of another size, end to end: driver and device know each other's geometry by one number.
#include <array>
#include <cmath>
#include <fstream>

#include "tests/firmware/delta_text.hpp"
#include "tests/sim/usb/process.hpp"

using namespace usbtest;

namespace {

using Point = std::array<double, 3>;

/// Files of the driver, gone with this.
class Files {
public:
    Files() { REQUIRE(std::filesystem::create_directory(folder_)); }
    Files(const Files&) = delete;
    Files& operator=(const Files&) = delete;
    ~Files() { std::filesystem::remove_all(folder_); }
    [[nodiscard]] std::string write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ + "/" + name, std::ios::binary) << text;
        return folder_ + "/" + name;
    }
    /// docs/FALCON_CI.md
    [[nodiscard]] std::string image() const {
        using namespace std::string_literals;
        return write("image.bin", "\xAA\x08"s + std::string(16, '\0') +
                                      "\x3F\x00\x02\x80\x01\x00\x3F\x00\x02\x80\x00\x00\x00\x00"s);
    }

private:
    std::string folder_ = bus_folder() + ".files";
};

/// The last place in `words` behind this key, times `unit`.
Point last_point(const std::string& words, const std::string& key, double unit) {
    INFO(words);
    const auto at = words.rfind(key);
    REQUIRE(at != std::string::npos);
    Point point{};
    REQUIRE(std::sscanf(words.c_str() + at + key.size(), "%lf,%lf,%lf", &point[0], &point[1], &point[2]) ==
            3);
    for (double& x : point) x *= unit;
    return point;
}

struct Seen {
    Point told_m, true_m;
    [[nodiscard]] double error_m() const {
        return std::hypot(told_m[0] - true_m[0], told_m[1] - true_m[1], told_m[2] - true_m[2]);
    }
};

/// The driver boots a delta of `scale`, homes it and watches it held still at `held_um`: what it tells and
/// what is true.
Seen watch(const Files& files, double scale, const std::string& held_um,
           const std::vector<std::string>& driver) {
    const std::string path = files.write("path", "palpate-path 1\n0 " + held_um + "\n");
    const Bus bus({"--timing", "immediate", "--grip", "firm", "--ramp-ticks", "100", "--path", path,
                   "--scale", std::to_string(scale)});
    std::vector<std::string> argv{client("palpate-falcon"), "home", "--firmware", files.image()};
    argv.insert(argv.end(), driver.begin(), driver.end());
    Process home(argv, Bus::environment());
    CHECK_THAT(home.words(), Catch::Contains("Homed."));
    CHECK(home.wait() == 0);
    argv[1] = "monitor";
    argv.insert(argv.end(), {"--no-reload", "--json", "--seconds", "1"});
    Process monitor(argv, Bus::environment());
    const std::string told = monitor.words();
    CHECK(monitor.wait() == 0);
    const std::string truth = simulator({"status", "--bus", bus_folder()}).words;
    return {last_point(told, "\"position_m\": [", 1.0), last_point(truth, "\"position_m\":[", 1.0)};
}

TEST_CASE("a delta of another size is driven by its own geometry, and not by a Falcon's", "[process]") {
    struct Row {
        double scale;
        const char* held_um;
    };
    const auto [scale, held_um] = GENERATE(Row{0.5, "10000 -6000 58000"}, Row{1.5, "25000 -20000 170000"});
    CAPTURE(scale);
    const Files files;
    const std::string delta = files.write("delta.toml", deltatext::scaled(scale));
    const Seen own = watch(files, scale, held_um, {"--delta", delta});
    // A count is at most 50 um of a Falcon (docs/PROTOCOL.md 4), three arms may each be half of one off.
    CHECK(own.error_m() < scale * 75e-6);
    CHECK(own.told_m[2] == Approx(scale > 1 ? 0.170 : 0.058).margin(1e-3));  // where the hand holds it
    const Seen built_in = watch(files, scale, held_um, {});
    CHECK(built_in.error_m() > 0.03);
    // By the angles alone it is at the same place of a delta of its own size.
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(scale * built_in.told_m[i] == Approx(built_in.true_m[i]).margin(scale * 75e-6));
    }
}

}  // namespace
