#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <system_error>

#include "host/app/commands.hpp"
#include "host/app/interrupt.hpp"
#include "host/latency/publications.hpp"
#include "host/latency/trace.hpp"
#include "host/record/aside.hpp"
#include "host/record/record.hpp"

namespace palpate::app {
namespace {

struct TraceOptions {
    std::string record, out;
    double from_s = -std::numeric_limits<double>::infinity();
    double to_s = std::numeric_limits<double>::infinity();
    bool quiet = false;
};

constexpr const char* TRACE_FOOTER =
    "Example:\n"
    "  palpate trace out/bunny/run.palrec --out bunny.json     then open bunny.json at ui.perfetto.dev\n"
    "  palpate trace run.palrec --out touch.json --from-s 2 --to-s 3\n"
    "\n"
    "Shows each tick with its stages, the table in use and when it was made and published, fades, faults,\n"
    "states, force and depth. About 0.6 MB for each second of a real-time run.";

/// The ticks whose scene time is in the range.
std::span<const pal_tick> chosen_ticks(const std::vector<pal_tick>& ticks, const TraceOptions& options) {
    const std::vector<double> times_s = record::scene_times_s(ticks);
    std::size_t from = 0, to = ticks.size();
    while (from < to && !(times_s[from] >= options.from_s)) ++from;
    while (to > from && !(times_s[to - 1] <= options.to_s)) --to;
    return std::span(ticks).subspan(from, to - from);
}

int trace(const TraceOptions& options) {
    catch_interrupts();
    std::error_code ignored;
    if (std::filesystem::equivalent(options.record, options.out, ignored)) {
        throw record::Error(options.out + ": is the record itself; choose another --out");
    }
    record::AsideFile file(options.out);
    const record::Record record = record::read(options.record);
    const std::span<const pal_tick> ticks = chosen_ticks(record.ticks, options);
    if (ticks.empty()) throw record::Error(options.record + ": no ticks in this time");
    const latency::TraceResult result =
        latency::write_trace(ticks, latency::publications_of(record), [&file](std::string_view piece) {
            stop_when_interrupted();
            file.add(piece.data(), piece.size());
        });
    file.commit();
    if (options.quiet) return 0;
    std::cerr << options.out << ": " << ticks.size() << " ticks, " << result.n_events
              << " events; open it at ui.perfetto.dev\n";
    if (result.n_left_out > 0) {
        std::cerr << result.n_left_out << " events with times out of order are left out\n";
    }
    return 0;
}

}  // namespace

void add_trace(CLI::App& palpate, std::function<int()>& chosen) {
    const auto options = std::make_shared<TraceOptions>();
    CLI::App* command = palpate.add_subcommand("trace", "a run over time, for Perfetto");
    command->add_option("record", options->record, "record of a run (.palrec)")->required();
    command->add_option("--out", options->out, "the JSON file to write")->required();
    command->add_option("--from-s", options->from_s, "scene time to begin at, s");
    command->add_option("--to-s", options->to_s, "scene time to end at, s");
    command->add_flag("--quiet", options->quiet, "no words");
    command->footer(TRACE_FOOTER);
    command->callback([options, &chosen] { chosen = [options] { return trace(*options); }; });
}

}  // namespace palpate::app
