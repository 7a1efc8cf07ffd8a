/// Events of a trace in the order of their times: the JSON of chrome://tracing, which Perfetto reads ("Trace
/// Event Format", Google).
#pragma once
#include <cstdint>
#include <functional>
#include <queue>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::latency {

/// One row of the picture.
struct Track {
    int process, thread;
};

/// Where an asynchronous span belongs: spans of one kind share a row, spans of one id follow each other.
struct SpanId {
    int process;
    const char* category;
    std::uint64_t id;
};

/// Takes events in roughly the order of their times and hands them on in exactly that order. `arguments` is
/// the inside of a JSON object, or empty. Times are ns; an event before what is settled is counted and left
/// out.
class TraceWriter {
public:
    using Sink = std::function<void(std::string_view)>;
    /// Begins the document. `head` is the inside of its otherData; `zero_ns` becomes 0.
    TraceWriter(Sink sink, const std::string& head, std::uint64_t zero_ns);
    void name_process(int process, const std::string& name);
    void name_track(Track track, const std::string& name);

    void slice(Track track, const std::string& name, std::uint64_t from_ns, std::uint64_t to_ns,
               const std::string& arguments = "");
    void begin(Track track, const std::string& name, std::uint64_t t_ns, const std::string& arguments = "");
    void end(Track track, std::uint64_t t_ns);
    void instant(Track track, const std::string& name, std::uint64_t t_ns);
    void counter(int process, const std::string& name, std::uint64_t t_ns, double value);
    void span_begin(SpanId id, const std::string& name, std::uint64_t t_ns,
                    const std::string& arguments = "");
    void span_end(SpanId id, const std::string& name, std::uint64_t t_ns);

    /// No event before `t_ns` will come: those that wait are written.
    void settle(std::uint64_t t_ns);
    /// Writes the rest and ends the document.
    void finish();
    [[nodiscard]] std::uint64_t n_events() const { return n_events_; }
    [[nodiscard]] std::uint64_t n_left_out() const { return n_left_out_; }

private:
    struct Event {
        std::uint64_t t_ns, order;
        std::string rest;
        bool operator<(const Event& other) const {
            return t_ns != other.t_ns ? t_ns > other.t_ns : order > other.order;
        }
    };
    void add(std::uint64_t t_ns, std::string rest);
    void line(std::string_view event);
    void write_first();

    Sink sink_;
    std::uint64_t zero_ns_, settled_ns_ = 0, n_added_ = 0, n_events_ = 0, n_left_out_ = 0;
    std::priority_queue<Event> waiting_;
    std::string buffer_;
    bool first_ = true;
};

}  // namespace palpate::latency
