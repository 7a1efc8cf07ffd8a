#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <system_error>
#include <vector>

#include "host/record/aside.hpp"

namespace palpate::record {
namespace {

namespace fs = std::filesystem;

constexpr int RESULTS_KEPT = 9;

std::string reason(int error) {
    return std::generic_category().message(error);
}

[[noreturn]] void fail_directory(const fs::path& directory, const std::string& why) {
    throw Error(directory.string() + ": cannot be written (" + why + "); choose another with --out");
}

fs::path with_suffix(fs::path path, const std::string& suffix) {
    path += suffix;
    return path;
}

/// Where `file` lies when it is a symbolic link, which then stays one.
fs::path behind_links(fs::path file) {
    constexpr int LINKS_MAX = 40;  // as many as the kernel follows
    std::error_code error;
    for (int n = 0; n < LINKS_MAX && fs::is_symlink(file, error); ++n) {
        const fs::path next = fs::read_symlink(file, error);
        if (error) break;
        file = file.parent_path() / next;  // `next` alone when it is absolute
    }
    return file;
}

/// Nothing but a result is ever removed.
bool is_result(const fs::path& directory) {
    std::error_code error;
    for (const char* name : {"summary.json", "scene.toml", "run.palrec", "results.json", "latency.json"}) {
        if (fs::exists(directory / name, error)) return true;
    }
    return fs::is_empty(directory, error) && !error;
}

/// What a run in real time wrote of its last ticks, or kept of another's: needed most when that run is dead.
bool is_flight_record(const fs::path& file) {
    const std::string name = file.filename().string();
    const auto begins = [&name](const char* word) { return name.starts_with(word); };
    return name.ends_with(".palrec") && (begins("flight-") || begins("orphan-") || begins("earlier-"));
}

/// Removes all in `directory` but flight records.
void empty_but_for_flights(const fs::path& directory, std::error_code& error) {
    for (const auto& stale : fs::directory_iterator(directory, error)) {
        if (!is_flight_record(stale)) fs::remove_all(stale, error);
    }
}

/// flight-1.palrec becomes earlier-flight-1.palrec: out of the way of the next run's own.
void set_flights_aside(const fs::path& directory, std::error_code& error) {
    std::vector<fs::path> flights;
    for (const auto& file : fs::directory_iterator(directory, error)) {
        if (is_flight_record(file) && !file.path().filename().string().starts_with("earlier-"))
            flights.push_back(file);
    }
    for (const fs::path& file : flights) {
        std::string name = "earlier-" + file.filename().string();
        while (fs::exists(directory / name, error)) name.insert(0, "earlier-");
        fs::rename(file, directory / name, error);
    }
}

}  // namespace

AsideFile::AsideFile(fs::path file)
    : name_(std::move(file)), final_(behind_links(name_)), aside_(with_suffix(final_, ".partial")) {
    std::error_code error;
    const fs::file_status found = fs::status(name_, error);
    if (fs::is_symlink(final_, error)) fail(reason(ELOOP));
    if (fs::is_directory(found)) fail("it is a directory");
    if (fs::exists(found) && !fs::is_regular_file(found)) fail("it is no regular file");
    fd_ = open(aside_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd_ < 0) fail(reason(errno));
}

AsideFile::~AsideFile() {
    if (fd_ >= 0) close(fd_);
    if (!committed_) unlink(aside_.c_str());
}

void AsideFile::add(const void* bytes, std::size_t n_bytes) {
    const char* at = static_cast<const char*>(bytes);
    while (n_bytes > 0) {
        const ssize_t n = ::write(fd_, at, n_bytes);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) fail(reason(n == 0 ? ENOSPC : errno));
        at += n;
        n_bytes -= static_cast<std::size_t>(n);
    }
}

void AsideFile::commit() {
    const int closed = close(fd_);
    fd_ = -1;
    if (closed != 0) fail(reason(errno));
    if (std::rename(aside_.c_str(), final_.c_str()) != 0) fail(reason(errno));
    committed_ = true;
}

void AsideFile::fail(const std::string& why) {
    throw Error(name_.string() + ": cannot be written (" + why + ")");
}

void write_file(const fs::path& file, std::string_view content) {
    AsideFile aside(file);
    aside.add(content.data(), content.size());
    aside.commit();
}

std::string text_in(const fs::path& file) {
    std::ifstream in(file);
    std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    return text;
}

OutputDirectory::OutputDirectory(const fs::path& directory) : final_(directory.lexically_normal()) {
    if (!final_.has_filename()) final_ = final_.parent_path();  // "out/bunny/"
    if (final_.empty() || !final_.has_filename() || final_.filename() == "." || final_.filename() == "..") {
        fail_directory(directory, "a directory of its own is needed");
    }
    partial_ = with_suffix(final_, ".partial");
    std::error_code error;
    if (fs::exists(final_, error) && !fs::is_directory(final_, error)) fail_directory(final_, "it is a file");
    if (fs::exists(final_, error)) (void)free_place();  // said before the work, not after it
    fs::create_directories(partial_, error);
    if (error) fail_directory(final_, error.message());
    lock_ = open(partial_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (lock_ < 0) fail_directory(final_, reason(errno));
    if (flock(lock_, LOCK_EX | LOCK_NB) != 0) {
        close(lock_);
        fail_directory(final_, "another run is writing there");
    }
    empty_but_for_flights(partial_, error);
    if (!error) set_flights_aside(partial_, error);
    if (!error && access(partial_.c_str(), W_OK) == 0) return;
    close(lock_);
    fail_directory(final_, error ? error.message() : reason(EACCES));
}

OutputDirectory::~OutputDirectory() {
    std::error_code ignored;
    if (!committed_) {
        empty_but_for_flights(partial_, ignored);
        fs::remove(partial_, ignored);  // no more than an empty one
    }
    close(lock_);
}

const fs::path& OutputDirectory::path() const {
    return partial_;
}

fs::path OutputDirectory::kept(int n) const {
    std::string suffix = ".";
    return with_suffix(final_, suffix += std::to_string(n));
}

int OutputDirectory::free_place() const {
    std::error_code error;
    int free = 1;
    while (free < RESULTS_KEPT && fs::exists(kept(free), error)) ++free;
    if (fs::exists(kept(free), error) && !is_result(kept(free)))
        fail_directory(final_, kept(free).string() + " is not a result and stays");
    return free;
}

void OutputDirectory::rotate() const {
    const int free = free_place();
    fs::remove_all(kept(free));
    for (int n = free; n > 1; --n) fs::rename(kept(n - 1), kept(n));
    fs::rename(final_, kept(1));
}

void OutputDirectory::commit() {
    try {
        if (fs::exists(final_)) rotate();
        fs::rename(partial_, final_);
    } catch (const fs::filesystem_error& error) {
        fail_directory(final_, error.code().message());
    }
    committed_ = true;
}

}  // namespace palpate::record
