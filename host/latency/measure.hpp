/// Latencies of a run, from the loop's own records. Stamps T0..T5 are pal_tick.stamp_ns (docs/PROTOCOL.md 3).
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/link.h"
#include "common/tick.h"
#include "host/latency/histogram.hpp"

namespace palpate::latency {

inline constexpr std::uint64_t PERIOD_NS = 1000000;
inline constexpr std::uint32_t REPLY_WINDOW_TICKS = 100;  ///< libfranka: control_command_success_rate

/// What the host knows of a table that it published.
struct Publication {
    std::uint64_t t_ns = 0;                      ///< when, CLOCK_MONOTONIC; 0: not known
    std::optional<std::uint32_t> made_for_tick;  ///< pal_table.tick
    bool marked = false;  ///< made so that the motor words must change: publish-to-motor is measured on these
};
using Publications = std::map<std::uint64_t, Publication>;  ///< by id

/// The loop's words on real time (pal_link_loop), copied once.
struct LoopWords {
    std::uint32_t granted = 0, refused = 0;  ///< PAL_REALTIME_*
    std::uint32_t n_minor_faults = 0, n_major_faults = 0;
    std::uint32_t n_preempted = 0;
};
[[nodiscard]] LoopWords loop_words(const pal_link_loop& loop);

/// One thing measured: its samples, or why there are none.
struct Quantity {
    explicit Quantity(std::uint64_t bin_ns) : histogram(bin_ns) {}
    Histogram histogram;
    std::uint64_t n_unknown = 0;  ///< samples that could not be had: a stamp is missing or out of order
    std::string why_unknown;      ///< words for a person when there are no samples at all; else empty
    [[nodiscard]] bool known() const { return why_unknown.empty(); }
};

struct Measured {
    std::uint64_t n_ticks = 0;
    double duration_s = 0.0;  ///< from the first tick's start to the last one's
    bool virtual_time = false;

    Quantity period{WAKE_BIN_NS};   ///< start to start of ticks in a row
    Quantity wake_up{WAKE_BIN_NS};  ///< start minus programmed start; skipped starts count with their waits
    Quantity wake_up_raw{WAKE_BIN_NS};  ///< the same, one sample a tick that ran, as cyclictest counts
    Quantity tick_cost{COST_BIN_NS};    ///< T4 - T1
    Quantity collect{COST_BIN_NS};      ///< T0 - T1: the reply, of devices that wait for it in the tick
    /// T2 - T0, or T2 - T1 where the reply was there before the tick, or did not come.
    Quantity choose_table{COST_BIN_NS};
    Quantity compute_force{COST_BIN_NS};    ///< T3 - T2
    Quantity hand_over{COST_BIN_NS};        ///< T4 - T3: the request
    Quantity sensor_to_force{COST_BIN_NS};  ///< T4 - T0 of ticks with a fresh sample
    /// T4 - T4 of the last tick with a fresh sample, of ticks with one: the sample answers the request that
    /// was sent then or a later one, so it is no older.
    Quantity sensor_age_bound{WAKE_BIN_NS};
    Quantity request_done{WAKE_BIN_NS};      ///< T5 - T4 of that request
    Quantity publish_to_use{WAKE_BIN_NS};    ///< T3 of the first tick with the table - its publication
    Quantity publish_to_motor{WAKE_BIN_NS};  ///< T4 of the first other motor words - publication; marked ones
    Quantity table_age{WAKE_BIN_NS};  ///< start of each tick - start of the tick that its table was made for

    std::uint64_t n_missed = 0;             ///< periods without a tick
    std::uint64_t longest_miss = 0;         ///< most periods missed in a row
    std::uint64_t n_missed_not_late = 0;    ///< of n_missed, not explained by the lateness of a start
    std::uint64_t n_lost_records = 0;       ///< ticks whose record did not reach the host
    std::uint64_t n_bad_records = 0;        ///< not after the record before: left out
    std::uint64_t n_replies = 0;            ///< ticks with a fresh sample
    std::optional<double> reply_share;      ///< of the ticks; nullopt: there are none
    std::optional<double> reply_share_min;  ///< of any REPLY_WINDOW_TICKS in a row; nullopt: too few ticks
};

/// A request under way: handed over (T4), out (T5).
struct Request {
    std::uint64_t from_ns, to_ns;
};
/// The one whose end `now` knows and `before`, the tick before it, did not: that of the tick before, or its
/// own. nullopt when there is none, or when T5 is T4: then packets pass in the very call and there is no more
/// to know.
[[nodiscard]] std::optional<Request> request_done_by(const pal_tick& before, const pal_tick& now);

/// A name for each quantity, in the order in which they are shown.
struct QuantityName {
    const char* key;
    const char* words;
    Quantity Measured::*member;
};
[[nodiscard]] std::span<const QuantityName> quantity_names();

/// Takes the records of a run one after the other. 16 bytes a tick, and 40 a table.
class Meter {
public:
    void add(const pal_tick& tick);
    /// Joins what was seen with what the host published.
    [[nodiscard]] Measured result(const Publications& publications) const;

private:
    struct Start {
        std::uint64_t t_ns;
        std::uint32_t tick;
    };
    /// The ticks in a row with one table.
    struct Use {
        std::uint64_t id;
        std::size_t first, last;  // in starts_
        bool begin_seen = false;  // the tick before is there and had another table
        std::uint64_t t3_ns = 0;  // of the first tick; 0: not known
        std::uint64_t t4_ns = 0;  // of the first tick with other motor words than before; 0: none
        std::array<std::int16_t, 3> motor_before{};
    };
    void add_gap(const pal_tick& tick);
    void add_wake(const pal_tick& tick);
    void add_stages(const pal_tick& tick);
    void add_pair(const pal_tick& tick);
    void add_age(const pal_tick& tick);
    void add_reply(bool fresh);
    void add_use(const pal_tick& tick);
    void join_use(const Use& use, const Publication* published, Measured& out) const;
    [[nodiscard]] std::optional<std::uint64_t> start_of(std::uint32_t tick) const;
    void say_why(Measured& out, const Publications& publications) const;

    Measured so_far_;
    pal_tick before_{};
    std::vector<Start> starts_;
    std::vector<Use> uses_;
    std::array<bool, REPLY_WINDOW_TICKS> window_{};
    std::uint32_t n_window_ = 0;  // fresh ones in it
    std::uint64_t n_late_periods_ = 0;
    std::uint64_t fresh_t4_ns_ = 0;  // of the last tick with a fresh sample; 0: not known
    bool in_call_ = false;           // T5 is T4: packets pass in the very call
    bool in_a_row_ = false;          // this tick follows the one before
    std::array<bool, 6> stamped_{};
};

/// All of it at once.
[[nodiscard]] Measured measure(std::span<const pal_tick> ticks, const Publications& publications);

}  // namespace palpate::latency
