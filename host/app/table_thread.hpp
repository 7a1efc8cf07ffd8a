/// Tables in real time: built off the thread that watches the loop.
#pragma once
#include <atomic>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "common/tick.h"
#include "host/link/publisher.hpp"
#include "host/record/record.hpp"

namespace palpate::app {

/// Builds and publishes tables for the newest record; keeps the last one fresh meanwhile.
class TableThread {
public:
    using Update = std::function<std::unique_ptr<pal_table>(const pal_tick&)>;
    /// `update`: the table that is due after a record, or nullptr; called on the thread.
    TableThread(Update update, pal_link& link);
    ~TableThread() { stop(); }
    /// A newer record. Publishes the last table again when it is 40 ticks old, unless update() has been at
    /// work for as long: a host that is late must look late.
    void offer(const pal_tick& record);
    /// What update() threw; nothing is built after it.
    [[nodiscard]] std::exception_ptr failure();
    /// Waits for the update() at work.
    void stop();
    /// After stop().
    [[nodiscard]] const std::map<std::uint64_t, record::TableBytes>& tables() const { return tables_; }
    [[nodiscard]] const std::vector<link::Refused>& refused() const { return publisher_.refused(); }

private:
    [[nodiscard]] std::optional<pal_tick> take();
    void give(std::unique_ptr<pal_table> table);
    void keep(const pal_table* published);
    void work();

    Update update_;
    std::mutex mutex_;  // of all up to stopping_
    link::Publisher publisher_;
    std::map<std::uint64_t, record::TableBytes> tables_;
    pal_tick newest_{};
    bool fresh_ = false;
    std::optional<std::uint32_t> at_work_since_tick_;
    std::exception_ptr failure_;
    std::atomic<bool> stopping_{false};
    std::thread thread_;
};

}  // namespace palpate::app
