/// A folder for the sockets and files of one run in real time.
#pragma once
#include <filesystem>
#include <stdexcept>

namespace palpate::app {

/// There is no place for the folder; the words name TMPDIR.
struct ScratchError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Made in the system's folder for temporary files, gone with the run. What runs that were killed left there
/// is removed first.
class Scratch {
public:
    /// Throws ScratchError.
    Scratch();
    ~Scratch();
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;
    [[nodiscard]] std::filesystem::path operator/(const char* name) const { return path_ / name; }

private:
    std::filesystem::path path_;
};

}  // namespace palpate::app
