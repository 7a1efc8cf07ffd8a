/// Ctrl-C and SIGTERM, once noticed, stay noticed.
#pragma once
#include <stdexcept>

namespace palpate::app {

/// From now on SIGINT and SIGTERM set a flag instead of ending the process; a second one ends it.
void catch_interrupts();
[[nodiscard]] bool interrupted();

/// Leaves long work of which nothing is to be kept.
struct Interrupted : std::runtime_error {
    Interrupted() : std::runtime_error("interrupted") {}
};
/// Throws Interrupted once an interrupt was noticed.
void stop_when_interrupted();

}  // namespace palpate::app
