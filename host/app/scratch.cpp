#include "host/app/scratch.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>

#include "host/link/orphan.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t PATH_BYTES_MAX =
    80;  // a socket in it has 107 (unix(7)), the longest name is falcon.control

bool is_own_folder(const fs::path& path) {
    struct stat found {};
    return lstat(path.c_str(), &found) == 0 && S_ISDIR(found.st_mode) && found.st_uid == getuid();
}

void remove_orphans(const fs::path& in) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(in, ignored)) {
        if (!link::owner_is_gone(entry.path().filename().string()) || !is_own_folder(entry.path())) continue;
        fs::remove_all(entry.path(), ignored);
    }
}

}  // namespace

Scratch::Scratch() {
    const char* said = std::getenv("TMPDIR");
    const fs::path in = said != nullptr && *said != '\0' ? said : "/tmp";
    remove_orphans(in);
    std::string name = (in / (link::owner_prefix() + std::to_string(getpid()) + "-XXXXXX")).string();
    if (name.size() > PATH_BYTES_MAX) {
        throw ScratchError(in.string() + ": too long for the sockets of a run in real time by " +
                           std::to_string(name.size() - PATH_BYTES_MAX) +
                           " bytes; set TMPDIR to a shorter one");
    }
    if (mkdtemp(name.data()) == nullptr) {
        throw ScratchError(in.string() + ": no scratch folder can be made here (" +
                           std::generic_category().message(errno) +
                           "); set TMPDIR to one that can be written");
    }
    path_ = name;
}

Scratch::~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

}  // namespace palpate::app
