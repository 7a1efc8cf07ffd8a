/// Programs as people and other programs start them. Nothing here asserts a time: each wait ends with what it
/// waits for, and ctest's own limit ends a test that hangs.
#pragma once
#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace palpate::test {

/// A folder with a short name (socket paths have 100 bytes), gone with the test; `tmp` in it is the programs'
/// TMPDIR.
class Folder {
public:
    Folder();
    ~Folder();
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }
    [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

private:
    std::filesystem::path path_;
};

std::string text_of(const std::filesystem::path& file);
void write_text(const std::filesystem::path& file, const std::string& text);
nlohmann::json json_of(const std::filesystem::path& file);

/// Every file below `folder` with its bytes.
std::map<std::string, std::string> files_below(const std::filesystem::path& folder);

/// A running program, its stdout and stderr kept in `folder`. Killed when the test forgets it.
class Program {
public:
    Program(const std::string& program, const std::vector<std::string>& arguments, const Folder& folder);
    ~Program();
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;
    void send(int signal) const;
    /// The exit code; minus the signal where one ended it.
    int wait();
    [[nodiscard]] bool running();
    [[nodiscard]] pid_t pid() const { return pid_; }
    [[nodiscard]] std::string out() const { return text_of(out_); }
    [[nodiscard]] std::string err() const { return text_of(err_); }

private:
    pid_t pid_ = -1;
    bool ended_ = false;
    int code_ = 0;
    std::filesystem::path out_, err_;
};

struct Outcome {
    int code;
    std::string out, err;
};
Outcome call(const std::string& program, const std::vector<std::string>& arguments, const Folder& folder);

/// A pause between two looks at something that another program does.
void look_again();

/// From now on the children of a killed child become this process's own: their ends can be waited for.
void adopt_orphans();
/// How an adopted process ended; as Program::wait.
int wait_for_orphan(pid_t pid);
/// Whether this process has no child left, running or ended.
bool no_children();
/// The child of `parent` that runs program `name`; 0 when there is none.
pid_t child_of(pid_t parent, const std::string& name);

/// Shared-memory segments whose name holds the process id of `owner`.
std::vector<std::string> segments_of(pid_t owner);
/// What lies in the folder's TMPDIR.
std::vector<std::string> scratch_in(const Folder& folder);

/// What the simulated Falcon of the run in `folder` says of itself; null while nobody answers.
nlohmann::json device_status(const Folder& folder);
/// No motor word, no torque, no force.
bool motors_at_rest(const nlohmann::json& status);

}  // namespace palpate::test
