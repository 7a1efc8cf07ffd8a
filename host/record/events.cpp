#include "host/record/csv.hpp"

namespace palpate::record {
namespace {

/// Rows of events.csv, one tick at a time.
class Events {
public:
    void tick(const pal_tick& now, double t_s) {
        now_ = &now;
        t_s_ = t_s;
        if (first_ || now.state != before_.state) row("state", state_word(now.state));
        if (now.stop != before_.stop) row("stop", stop_word(now.stop));
        faults("fault-begin", now.faults & ~before_.faults);
        faults("fault-end", before_.faults & ~now.faults);
        if (now.table_id != before_.table_id) row("table", std::to_string(now.table_id));
        if (now.n_missed > before_.n_missed) row("missed", std::to_string(now.n_missed - before_.n_missed));
        before_ = now;
        first_ = false;
    }
    void contact(const pal_tick& at, double t_s, const char* event) {
        now_ = &at;
        t_s_ = t_s;
        std::string depth = "depth_m ";
        append_number(depth, static_cast<double>(at.depth_m));
        row(event, depth);
    }
    [[nodiscard]] const std::string& text() const { return text_; }

private:
    void faults(const char* event, std::uint32_t bits) {
        for (std::uint32_t bit = 0; bit < 32; ++bit) {
            if ((bits >> bit & 1U) != 0) row(event, fault_words(1U << bit));
        }
    }
    void row(const char* event, const std::string& detail) {
        append_number(text_, t_s_);
        text_ += ',' + std::to_string(now_->tick) + ',' + event + ',' + detail + '\n';
    }
    std::string text_ = "t_s,tick,event,detail\n";
    pal_tick before_{};
    const pal_tick* now_ = nullptr;
    double t_s_ = 0.0;
    bool first_ = true;
};

}  // namespace

void write_events_csv(const std::filesystem::path& file, std::span<const pal_tick> ticks) {
    const auto in_contact = [](const pal_tick& tick) { return tick.depth_m > 0.0F; };
    std::size_t first = ticks.size(), last = ticks.size();
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        if (!in_contact(ticks[i])) continue;
        if (first == ticks.size()) first = i;
        last = i;
    }
    const std::vector<double> times_s = scene_times_s(ticks);
    Events events;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        events.tick(ticks[i], times_s[i]);
        if (i == first) events.contact(ticks[i], times_s[i], "first-contact");
        if (i == last) events.contact(ticks[i], times_s[i], "last-contact");
    }
    write_file(file, events.text());
}

}  // namespace palpate::record
