// The simulated Falcon on USB for the tests here, and programs that see it.
#pragma once
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/sim/process.hpp"

namespace usbtest {

inline const std::string kProgram = PAL_FALCON_SIM_PROGRAM;
inline const std::string kPreload = PAL_FALCON_PRELOAD;
inline const std::string kClients = PAL_FALCON_CLIENTS;

/// `palpate-falcon-sim` with these arguments.
inline Outcome simulator(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), kProgram);
    return call(std::move(arguments));
}

/// A client under `run`: options first, then "--" and the client.
inline Outcome run(std::vector<std::string> options, const std::vector<std::string>& client) {
    options.insert(options.begin(), "run");
    options.emplace_back("--");
    options.insert(options.end(), client.begin(), client.end());
    return simulator(std::move(options));
}

inline std::string client(const std::string& name) {
    return kClients + "/" + name;
}

inline bool soak() {
    const char* value = std::getenv("PALPATE_SOAK");
    return value != nullptr && std::string(value) == "1";
}

/// A folder name of this process.
inline std::string bus_folder() {
    return "/tmp/pal-usb-test-" + std::to_string(getpid());
}

/// serve --usb, ready.
class Bus {
public:
    explicit Bus(std::vector<std::string> options = {})
        : process_([&options] {
              options.insert(options.begin(), {kProgram, "serve", "--usb", "--bus", bus_folder()});
              return options;
          }()) {
        REQUIRE(process_.read_until("eval"));
    }
    Bus(const Bus&) = delete;
    Bus& operator=(const Bus&) = delete;
    ~Bus() {  // what a simulator that a test killed has left
        process_.send(SIGKILL);
        (void)process_.wait();
        std::filesystem::remove_all(bus_folder());
    }
    Process& process() { return process_; }
    static std::vector<std::string> environment() {
        return {"LD_PRELOAD=" + kPreload, "PALPATE_FALCON_BUS=" + bus_folder(),
                "ASAN_OPTIONS=verify_asan_link_order=0"};
    }

private:
    Process process_;
};

}  // namespace usbtest
