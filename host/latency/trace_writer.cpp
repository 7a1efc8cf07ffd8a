#include "host/latency/trace_writer.hpp"

#include <array>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/record/csv.hpp"

namespace palpate::latency {
namespace {

constexpr std::size_t BUFFER_BYTES = 1 << 16;

std::string quoted(const std::string& text) {
    return nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

/// Microseconds with the ns as decimals, exactly.
std::string us_exactly(std::uint64_t ns) {
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "%" PRIu64 ".%03" PRIu64, ns / 1000, ns % 1000);
    return text.data();
}

std::string on(Track track) {
    return "\"pid\":" + std::to_string(track.process) + ",\"tid\":" + std::to_string(track.thread);
}

std::string head_of(const char* phase, const std::string& name) {
    return std::string("\"ph\":\"") + phase + "\",\"name\":" + quoted(name) + ",";
}

std::string with(const std::string& arguments) {
    return arguments.empty() ? "" : ",\"args\":{" + arguments + "}";
}

std::string of_span(const SpanId& id) {
    return "\"cat\":\"" + std::string(id.category) + "\",\"id\":\"" + std::to_string(id.id) +
           "\",\"pid\":" + std::to_string(id.process) + ",\"tid\":0";
}

}  // namespace

TraceWriter::TraceWriter(Sink sink, const std::string& head, std::uint64_t zero_ns)
    : sink_(std::move(sink)), zero_ns_(zero_ns), settled_ns_(zero_ns) {
    buffer_ = "{\"displayTimeUnit\":\"ms\",\"otherData\":{" + head + "},\"traceEvents\":[\n";
}

void TraceWriter::name_process(int process, const std::string& name) {
    line("{\"ph\":\"M\",\"name\":\"process_name\",\"pid\":" + std::to_string(process) +
         ",\"args\":{\"name\":" + quoted(name) + "}}");
}

void TraceWriter::name_track(Track track, const std::string& name) {
    line("{\"ph\":\"M\",\"name\":\"thread_name\"," + on(track) + ",\"args\":{\"name\":" + quoted(name) +
         "}}");
    line("{\"ph\":\"M\",\"name\":\"thread_sort_index\"," + on(track) +
         ",\"args\":{\"sort_index\":" + std::to_string(track.thread) + "}}");
}

void TraceWriter::slice(Track track, const std::string& name, std::uint64_t from_ns, std::uint64_t to_ns,
                        const std::string& arguments) {
    if (to_ns < from_ns) {
        ++n_left_out_;
        return;
    }
    add(from_ns,
        head_of("X", name) + "\"dur\":" + us_exactly(to_ns - from_ns) + "," + on(track) + with(arguments));
}

void TraceWriter::begin(Track track, const std::string& name, std::uint64_t t_ns,
                        const std::string& arguments) {
    add(t_ns, head_of("B", name) + on(track) + with(arguments));
}

void TraceWriter::end(Track track, std::uint64_t t_ns) {
    add(t_ns, "\"ph\":\"E\"," + on(track));
}

void TraceWriter::instant(Track track, const std::string& name, std::uint64_t t_ns) {
    add(t_ns, head_of("i", name) + "\"s\":\"t\"," + on(track));
}

void TraceWriter::counter(int process, const std::string& name, std::uint64_t t_ns, double value) {
    if (!std::isfinite(value)) {
        ++n_left_out_;
        return;
    }
    std::string number;
    record::append_number(number, static_cast<double>(static_cast<float>(value)));  // short, and enough
    add(t_ns, head_of("C", name) + "\"pid\":" + std::to_string(process) + with("\"value\":" + number));
}

void TraceWriter::span_begin(SpanId id, const std::string& name, std::uint64_t t_ns,
                             const std::string& arguments) {
    add(t_ns, head_of("b", name) + of_span(id) + with(arguments));
}

void TraceWriter::span_end(SpanId id, const std::string& name, std::uint64_t t_ns) {
    add(t_ns, head_of("e", name) + of_span(id));
}

void TraceWriter::add(std::uint64_t t_ns, std::string rest) {
    if (t_ns < settled_ns_) {
        ++n_left_out_;
        return;
    }
    waiting_.push({t_ns, n_added_++, std::move(rest)});
}

void TraceWriter::line(std::string_view event) {
    if (!first_) buffer_ += ",\n";
    first_ = false;
    buffer_ += event;
    if (buffer_.size() < BUFFER_BYTES) return;
    sink_(buffer_);
    buffer_.clear();
}

void TraceWriter::write_first() {
    const Event& event = waiting_.top();
    line("{\"ts\":" + us_exactly(event.t_ns - zero_ns_) + "," + event.rest + "}");
    ++n_events_;
    waiting_.pop();
}

void TraceWriter::settle(std::uint64_t t_ns) {
    if (t_ns <= settled_ns_) return;
    settled_ns_ = t_ns;
    while (!waiting_.empty() && waiting_.top().t_ns < t_ns) write_first();
}

void TraceWriter::finish() {
    settled_ns_ = std::numeric_limits<std::uint64_t>::max();
    while (!waiting_.empty()) write_first();
    buffer_ += "\n]}\n";
    sink_(buffer_);
    buffer_.clear();
}

}  // namespace palpate::latency
