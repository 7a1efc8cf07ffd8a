#include "host/link/orphan.hpp"

#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>

namespace palpate::link {

std::string owner_prefix() {
    return "palpate-" + std::to_string(getuid()) + "-";
}

bool owner_is_gone(std::string_view name) {
    const std::string prefix = owner_prefix();
    if (!name.starts_with(prefix)) return false;
    name.remove_prefix(prefix.size());
    pid_t pid = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), pid);
    const bool whole = end == name.data() + name.size() || *end == '-';
    return error == std::errc{} && whole && pid > 0 && kill(pid, 0) != 0 && errno == ESRCH;
}

}  // namespace palpate::link
