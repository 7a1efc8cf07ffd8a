/// The results as Markdown tables: one per group ("group/name"), a row per benchmark, a column per counter.
#pragma once
#include <benchmark/benchmark.h>

#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

namespace palpate::bench {

/// Each cell is the median over the repetitions and, where they differ, their range. Counters that end in
/// `_s` are times.
class Markdown : public benchmark::BenchmarkReporter {
public:
    /// `titles`: what to print above a group's table.
    Markdown(std::ostream& out, std::map<std::string, std::string> titles);
    bool ReportContext(const Context& context) override;
    void ReportRuns(const std::vector<Run>& runs) override;
    void Finalize() override;

private:
    struct Row {
        std::string group, name;
        std::map<std::string, std::vector<double>> values;  ///< of each counter, one per repetition
    };
    void print_group(const std::string& group) const;

    std::ostream* out_;
    std::map<std::string, std::string> titles_;
    std::map<std::int64_t, Row> rows_;  ///< in the order of registration
};

}  // namespace palpate::bench
