#include "host/latency/trace.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "host/record/record.hpp"

namespace palpate::latency {
namespace {

constexpr int LOOP = 1, HOST = 2;
constexpr Track TICKS{LOOP, 1}, STATE{LOOP, 2}, TABLE{LOOP, 3}, FADE{LOOP, 4}, REQUEST{LOOP, 5};
constexpr Track MADE_FOR{HOST, 1};
constexpr const char* BUILD = "made for .. published";
constexpr const char* WAIT = "published .. in use";
constexpr const char* BUILD_AND_WAIT = "made for .. in use";
/// Events of a tick may lie so far before its start: a request that completed late.
constexpr std::uint64_t SETTLE_NS = 200 * PERIOD_NS;

/// The last value of something, to draw changes only.
template <typename T>
class Shown {
public:
    bool changes_to(T value) {
        const bool changed = first_ || value != value_;
        first_ = false;
        value_ = value;
        return changed;
    }

private:
    T value_{};
    bool first_ = true;
};

/// A row with one thing at a time, or none (key 0).
class Row {
public:
    explicit Row(Track track) : track_(track) {}
    /// Ends what was there and begins the new, when it is another.
    void show(TraceWriter& out, std::uint64_t key, const std::string& name, std::uint64_t t_ns,
              const std::string& arguments = "") {
        if (key == key_) return;
        end(out, t_ns);
        if (key != 0) out.begin(track_, name, t_ns, arguments);
        key_ = key;
    }
    void end(TraceWriter& out, std::uint64_t t_ns) {
        if (key_ != 0) out.end(track_, t_ns);
        key_ = 0;
    }

private:
    Track track_;
    std::uint64_t key_ = 0;
};

bool in_order(std::uint64_t from_ns, std::uint64_t to_ns) {
    return from_ns != 0 && from_ns <= to_ns;
}

double length(const float (&v)[3]) {
    const auto x = static_cast<double>(v[0]), y = static_cast<double>(v[1]), z = static_cast<double>(v[2]);
    return std::sqrt(x * x + y * y + z * z);
}

class Trace {
public:
    Trace(std::span<const pal_tick> ticks, const Publications& publications, TraceWriter& out)
        : publications_(&publications), out_(&out) {
        is_virtual_ = std::all_of(ticks.begin(), ticks.end(), [](const pal_tick& tick) {
            return std::all_of(std::begin(tick.stamp_ns), std::end(tick.stamp_ns),
                               [](std::uint64_t t_ns) { return t_ns == 0; });
        });
        is_late_known_ = std::any_of(ticks.begin(), ticks.end(),
                                     [](const pal_tick& tick) { return tick.wake_late_ns != 0; });
    }
    void names() {
        out_->name_process(LOOP, is_virtual_ ? "loop (virtual time)" : "loop");
        out_->name_process(HOST, "host");
        out_->name_track(TICKS, "ticks");
        out_->name_track(STATE, "state");
        out_->name_track(TABLE, "table in use");
        out_->name_track(FADE, "fade");
        if (!is_virtual_) out_->name_track(REQUEST, "requests");
        out_->name_track(MADE_FOR, "states that tables were made for");
    }
    void tick(const pal_tick& tick) {
        stages(tick);
        rows(tick);
        faults(tick);
        counters(tick);
        if (tick.t_ns > SETTLE_NS) out_->settle(tick.t_ns - SETTLE_NS);
        before_ = tick;
        first_ = false;
    }
    void end() {
        const std::uint64_t t_ns = end_ns();
        for (Row* row : {&state_, &table_, &fade_}) row->end(*out_, t_ns);
        fault_spans(before_.faults, 0, t_ns);
    }

private:
    /// When the last tick was over.
    [[nodiscard]] std::uint64_t end_ns() const {
        return is_virtual_ ? before_.t_ns + PERIOD_NS
                           : std::max({before_.t_ns, before_.stamp_ns[3], before_.stamp_ns[4]});
    }
    void stages(const pal_tick& tick) {
        const std::uint64_t* t = tick.stamp_ns;
        const std::string number = "\"tick\":" + std::to_string(tick.tick);
        if (is_virtual_) {
            out_->slice(TICKS, "tick", tick.t_ns, tick.t_ns + PERIOD_NS, number);
        } else if (const std::uint64_t end_ns = t[4] != 0 ? t[4] : t[3]; in_order(t[1], end_ns)) {
            out_->slice(TICKS, "tick", t[1], end_ns, number);
            stage("collect", t[1], t[0], end_ns);
            stage("choose table", std::max(t[0], t[1]), t[2], end_ns);
            stage("compute force", t[2], t[3], end_ns);
            stage("hand over", t[3], t[4], end_ns);
            if (t[0] != 0 && t[0] < t[1]) out_->instant(REQUEST, "reply", t[0]);
        } else {
            out_->instant(TICKS, "tick without stamps", tick.t_ns);
        }
        if (first_) return;
        if (tick.n_missed > before_.n_missed) {
            out_->instant(TICKS, "missed " + std::to_string(tick.n_missed - before_.n_missed), tick.t_ns);
        }
        const auto done = request_done_by(before_, tick);
        if (done) out_->slice(REQUEST, "request", done->from_ns, done->to_ns);
    }
    void stage(const char* name, std::uint64_t from_ns, std::uint64_t to_ns, std::uint64_t last_ns) {
        if (in_order(from_ns, to_ns) && to_ns <= last_ns) out_->slice(TICKS, name, from_ns, to_ns);
    }
    void rows(const pal_tick& tick) {
        const std::uint64_t id = tick.table_id, t_ns = tick.t_ns;
        state_.show(*out_, tick.state + std::uint64_t{1}, record::state_word(tick.state), t_ns);
        table_.show(*out_, id, "table " + std::to_string(id), t_ns, made_for(id));
        fade_.show(*out_, tick.before_id, std::to_string(tick.before_id) + " to " + std::to_string(id), t_ns);
        const bool stops = first_ ? tick.stop != 0 : tick.stop != before_.stop;
        if (stops) out_->instant(STATE, "stop: " + record::stop_word(tick.stop), t_ns);
    }
    [[nodiscard]] std::string made_for(std::uint64_t id) const {
        const auto at = publications_->find(id);
        if (at == publications_->end() || !at->second.made_for_tick) return "";
        return "\"made_for_tick\":" + std::to_string(*at->second.made_for_tick);
    }
    void faults(const pal_tick& tick) { fault_spans(first_ ? 0 : before_.faults, tick.faults, tick.t_ns); }
    void fault_spans(std::uint32_t before, std::uint32_t now, std::uint64_t t_ns) {
        for (std::uint32_t changed = before ^ now; changed != 0; changed &= changed - 1) {
            const auto bit = static_cast<std::uint32_t>(std::countr_zero(changed));
            const SpanId id{LOOP, "fault", bit};
            const std::string name = "fault: " + record::fault_words(1U << bit);
            if ((now >> bit & 1U) != 0) {
                out_->span_begin(id, name, t_ns);
            } else {
                out_->span_end(id, name, t_ns);
            }
        }
    }
    void counters(const pal_tick& tick) {
        const double force_n = length(tick.force_n);
        const double depth_mm = tick.depth_m > 0.0F ? 1e3 * static_cast<double>(tick.depth_m) : 0.0;
        if (force_.changes_to(force_n)) out_->counter(LOOP, "force (N)", tick.t_ns, force_n);
        if (depth_.changes_to(depth_mm)) out_->counter(LOOP, "depth (mm)", tick.t_ns, depth_mm);
        const double late_us = tick.wake_late_ns / 1e3;
        if (is_late_known_ && late_.changes_to(late_us))
            out_->counter(LOOP, "woken late (us)", tick.t_ns, late_us);
    }

    const Publications* publications_;
    TraceWriter* out_;
    Row state_{STATE}, table_{TABLE}, fade_{FADE};
    Shown<double> force_, depth_, late_;
    pal_tick before_{};
    bool first_ = true, is_virtual_ = false, is_late_known_ = false;
};

/// When the tool first felt each table: T3, or the tick's start where there is no stamp.
std::map<std::uint64_t, std::uint64_t> first_uses(std::span<const pal_tick> ticks) {
    std::map<std::uint64_t, std::uint64_t> out;
    for (const pal_tick& tick : ticks) {
        if (tick.table_id != 0) out.try_emplace(tick.table_id, std::max(tick.t_ns, tick.stamp_ns[3]));
    }
    return out;
}

/// Start of a tick; 0 when it is not among these.
std::uint64_t start_of(std::span<const pal_tick> ticks, std::optional<std::uint32_t> number) {
    if (!number) return 0;
    const auto at = std::lower_bound(ticks.begin(), ticks.end(), *number,
                                     [](const pal_tick& tick, std::uint32_t n) { return tick.tick < n; });
    return at == ticks.end() || at->tick != *number ? 0 : at->t_ns;
}

void span_of(TraceWriter& out, std::uint64_t id, const char* name, std::uint64_t from_ns,
             std::uint64_t to_ns) {
    const SpanId span{HOST, "table", id};
    out.span_begin(span, name, from_ns, "\"table\":" + std::to_string(id));
    out.span_end(span, name, to_ns);
}

/// From the tick that each table was made for to its publication, and on to its first use.
void table_spans(std::span<const pal_tick> ticks, const Publications& publications, TraceWriter& out) {
    const auto uses = first_uses(ticks);
    const std::uint64_t first_ns = ticks.front().t_ns, last_ns = ticks.back().t_ns;
    for (const auto& [id, published] : publications) {
        const std::uint64_t made_ns = start_of(ticks, published.made_for_tick);
        const auto use = uses.find(id);
        const std::uint64_t use_ns = use == uses.end() ? 0 : use->second;
        const bool inside = published.t_ns >= first_ns && published.t_ns <= last_ns;
        const std::uint64_t published_ns = inside ? published.t_ns : 0;
        if (made_ns != 0) out.instant(MADE_FOR, "for table " + std::to_string(id), made_ns);
        if (in_order(made_ns, published_ns)) span_of(out, id, BUILD, made_ns, published_ns);
        if (in_order(published_ns, use_ns)) span_of(out, id, WAIT, published_ns, use_ns);
        if (published_ns == 0 && in_order(made_ns, use_ns)) span_of(out, id, BUILD_AND_WAIT, made_ns, use_ns);
        if (published_ns != 0 && use_ns == 0) {
            out.instant(MADE_FOR, "table " + std::to_string(id) + " was published and not used",
                        published_ns);
        }
    }
}

}  // namespace

TraceResult write_trace(std::span<const pal_tick> ticks, const Publications& publications,
                        const TraceWriter::Sink& sink) {
    const std::uint64_t zero_ns = ticks.empty() ? 0 : ticks.front().t_ns;
    TraceWriter out(sink,
                    "\"schema\":\"palpate.trace/1\",\"zero_ns\":\"" + std::to_string(zero_ns) +
                        "\",\"n_ticks\":" + std::to_string(ticks.size()),
                    zero_ns);
    if (!ticks.empty()) {
        Trace trace(ticks, publications, out);
        trace.names();
        table_spans(ticks, publications, out);
        for (const pal_tick& tick : ticks) trace.tick(tick);
        trace.end();
    }
    out.finish();
    return {.n_events = out.n_events(), .n_left_out = out.n_left_out()};
}

}  // namespace palpate::latency
