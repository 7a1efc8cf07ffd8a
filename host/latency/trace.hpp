/// A run as a picture over time, for Perfetto (ui.perfetto.dev) and chrome://tracing.
#pragma once
#include <span>
#include <string>

#include "host/latency/measure.hpp"
#include "host/latency/trace_writer.hpp"

namespace palpate::latency {

struct TraceResult {
    std::uint64_t n_events = 0;
    std::uint64_t n_left_out = 0;  ///< with times that are out of order, or no number
};

/// Rows: each tick with its stages, the state, the table in use, fades, requests; faults, and each table from
/// the tick that it was made for to its publication and its first use; counters of force, depth and lateness.
/// In virtual time a tick is drawn as long as its period. `sink` gets one JSON document in pieces of 64 KB;
/// memory does not grow with the ticks. About 0.6 KB and 4 us a tick.
TraceResult write_trace(std::span<const pal_tick> ticks, const Publications& publications,
                        const TraceWriter::Sink& sink);

}  // namespace palpate::latency
