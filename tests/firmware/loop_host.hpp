/// The host's side of a link, and a simulated Falcon at a socket whose hand presses on what the host says is
/// there.
#pragma once
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/link.h"
#include "common/state_ring.h"
#include "tests/common/tables.hpp"
#include "tests/sim/usb/process.hpp"

namespace loophost {

using nlohmann::json;
using usbtest::Process;

/// A host that lives as often as it is called: beats, reads all records, keeps a table fresh.
class Host {
public:
    Host() {
        file_ = shm_open(name_.c_str(), O_CREAT | O_EXCL | O_RDWR, 0600);
        REQUIRE(file_ >= 0);
        REQUIRE(ftruncate(file_, sizeof(pal_link)) == 0);
        void* at = mmap(nullptr, sizeof(pal_link), PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
        REQUIRE(at != MAP_FAILED);
        link_ = static_cast<pal_link*>(at);
        pal_link_init(link_, 7);
        pal_link_store(&link_->host.pid, static_cast<std::uint32_t>(getpid()));
        enable(true);
    }
    ~Host() {
        munmap(link_, sizeof(pal_link));
        close(file_);
        shm_unlink(name_.c_str());
    }
    Host(const Host&) = delete;
    Host& operator=(const Host&) = delete;
    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] pal_link& link() { return *link_; }
    [[nodiscard]] int file() const { return file_; }
    void enable(bool on) { pal_link_store(&link_->host.enable, on ? 1 : 0); }
    /// From now on the newest table is a flat skin of 800 N/m in the middle of the workspace.
    void offer_skin() { skin_ = true; }
    /// One look; the newest record stays in newest().
    void look() {
        pal_link_store(&link_->host.heartbeat, ++beat_);
        pal_tick record{};
        while (pal_state_ring_read(&link_->ticks, &reader_, &record)) {
            newest_ = record;
            faults_seen_ |= record.faults;
            if (keep_) kept_.push_back(record);
        }
        if (!skin_ || beat_ % 8 != 0) return;
        const auto table = tables::make({}, 9, 0.0, ++n_tables_);
        std::memcpy(pal_table_ring_back(&link_->tables), table.get(), table->n_bytes);
        pal_table_ring_publish(&link_->tables);
    }
    /// Looks until `condition` holds; false after a limit that no healthy run reaches.
    template <typename Condition>
    bool until(Condition condition) {
        for (int n = 0; n < 8000; ++n) {
            look();
            if (condition()) return true;
            poll(nullptr, 0, 2);
        }
        return false;
    }
    bool comes_to(std::uint32_t state) {
        return until([&] { return newest_.tick != 0 && newest_.state == state; });
    }
    /// The same for forces on, with an operator who switches them off and on after a stop: a busy machine may
    /// have stalled the loop.
    bool is_enabled() {
        return until([&] {
            enable(newest_.state != PAL_STATE_FAULT);
            return newest_.state == PAL_STATE_ENABLED;
        });
    }
    /// A record whose force is that of the skin.
    bool is_pressed() {
        return until([&] { return newest_.state == PAL_STATE_ENABLED && newest_.force_n[2] > 0.5F; });
    }
    void keep(bool on) { keep_ = on; }
    [[nodiscard]] const std::vector<pal_tick>& kept() const { return kept_; }
    [[nodiscard]] const pal_tick& newest() const { return newest_; }
    [[nodiscard]] std::uint32_t faults_seen() const { return faults_seen_; }

private:
    std::string name_ = "/palpate-loop-test-" + std::to_string(getpid());
    int file_ = -1;
    pal_link* link_ = nullptr;
    pal_state_reader reader_{};
    pal_tick newest_{};
    std::vector<pal_tick> kept_;
    std::uint32_t beat_ = 0, faults_seen_ = 0;
    std::uint64_t n_tables_ = 0;
    bool skin_ = false, keep_ = false;
};

/// palpate-falcon-sim at a socket; its hand presses 3 mm into the skin.
class Falcon {
public:
    Falcon() : process_(arguments()) {
        for (int n = 0; n < 4000 && !std::filesystem::exists(socket() + ".control"); ++n) poll(nullptr, 0, 2);
    }
    ~Falcon() {
        process_.send(SIGKILL);
        (void)process_.wait();
        for (const char* end : {"", ".control", ".path"}) std::filesystem::remove(socket() + end);
    }
    Falcon(const Falcon&) = delete;
    Falcon& operator=(const Falcon&) = delete;
    static std::string socket() { return "/tmp/pal-loop-test-" + std::to_string(getpid()); }
    static std::string device() { return "link:" + socket(); }
    static json status() {
        return json::parse(usbtest::simulator({"status", "--socket", socket()}).words, nullptr, false);
    }
    static bool at_rest() { return status()["motor_counts"] == json::array({0, 0, 0}); }
    Process& process() { return process_; }

private:
    static std::vector<std::string> arguments() {
        FILE* path = std::fopen((socket() + ".path").c_str(), "w");
        REQUIRE(path != nullptr);
        std::fputs("palpate-path 1\n0 0 0 120000\n200000 0 0 117000\n", path);
        std::fclose(path);
        return {usbtest::kProgram,  "serve",        "--socket", socket(),        "--grip", "firm", "--path",
                socket() + ".path", "--ramp-ticks", "50",       "--watchdog-ms", "2000"};
    }
    Process process_;
};

/// palpate-loop between the two.
inline std::vector<std::string> loop(const Host& host, std::vector<std::string> more = {}) {
    std::vector<std::string> words = {usbtest::client("palpate-loop"),
                                      "--link",
                                      host.name(),
                                      "--device",
                                      Falcon::device(),
                                      "--ramp-ticks",
                                      "20"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

}  // namespace loophost
