#include "host/link/segment.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string_view>

#include "host/link/orphan.hpp"

namespace palpate::link {
namespace {

/// Segments of this user whose creator was killed before it could remove them.
void remove_orphans() {
    DIR* directory = opendir("/dev/shm");
    if (directory == nullptr) return;
    while (const dirent* entry = readdir(directory)) {
        const std::string_view name = entry->d_name;
        if (owner_is_gone(name)) shm_unlink(std::string("/").append(name).c_str());
    }
    closedir(directory);
}

}  // namespace

Segment::Segment() : name_(std::string("/").append(owner_prefix()).append(std::to_string(getpid()))) {
    remove_orphans();
    const auto refuse = [this](const char* doing) {
        const std::string reason = std::strerror(errno);
        shm_unlink(name_.c_str());
        throw Error(name_ + ": " + doing + ": " + reason);
    };
    const int fd = shm_open(name_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd < 0) refuse("cannot create the shared segment");
    if (ftruncate(fd, sizeof(pal_link)) != 0) {
        close(fd);
        refuse("cannot size the shared segment");
    }
    void* at = mmap(nullptr, sizeof(pal_link), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, fd, 0);
    close(fd);
    if (at == MAP_FAILED) refuse("cannot map the shared segment");
    link_ = static_cast<pal_link*>(at);
    pal_link_init(link_, static_cast<std::uint32_t>(getpid()));
    pal_link_store(&link_->host.pid, static_cast<std::uint32_t>(getpid()));
}

Segment::~Segment() {
    munmap(link_, sizeof(pal_link));
    shm_unlink(name_.c_str());
}

}  // namespace palpate::link
