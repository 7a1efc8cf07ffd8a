/// Tables in real time: built in a process of its own, so that its death costs the run nothing but tables.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/link.h"
#include "host/app/run.hpp"

namespace palpate::app {

/// A builder that ended or hung, and its successor.
struct TableRestart {
    std::string why;              ///< "signal 9", "no sign of life"
    std::uint32_t noticed_tick;   ///< the loop's newest tick then
    std::uint64_t noticed_ns;     ///< CLOCK_MONOTONIC
    std::uint64_t served_ns = 0;  ///< when its successor published its first table; 0: not yet
};

/// Forks the builder: a copy of this process with the world and all that is baked, which reads the loop's
/// records, publishes tables and reports them here. When it dies it is forked again, follows the ticks so
/// far without building, and goes on in the same contact. It ends with this process.
class TableProcess {
public:
    /// Borrowed; must outlive this. Throws ChildError.
    TableProcess(const Prepared& prepared, pal_link& link);
    /// Kills it.
    ~TableProcess();
    TableProcess(const TableProcess&) = delete;
    TableProcess& operator=(const TableProcess&) = delete;
    /// Takes in what it reported; starts a new one when it is gone. `ticks`: all of the run so far. Never
    /// waits.
    void look(std::span<const pal_tick> ticks);
    /// Ends it and takes in the rest. Nothing is built after it.
    void stop();
    /// Why there will be no more tables, in words; empty while all is well.
    [[nodiscard]] const std::string& failure() const { return failure_; }
    [[nodiscard]] pid_t pid() const { return pid_; }
    [[nodiscard]] const std::vector<TableRestart>& restarts() const { return restarts_; }

    /// What all builders of this run published and found.
    struct Report {
        std::map<std::uint64_t, record::TableBytes> tables;   ///< by id
        std::map<std::uint64_t, std::uint64_t> published_ns;  ///< by id, CLOCK_MONOTONIC
        std::vector<link::Refused> refused;                   ///< by the loop's check, before sending
        std::size_t n_built = 0, n_refused_places = 0;
        std::string why_no_plate;  ///< of the stiffness field
    };
    [[nodiscard]] const Report& report() const { return report_; }

private:
    void start(std::span<const pal_tick> ticks);
    void take_in();
    void restart(const std::string& why, std::span<const pal_tick> ticks);

    const Prepared* prepared_;
    pal_link* link_;
    pid_t pid_ = -1;
    int socket_ = -1;
    std::uint64_t generation_ = 0, heard_ns_ = 0;
    std::size_t n_vain_ = 0;                                 ///< builders in a row that published nothing
    std::size_t n_built_before_ = 0, n_refused_before_ = 0;  ///< by the ones that are gone
    Report report_;
    std::vector<TableRestart> restarts_;
    std::string failure_;
};

}  // namespace palpate::app
