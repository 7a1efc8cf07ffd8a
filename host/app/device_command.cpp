#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iostream>
#include <memory>

#include "host/app/child.hpp"
#include "host/app/commands.hpp"

namespace palpate::app {
namespace {

/// palpate-falcon's help knows only its own commands: a line about the one that is not its.
void say_latency(const std::vector<std::string>& arguments) {
    const std::string first = arguments.empty() ? "" : arguments.front();
    const bool help = first == "--help" || first == "-h" || first == "help";
    if (!help && !first.empty()) return;
    (help ? std::cout : std::cerr)
        << "palpate device latency --help: measures how late the loop and its force "
           "are; all else is palpate-falcon's\n"
        << std::flush;
}

/// Becomes palpate-falcon: the same terminal, the same signals, its exit code.
int become_falcon(const std::vector<std::string>& arguments) {
    const std::filesystem::path program = program_beside("palpate-falcon");
    std::vector<std::string> words{program.string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    argv.reserve(words.size() + 1);
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    execv(program.c_str(), argv.data());
    throw ChildError(program.string() + ": cannot be started: " + std::strerror(errno));
}

}  // namespace

void add_device(CLI::App& palpate, std::function<int()>& chosen) {
    CLI::App* command = palpate.add_subcommand("device",
                                               "a Falcon on the USB: list, firmware, boot, home, monitor, "
                                               "rate, zero, force-check, latency; palpate device --help");
    add_latency(*command, chosen);  // before what follows, which it would take over
    command->set_help_flag();
    command->prefix_command();
    command->require_subcommand(0, 1);
    command->callback([command, &chosen] {
        if (command->got_subcommand("latency")) return;
        const std::vector<std::string> arguments = command->remaining();
        chosen = [arguments] {
            say_latency(arguments);
            return become_falcon(arguments);
        };
    });
}

}  // namespace palpate::app
