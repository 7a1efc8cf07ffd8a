/// The other programs of a run in real time: palpate-loop, and a simulated Falcon unless a real one was
/// chosen.
#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/app/child.hpp"
#include "host/app/scratch.hpp"
#include "host/link/segment.hpp"

namespace palpate::app {

/// Of --device: empty for sim, usb and usb:SERIAL, else what would be right.
[[nodiscard]] std::string refusal_of_device(const std::string& device);

struct LiveOptions {
    std::string device = "sim";              ///< sim, usb or usb:SERIAL
    std::string firmware, delta;             ///< files for palpate-loop; empty: its own defaults
    std::vector<std::string> sim_arguments;  ///< of palpate-falcon-sim serve: hand, seed
    double force_max_n = 8.0;
    long ramp_ticks = 1000;
    std::vector<std::string> loop_arguments;  ///< more of palpate-loop's: --cpu 1
};

/// Between two looks at the programs of a run.
constexpr auto LOOK_EVERY = std::chrono::milliseconds(2);
/// Until a simulated hand has homed, at most; a person takes the time it takes.
constexpr std::uint32_t HOMING_TICKS_MAX = 10000;

/// What became of a device whose loop died.
struct TakeOver {
    bool done = false;
    double took_s = 0.0;  ///< from noticing to the last packet of zero force
    std::string words;
};

/// Something that the user has to bring for a real device and that is not there or not right, in words.
struct LiveInputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};
/// Throws LiveInputError when a real device is chosen and its boot image cannot be used: asked of
/// palpate-falcon, at once, before anything long begins.
void require_firmware(const LiveOptions& options, const Scratch& scratch);

class Live {
public:
    /// Makes the segment and starts the programs; what they print is appended to `log`. `salvage` sees what
    /// killed runs left; without one that stays for palpate run. Throws ChildError, link::Error.
    Live(LiveOptions options, const Scratch& scratch, std::filesystem::path log,
         const link::Salvage& salvage = nullptr);
    [[nodiscard]] pal_link& link() const { return segment_.link(); }
    [[nodiscard]] const std::string& segment_name() const { return segment_.name(); }
    [[nodiscard]] bool simulated() const { return options_.device == "sim"; }
    /// One look, every LOOK_EVERY or so: which program ended in mid-run or no longer ticks, how and why as
    /// far as is known; empty while all is well. A loop that stands still is killed.
    [[nodiscard]] std::string failure();
    /// After a failure: the device is taken over and sent zero force, unless the loop did so before it ended.
    /// (A real device's loop has a guard besides, which does the same.)
    [[nodiscard]] TakeOver take_over();
    /// Asks the loop to end and waits; false when it did not. Its last packets are zero force.
    [[nodiscard]] bool stop();
    /// What the simulated Falcon says of itself once its motors are off, one JSON line; empty for a real one.
    [[nodiscard]] std::string device_at_rest() const;

private:
    void start_device();
    [[nodiscard]] std::string ask_device() const;
    [[nodiscard]] std::string device_argument() const;
    [[nodiscard]] bool stands_still();

    LiveOptions options_;
    const Scratch* scratch_;
    std::filesystem::path log_;
    link::Segment segment_;
    std::optional<Child> device_, loop_;
    std::uint32_t tick_seen_ = 0;
    int quiet_looks_ = 0;
    bool stood_still_ = false;
};

}  // namespace palpate::app
