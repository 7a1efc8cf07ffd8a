#include "host/latency/measure.hpp"

#include <algorithm>
#include <iterator>

namespace palpate::latency {
namespace {

/// The time between two stamps; counted as unknown when one is missing or they are out of order.
void add_between(Quantity& quantity, std::uint64_t from_ns, std::uint64_t to_ns) {
    if (from_ns == 0 || to_ns == 0 || to_ns < from_ns) {
        ++quantity.n_unknown;
    } else {
        quantity.histogram.add(to_ns - from_ns);
    }
}

bool fresh(const pal_tick& tick) {
    return (tick.faults & static_cast<std::uint32_t>(PAL_FAULT_LATE)) == 0;
}

bool same_motor_words(const std::array<std::int16_t, 3>& a, const std::int16_t (&b)[3]) {
    return std::equal(a.begin(), a.end(), std::begin(b));
}

}  // namespace

LoopWords loop_words(const pal_link_loop& loop) {
    return {.granted = pal_link_load(&loop.realtime),
            .refused = pal_link_load(&loop.realtime_refused),
            .n_minor_faults = pal_link_load(&loop.n_minor_faults),
            .n_major_faults = pal_link_load(&loop.n_major_faults),
            .n_preempted = pal_link_load(&loop.n_preempted)};
}

std::optional<Request> request_done_by(const pal_tick& before, const pal_tick& now) {
    const std::uint64_t done_ns = now.stamp_ns[5], own_ns = now.stamp_ns[4], earlier_ns = before.stamp_ns[4];
    if (done_ns == before.stamp_ns[5] || done_ns == own_ns) return std::nullopt;
    if (own_ns != 0 && done_ns > own_ns) return Request{.from_ns = own_ns, .to_ns = done_ns};
    if (earlier_ns == 0 || done_ns <= earlier_ns) return std::nullopt;
    return Request{.from_ns = earlier_ns, .to_ns = done_ns};
}

std::span<const QuantityName> quantity_names() {
    static constexpr QuantityName NAMES[] = {
        {"wake_up", "start after the programmed start, skipped starts with their waits", &Measured::wake_up},
        {"wake_up_raw", "the same, of the ticks that ran alone", &Measured::wake_up_raw},
        {"period", "start to start", &Measured::period},
        {"tick_cost", "start to request handed over", &Measured::tick_cost},
        {"collect", "of it: waiting for the reply", &Measured::collect},
        {"choose_table", "of it: the table", &Measured::choose_table},
        {"compute_force", "of it: the force", &Measured::compute_force},
        {"hand_over", "of it: handing over the request", &Measured::hand_over},
        {"sensor_to_force", "reply collected to request handed over", &Measured::sensor_to_force},
        {"sensor_age_bound", "the sample is not older than this when its force is handed over",
         &Measured::sensor_age_bound},
        {"request_done", "request handed over to its transfer complete", &Measured::request_done},
        {"publish_to_use", "table published to the first force from it", &Measured::publish_to_use},
        {"publish_to_motor", "marked table published to other motor words", &Measured::publish_to_motor},
        {"table_age", "age of the state that the table in use was made for", &Measured::table_age},
    };
    return NAMES;
}

void Meter::add(const pal_tick& tick) {
    if (!starts_.empty() && (tick.tick <= before_.tick || tick.t_ns < before_.t_ns)) {
        ++so_far_.n_bad_records;
        return;
    }
    in_a_row_ = !starts_.empty() && tick.tick == before_.tick + 1;
    if (!starts_.empty()) add_gap(tick);
    starts_.push_back({tick.t_ns, tick.tick});
    for (std::size_t i = 0; i < stamped_.size(); ++i) stamped_[i] = stamped_[i] || tick.stamp_ns[i] != 0;
    add_wake(tick);
    add_stages(tick);
    if (in_a_row_) add_pair(tick);
    add_age(tick);
    add_reply(fresh(tick));
    add_use(tick);
    before_ = tick;
}

void Meter::add_gap(const pal_tick& tick) {
    so_far_.n_lost_records += tick.tick - before_.tick - 1;
    if (tick.n_missed <= before_.n_missed) return;
    const std::uint64_t n = tick.n_missed - before_.n_missed;
    so_far_.n_missed += n;
    so_far_.longest_miss = std::max(so_far_.longest_miss, n);
}

void Meter::add_wake(const pal_tick& tick) {
    so_far_.wake_up_raw.histogram.add(tick.wake_late_ns);
    so_far_.wake_up.histogram.add_start(tick.wake_late_ns, PERIOD_NS);
    // What the first record's lateness skipped is in its n_missed already, so in no difference.
    if (starts_.size() > 1) n_late_periods_ += tick.wake_late_ns / PERIOD_NS;
}

void Meter::add_stages(const pal_tick& tick) {
    const std::uint64_t* t = tick.stamp_ns;
    add_between(so_far_.tick_cost, t[1], t[4]);
    add_between(so_far_.collect, t[1], t[0]);
    add_between(so_far_.choose_table, t[1] == 0 ? 0 : std::max(t[0], t[1]), t[2]);
    add_between(so_far_.compute_force, t[2], t[3]);
    add_between(so_far_.hand_over, t[3], t[4]);
    if (fresh(tick)) add_between(so_far_.sensor_to_force, t[0], t[4]);
}

void Meter::add_pair(const pal_tick& tick) {
    so_far_.period.histogram.add(tick.t_ns - before_.t_ns);
    const auto done = request_done_by(before_, tick);
    add_between(so_far_.request_done, done ? done->from_ns : 0, done ? done->to_ns : 0);
}

void Meter::add_age(const pal_tick& tick) {
    if (!in_a_row_) fresh_t4_ns_ = 0;
    in_call_ = in_call_ || (tick.stamp_ns[5] != 0 && tick.stamp_ns[5] == tick.stamp_ns[4]);
    if (!fresh(tick)) return;
    if (in_a_row_) add_between(so_far_.sensor_age_bound, fresh_t4_ns_, tick.stamp_ns[4]);
    fresh_t4_ns_ = tick.stamp_ns[4];
}

void Meter::add_reply(bool is_fresh) {
    bool& oldest = window_[so_far_.n_ticks % REPLY_WINDOW_TICKS];
    n_window_ += is_fresh ? 1U : 0U;
    n_window_ -= oldest ? 1U : 0U;
    oldest = is_fresh;
    so_far_.n_replies += is_fresh ? 1U : 0U;
    if (++so_far_.n_ticks < REPLY_WINDOW_TICKS) return;
    const double share = static_cast<double>(n_window_) / REPLY_WINDOW_TICKS;
    so_far_.reply_share_min = std::min(so_far_.reply_share_min.value_or(1.0), share);
}

void Meter::add_use(const pal_tick& tick) {
    if (tick.table_id == 0) return;
    const std::size_t at = starts_.size() - 1;
    if (uses_.empty() || uses_.back().id != tick.table_id) {
        Use use{.id = tick.table_id, .first = at, .last = at};
        use.begin_seen = in_a_row_;
        use.t3_ns = tick.stamp_ns[3];
        std::copy(std::begin(before_.motor_counts), std::end(before_.motor_counts), use.motor_before.begin());
        uses_.push_back(use);
    }
    Use& use = uses_.back();
    use.last = at;
    if (use.t4_ns == 0 && use.begin_seen && !same_motor_words(use.motor_before, tick.motor_counts)) {
        use.t4_ns = tick.stamp_ns[4];
    }
}

std::optional<std::uint64_t> Meter::start_of(std::uint32_t tick) const {
    const auto at =
        std::lower_bound(starts_.begin(), starts_.end(), tick,
                         [](const Start& start, std::uint32_t wanted) { return start.tick < wanted; });
    if (at == starts_.end() || at->tick != tick) return std::nullopt;
    return at->t_ns;
}

void Meter::join_use(const Use& use, const Publication* published, Measured& out) const {
    const auto made_ns =
        published != nullptr && published->made_for_tick ? start_of(*published->made_for_tick) : std::nullopt;
    for (std::size_t i = use.first; i <= use.last; ++i) {
        if (made_ns && starts_[i].t_ns >= *made_ns) {
            out.table_age.histogram.add(starts_[i].t_ns - *made_ns);
        } else {
            ++out.table_age.n_unknown;
        }
    }
    const std::uint64_t published_ns = published == nullptr ? 0 : published->t_ns;
    add_between(out.publish_to_use, published_ns, use.begin_seen ? use.t3_ns : 0);
    if (published != nullptr && published->marked) {
        add_between(out.publish_to_motor, published_ns, use.t4_ns);
    }
}

Measured Meter::result(const Publications& publications) const {
    Measured out = so_far_;
    if (!starts_.empty()) {
        out.duration_s = static_cast<double>(starts_.back().t_ns - starts_.front().t_ns) / 1e9;
        out.reply_share = static_cast<double>(out.n_replies) / static_cast<double>(out.n_ticks);
    }
    out.virtual_time =
        !starts_.empty() && std::none_of(stamped_.begin(), stamped_.end(), [](bool b) { return b; });
    if (out.n_missed > n_late_periods_) out.n_missed_not_late = out.n_missed - n_late_periods_;
    for (const Use& use : uses_) {
        const auto at = publications.find(use.id);
        join_use(use, at == publications.end() ? nullptr : &at->second, out);
    }
    say_why(out, publications);
    return out;
}

Measured measure(std::span<const pal_tick> ticks, const Publications& publications) {
    Meter meter;
    for (const pal_tick& tick : ticks) meter.add(tick);
    return meter.result(publications);
}

}  // namespace palpate::latency
