// The command line of palpate-loop, one argument a line: options in their ranges, or one line that says what
// is wrong.
#include <string>
#include <vector>

#include "firmware/app/options.h"
#include "tests/fuzz/input.hpp"

namespace {

using fuzz::require;

fuzz::Reached accepted("options accepted"), complained("complaint");

/// "palpate-loop", then the lines. A zero byte ends an argument, as it does for any program.
std::vector<std::string> arguments_of(std::string_view text) {
    std::vector<std::string> arguments{"palpate-loop"};
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        arguments.emplace_back(std::string(text.substr(0, end)).c_str());
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return arguments;
}

void check(const pal_loop_options& options) {
    accepted.note();
    if (options.help) return;
    require(options.zero == (options.link_name == nullptr));
    require(options.usb == (options.device_path == nullptr));
    require(options.usb || options.device_path[0] != '\0');
    require(!options.usb || options.serial == nullptr || options.serial[0] != '\0');
    require(options.force_max_n > 0.0F && options.force_max_n <= 8.9F);
    require(options.ramp_ticks <= 60000);
    const pal_realtime_choice& realtime = options.realtime;
    require(realtime.priority >= 1 && realtime.priority <= 99);
    require(realtime.cpu == PAL_REALTIME_ANY_CPU || (realtime.cpu >= 0 && realtime.cpu <= 4095));
    require(realtime.cpu == PAL_REALTIME_ANY_CPU || realtime.policy != PAL_POLICY_DEADLINE);
}

void check_complaint(std::string_view complaint) {
    complained.note();
    require(complaint.starts_with("palpate-loop: ") && complaint.find('\n') == complaint.size() - 1);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::vector<std::string> arguments = arguments_of(fuzz::text_of({data, size}));
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    const int argc = static_cast<int>(argv.size());
    argv.push_back(nullptr);
    char* text = nullptr;
    std::size_t n_chars = 0;
    FILE* const complaint = open_memstream(&text, &n_chars);
    require(complaint != nullptr);
    pal_loop_options options;
    const bool good = pal_loop_options_read(argc, argv.data(), &options, complaint);
    require(std::fclose(complaint) == 0);
    if (good) {
        check(options);
        require(n_chars == 0);
    } else {
        check_complaint({text, n_chars});
    }
    std::free(text);
    return 0;
}
