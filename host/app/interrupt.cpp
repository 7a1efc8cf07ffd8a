#include "host/app/interrupt.hpp"

#include <csignal>
#include <initializer_list>

namespace palpate::app {
namespace {

volatile std::sig_atomic_t seen = 0;

extern "C" void note(int) {
    seen = 1;
}

}  // namespace

void catch_interrupts() {
    struct sigaction action {};
    action.sa_handler = note;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

bool interrupted() {
    return seen != 0;
}

void stop_when_interrupted() {
    if (interrupted()) throw Interrupted();
}

}  // namespace palpate::app
