#include "host/app/table_thread.hpp"

#include <chrono>
#include <utility>

namespace palpate::app {
namespace {

constexpr auto LOOK_EVERY = std::chrono::milliseconds(2);

}  // namespace

TableThread::TableThread(Update update, pal_link& link)
    : update_(std::move(update)), publisher_(link), thread_([this] { work(); }) {}

void TableThread::offer(const pal_tick& record) {
    const std::lock_guard lock(mutex_);
    newest_ = record;
    fresh_ = true;
    const bool late = at_work_since_tick_ && record.tick - *at_work_since_tick_ >= link::REFRESH_TICKS;
    if (!late) keep(publisher_.refresh(record.tick));
}

std::exception_ptr TableThread::failure() {
    const std::lock_guard lock(mutex_);
    return failure_;
}

void TableThread::stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
}

std::optional<pal_tick> TableThread::take() {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(fresh_, false)) return std::nullopt;
    at_work_since_tick_ = newest_.tick;
    return newest_;
}

void TableThread::give(std::unique_ptr<pal_table> table) {
    const std::lock_guard lock(mutex_);
    at_work_since_tick_.reset();
    if (table) keep(publisher_.publish(std::move(table), newest_.tick));
}

void TableThread::keep(const pal_table* published) {
    if (published != nullptr) tables_[published->id] = record::table_bytes(*published);
}

void TableThread::work() {
    try {
        while (!stopping_) {
            const auto record = take();
            auto table = record ? update_(*record) : nullptr;
            const bool built = table != nullptr;
            if (record) give(std::move(table));
            if (!built) std::this_thread::sleep_for(LOOK_EVERY);
        }
    } catch (...) {  // at_work_since_tick_ stays: no table is kept fresh for a builder that is gone
        const std::lock_guard lock(mutex_);
        failure_ = std::current_exception();
    }
}

}  // namespace palpate::app
