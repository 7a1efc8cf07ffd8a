#include "host/app/scratch.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

#include "host/link/orphan.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

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
    const fs::path in = fs::temp_directory_path();
    remove_orphans(in);
    std::string name = (in / (link::owner_prefix() + std::to_string(getpid()) + "-XXXXXX")).string();
    if (mkdtemp(name.data()) == nullptr) {
        throw std::runtime_error(name +
                                 ": cannot create a scratch folder; set TMPDIR to one that can be written");
    }
    path_ = name;
}

Scratch::~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

}  // namespace palpate::app
