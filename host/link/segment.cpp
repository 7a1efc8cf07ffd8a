#include "host/link/segment.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "host/link/orphan.hpp"

namespace palpate::link {
namespace {

pal_link* map(int fd) {
    void* at = mmap(nullptr, sizeof(pal_link), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, fd, 0);
    return at == MAP_FAILED ? nullptr : static_cast<pal_link*>(at);
}

void show(const std::string& name, const Salvage& salvage) {
    const int fd = shm_open(name.c_str(), O_RDWR | O_CLOEXEC, 0);
    if (fd < 0) return;
    struct stat found {};
    const bool whole = fstat(fd, &found) == 0 && found.st_size == static_cast<off_t>(sizeof(pal_link));
    pal_link* link = whole ? map(fd) : nullptr;
    close(fd);
    if (link == nullptr) return;
    if (pal_link_check(link, sizeof(pal_link)) == PAL_OK) salvage(name, *link);
    munmap(link, sizeof(pal_link));
}

/// Segments of this user whose creator was killed before it could remove them.
void remove_orphans(const Salvage& salvage) {
    DIR* directory = opendir("/dev/shm");
    if (directory == nullptr) return;
    while (const dirent* entry = readdir(directory)) {
        if (!owner_is_gone(entry->d_name)) continue;
        const std::string name = std::string("/") + entry->d_name;
        show(name, salvage);
        shm_unlink(name.c_str());
    }
    closedir(directory);
}

}  // namespace

Segment::Segment(const Salvage& salvage)
    : name_(std::string("/").append(owner_prefix()).append(std::to_string(getpid()))) {
    if (salvage) remove_orphans(salvage);
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
    link_ = map(fd);
    close(fd);
    if (link_ == nullptr) refuse("cannot map the shared segment");
    pal_link_init(link_, static_cast<std::uint32_t>(getpid()));
    pal_link_store(&link_->host.pid, static_cast<std::uint32_t>(getpid()));
}

Segment::~Segment() {
    munmap(link_, sizeof(pal_link));
    shm_unlink(name_.c_str());
}

}  // namespace palpate::link
