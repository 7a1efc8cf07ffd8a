// Why a quantity was not measured, in words for a person.
#include <algorithm>
#include <initializer_list>

#include "host/latency/measure.hpp"

namespace palpate::latency {
namespace {

constexpr const char* VIRTUAL = "virtual time: ticks take none, all stamps are 0";
constexpr const char* STAMPS[] = {"T0 (reply collected)", "T1 (start)",       "T2 (table chosen)",
                                  "T3 (force computed)",  "T4 (handed over)", "T5 (transfer complete)"};

void say(Quantity& quantity, const std::string& why) {
    if (quantity.histogram.n() == 0) quantity.why_unknown = why;
}

}  // namespace

void Meter::say_why(Measured& out, const Publications& publications) const {
    const auto missing = [&](std::initializer_list<std::size_t> stamps, const std::string& otherwise) {
        if (starts_.empty()) return std::string("no ticks");
        if (out.virtual_time) return std::string(VIRTUAL);
        for (const std::size_t stamp : stamps) {
            if (!stamped_[stamp]) return std::string("the loop did not stamp ") + STAMPS[stamp];
        }
        return otherwise;
    };
    const std::string order = "the stamps are never in order";
    say(out.period, missing({}, "no two ticks in a row"));
    say(out.tick_cost, missing({1, 4}, order));
    say(out.collect, missing({1, 0}, "the replies came before the tick began"));
    say(out.choose_table, missing({1, 2}, order));
    say(out.compute_force, missing({2, 3}, order));
    say(out.hand_over, missing({3, 4}, order));
    const std::string stale = out.n_replies == 0 ? "the device never answered in time" : order;
    say(out.sensor_to_force, missing({0, 4}, stale));
    say(out.sensor_age_bound, missing({4}, out.n_replies == 0 ? stale : "no two replies in a row"));
    say(out.request_done,
        missing({4, 5}, in_call_ ? "packets pass in the very call: hand_over is all there is to know"
                                 : "no request was seen to complete"));

    // Not one start late by a nanosecond: nobody measured it.
    if (out.wake_up.histogram.max_ns() == 0) {
        for (Quantity* wake : {&out.wake_up, &out.wake_up_raw}) {
            wake->n_unknown = wake->histogram.n();
            wake->histogram = Histogram(WAKE_BIN_NS);
            say(*wake, missing({}, "the record has no programmed starts (wake_late_ns is 0 throughout)"));
        }
    }

    const auto any = [&](auto&& has) {
        return std::any_of(publications.begin(), publications.end(),
                           [&](const auto& p) { return has(p.second); });
    };
    const auto about_tables = [&](bool has, const char* without, const std::string& otherwise) {
        if (uses_.empty()) return std::string("no table was used");
        return has ? otherwise : std::string(without);
    };
    const bool any_time = any([](const Publication& p) { return p.t_ns != 0; });
    const char* no_time = "the times of publication are not known";
    say(out.publish_to_use,
        missing({3},
                about_tables(any_time, no_time, "no table was both published and first used in this time")));
    const bool any_mark = any([](const Publication& p) { return p.marked; });
    say(out.publish_to_motor, missing({4}, about_tables(any_mark, "no marked table was published",
                                                        "no marked table moved the motors")));
    say(out.table_age,
        starts_.empty() ? "no ticks"
                        : about_tables(any([](const Publication& p) { return p.made_for_tick.has_value(); }),
                                       "the ticks that the tables were made for are not known",
                                       "these ticks are not in the record"));
}

}  // namespace palpate::latency
