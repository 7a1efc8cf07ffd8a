// The loop between a host and a device that do as they please: any reply or none, any word of the segment at
// any time, tables good and bad. After each tick the request is a packet that a Falcon understands, its motor
// words and the recorded force keep their limits, and a stop or a pause means zero.
#include <cmath>
#include <memory>

#include "firmware/app/session.h"
#include "sim/falcon/codec.h"
#include "sim/falcon/falcon_sim.h"
#include "tests/fuzz/good_table.hpp"

namespace {

using fuzz::require;

fuzz::Reached felt("force of a table"), fading("two tables at once"), refused("table refused"),
    stopped("stop"), missed("missed periods");

constexpr std::size_t TICKS_MAX = 600;  // past every age and time-out of the ladder

/// A device that says what it is told to.
struct Device {
    std::array<std::uint8_t, 16> reply{}, request{};
    pal_device_news news = PAL_DEVICE_NONE;

    static pal_device_news collect(void* context, std::uint8_t reply[16]) {
        const auto* const self = static_cast<const Device*>(context);
        std::copy(self->reply.begin(), self->reply.end(), reply);
        return self->news;
    }
    static pal_device_news send(void* context, const std::uint8_t request[16]) {
        std::copy_n(request, 16, static_cast<Device*>(context)->request.begin());
        return PAL_DEVICE_NONE;
    }
};

bool pushes(const float force_n[3]) {
    return force_n[0] != 0.0F || force_n[1] != 0.0F || force_n[2] != 0.0F;
}

class Bench {
public:
    Bench() {
        static const auto link = std::make_unique<pal_link>();
        link_ = link.get();
        pal_link_init(link_, 1);
        link_->host.enable = 1;
        pal_loop_config config = pal_loop_config_default();
        config.ramp_ticks = 4;  // so that a short input gets to the full force
        config.release_ticks = 4;
        const pal_device device{&device_, Device::collect, Device::send, nullptr};
        pal_session_begin(&session_, link_, &device, &config, [] { return std::uint64_t{0}; });
    }

    void run(fuzz::Bytes bytes) {
        fuzz::Bytes none;
        publish(none);
        while (!bytes.empty() && n_ticks_ < TICKS_MAX) op(bytes);
    }

private:
    void op(fuzz::Bytes& bytes) {
        const auto what = fuzz::take<std::uint8_t>(bytes);
        switch (what % 8) {
            case 0:
            case 1:  // near the middle of the workspace, all arms homed
                return sense_near(bytes, 1 + what / 8);
            case 2: {  // counts and flags as they come
                const auto counts = fuzz::take<std::array<std::int16_t, 3>>(bytes);
                pal_falcon_reply_encode(counts.data(), fuzz::take<std::uint8_t>(bytes), device_.reply.data());
                return ticks(PAL_DEVICE_FRESH, 1);
            }
            case 3:
                device_.reply = fuzz::take<std::array<std::uint8_t, 16>>(bytes);
                return ticks(PAL_DEVICE_FRESH, 1);
            case 4:
                return ticks(what < 200 ? PAL_DEVICE_NONE : PAL_DEVICE_GONE, 1 + what / 8);
            case 5:
                return publish(bytes);
            case 6:
                if (what >= 192) n_missed_ += fuzz::take<std::uint8_t>(bytes);
                return host_word(bytes);
            default:
                return any_word(bytes);
        }
    }

    void sense_near(fuzz::Bytes& bytes, int n) {
        constexpr double AT_M[3] = {0.0, 0.0, 0.12 - 0.002};  // 2 mm in the good table's skin
        static const auto MIDDLE = [&] {
            std::array<std::int16_t, 3> counts{};
            require(pal_falcon_sim_counts(AT_M, counts.data()));
            return counts;
        }();
        std::array<std::int16_t, 3> counts = MIDDLE;
        for (std::int16_t& count : counts) {
            count = static_cast<std::int16_t>(count + fuzz::take<std::int8_t>(bytes));
        }
        pal_falcon_reply_encode(counts.data(), 7U << 4U, device_.reply.data());
        ticks(PAL_DEVICE_FRESH, n);
    }

    void publish(fuzz::Bytes& bytes) {
        pal_table* const table = pal_table_ring_back(&link_->tables);
        if (table == nullptr) return;  // the ring's word was one of the wild ones
        fuzz::fill_good(*table, PAL_TABLE_NODES_MIN, ++last_id_);
        const auto n_patches = fuzz::take<std::uint8_t>(bytes);
        fuzz::patch(*table, bytes, n_patches % 4);
        if (n_patches < 200) pal_table_seal(table);
        pal_table_ring_publish(&link_->tables);
    }

    void host_word(fuzz::Bytes& bytes) {
        std::uint32_t* const words[] = {&link_->host.enable, &link_->host.estop, &link_->host.heartbeat,
                                        &link_->host.stop, &link_->tables.state};
        std::uint32_t& word = *words[fuzz::take<std::uint8_t>(bytes) % std::size(words)];
        word = fuzz::take<std::uint32_t>(bytes);
    }

    /// A word of a table, in use or not, when `where` is odd; any word of the segment otherwise.
    void any_word(fuzz::Bytes& bytes) {
        const auto where = fuzz::take<std::uint32_t>(bytes);
        const std::size_t in_table = where / 8 % (pal_table_bytes(PAL_TABLE_NODES_MIN) / 4) * 4;
        auto* const table = reinterpret_cast<std::uint8_t*>(&link_->tables.slot[where / 2 % 4].table);
        auto* const segment = reinterpret_cast<std::uint8_t*>(link_);
        const auto word = fuzz::take<std::uint32_t>(bytes);
        std::memcpy(where % 2 == 1 ? table + in_table : segment + where % sizeof *link_ / 4 * 4, &word,
                    sizeof word);
    }

    void ticks(pal_device_news news, int n) {
        device_.news = news;
        for (int i = 0; i < n; ++i) {
            ++n_ticks_;
            const pal_session_time now{n_ticks_ * 1000000U, n_missed_, 0};
            static_cast<void>(pal_session_tick(&session_, &now));
            static_cast<void>(pal_intake_check(&session_.intake));
            check();
        }
    }

    void check() {
        for (unsigned i = 0; i < device_.request.size(); ++i) {
            require(pal_falcon_request_byte_ok(device_.request[i], i));
        }
        const pal_falcon_request request = pal_falcon_request_decode(device_.request.data());
        pal_state_reader reader{.next = link_->ticks.done - 1U, .n_dropped = 0};
        pal_tick tick{};
        require(pal_state_ring_read(&link_->ticks, &reader, &tick));
        double length2 = 0.0;
        bool any = false;
        for (std::size_t i = 0; i < 3; ++i) {
            require(std::abs(int{request.motor_counts[i]}) <= PAL_FALCON_MOTOR_MAX);
            require(request.motor_counts[i] == tick.motor_counts[i]);
            require(std::isfinite(tick.position_m[i]) && std::isfinite(tick.velocity_m_per_s[i]));
            require(std::isfinite(tick.table_force_n[i]));
            length2 += static_cast<double>(tick.force_n[i]) * static_cast<double>(tick.force_n[i]);
            any = any || request.motor_counts[i] != 0;
        }
        require(std::sqrt(length2) <= static_cast<double>(session_.config.force_max_n) * 1.00001);  // float32
        require(std::isfinite(tick.fade_work_j) && std::isfinite(tick.hand_work_j));
        if (tick.stop != 0 || link_->host.enable == 0 || link_->host.estop != 0) require(!any);
        if (any && tick.table_force_n[2] != 0.0F) felt.note();
        if (tick.before_id != 0) fading.note();
        if (link_->loop.n_bad_tables != 0) refused.note();
        if (tick.stop != 0) stopped.note();
        const bool settled = (tick.faults & (PAL_FAULT_LATE | PAL_FAULT_TABLE_DROPPED)) == 0;
        if (tick.n_missed - n_missed_told_ >= 5 && settled) {
            require(tick.gain == 0.0F || !pushes(tick.table_force_n));  // never a jump back
            missed.note();
        }
        n_missed_told_ = tick.n_missed;
    }

    pal_link* link_;
    pal_session session_{};
    Device device_;
    std::uint64_t last_id_ = 0, n_ticks_ = 0;
    std::uint32_t n_missed_ = 0, n_missed_told_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Bench().run({data, size});
    return 0;
}
