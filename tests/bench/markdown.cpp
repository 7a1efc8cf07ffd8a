#include "tests/bench/markdown.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ostream>
#include <set>
#include <utility>

#include "tests/bench/measure.hpp"

namespace palpate::bench {
namespace {

std::string three_digits(double value) {
    std::array<char, 32> text{};
    const double size = std::fabs(value);
    if (size != 0.0 && size < 0.1) {
        std::snprintf(text.data(), text.size(), "%.1e", value);
    } else {
        const bool whole = value == std::floor(value);
        const int decimals = whole || size >= 100.0 ? 0 : (size >= 10.0 ? 1 : 2);
        std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
    }
    return text.data();
}

bool is_time(const std::string& counter) {
    return counter.ends_with("_s");
}

/// What the numbers of a cell are multiplied by, and its unit.
std::pair<double, std::string> unit_for(const std::string& counter, double value) {
    if (!is_time(counter)) return {1.0, ""};
    if (value < 1e-6) return {1e9, " ns"};
    if (value < 1e-3) return {1e6, " us"};
    return value < 1.0 ? std::pair{1e3, " ms"} : std::pair{1.0, " s"};
}

std::string cell(const std::string& counter, const std::vector<double>& values) {
    const double middle = quantile(values, 0.5);
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    const auto [factor, unit] = unit_for(counter, middle);
    const std::string text = three_digits(factor * middle) + unit;
    const std::string low = three_digits(factor * *least), high = three_digits(factor * *most);
    return low == high ? text : text + " (" + low + " .. " + high + ")";
}

std::string heading(std::string counter) {
    if (is_time(counter)) counter.resize(counter.size() - 2);
    std::replace(counter.begin(), counter.end(), '_', ' ');
    return counter;
}

}  // namespace

Markdown::Markdown(std::ostream& out, std::map<std::string, std::string> titles)
    : out_(&out), titles_(std::move(titles)) {}

bool Markdown::ReportContext(const Context&) {
    return true;
}

void Markdown::ReportRuns(const std::vector<Run>& runs) {
    for (const Run& run : runs) {
        if (run.run_type != Run::RT_Iteration) continue;
        const std::string& whole = run.run_name.function_name;
        const std::size_t slash = whole.find('/');
        Row& row = rows_[run.family_index];
        row.group = whole.substr(0, slash);
        row.name = whole.substr(slash + 1);
        for (const auto& [counter, value] : run.counters) row.values[counter].push_back(value.value);
    }
}

void Markdown::print_group(const std::string& group) const {
    std::set<std::string> counters;
    for (const auto& [index, row] : rows_) {
        if (row.group != group) continue;
        for (const auto& [counter, values] : row.values) counters.insert(counter);
    }
    const auto title = titles_.find(group);
    *out_ << "\n**" << (title == titles_.end() ? group : title->second) << "**\n\n| " << group << " |";
    for (const std::string& counter : counters) *out_ << ' ' << heading(counter) << " |";
    *out_ << "\n|---|";
    for (std::size_t i = 0; i < counters.size(); ++i) *out_ << "---|";
    *out_ << '\n';
    for (const auto& [index, row] : rows_) {
        if (row.group != group) continue;
        *out_ << "| " << row.name << " |";
        for (const std::string& counter : counters) {
            const auto found = row.values.find(counter);
            *out_ << ' ' << (found == row.values.end() ? "" : cell(counter, found->second)) << " |";
        }
        *out_ << '\n';
    }
}

void Markdown::Finalize() {
    std::set<std::string> printed;
    for (const auto& [index, row] : rows_) {
        if (printed.insert(row.group).second) print_group(row.group);
    }
    out_->flush();
}

}  // namespace palpate::bench
