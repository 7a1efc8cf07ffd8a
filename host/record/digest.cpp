#include <xxhash.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <new>

#include "host/record/record.hpp"

namespace palpate::record {
namespace {

/// One running XXH64.
class Stream {
public:
    Stream() : state_(XXH64_createState()) {
        if (state_ == nullptr) throw std::bad_alloc();
        XXH64_reset(state_, 0);
    }
    ~Stream() { XXH64_freeState(state_); }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;
    void add(const void* bytes, std::size_t n_bytes) { XXH64_update(state_, bytes, n_bytes); }
    [[nodiscard]] std::string hex() const {
        char text[17];
        std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(XXH64_digest(state_)));
        return text;
    }

private:
    XXH64_state_t* state_;
};

}  // namespace

struct Digest::Impl {
    Stream io, state;
};

Digest::Digest() : impl_(std::make_unique<Impl>()) {}
Digest::~Digest() = default;

void Digest::tick(const pal_tick& tick) {
    impl_->io.add(tick.encoder_counts, sizeof tick.encoder_counts);
    impl_->io.add(tick.motor_counts, sizeof tick.motor_counts);
    impl_->io.add(&tick.buttons, 1);
    impl_->io.add(&tick.homed, 1);
    pal_tick timeless = tick;
    timeless.t_ns = 0;
    timeless.wake_late_ns = 0;
    std::fill(std::begin(timeless.stamp_ns), std::end(timeless.stamp_ns), 0);
    impl_->state.add(&timeless, sizeof timeless);
}

void Digest::table(const pal_table& table) {
    const TableBytes bytes = table_bytes(table);
    impl_->state.add(bytes.data(), bytes.size());
}

std::string Digest::io() const {
    return impl_->io.hex();
}
std::string Digest::state() const {
    return impl_->state.hex();
}

}  // namespace palpate::record
