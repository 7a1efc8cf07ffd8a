#include "host/study/plate_results.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/study/plate_tables.hpp"
#include "host/study/text.hpp"

namespace palpate::study {
namespace {

constexpr double PAPER_S = 0.160, HAPTIC_S = 1e-3;
constexpr double NONE = std::numeric_limits<double>::quiet_NaN();

double truth_of(const PlateRow& row, double Truth::*member) {
    return row.truth ? (*row.truth).*member : NONE;
}

/// One column of results.csv and one member of a row in results.json.
struct Column {
    const char* name;
    double (*number)(const PlateRow&);     ///< either this
    std::string (*text)(const PlateRow&);  ///< or that
};

double timed_or_nan(const PlateRow& row, double value) {
    return row.timing.repeats > 0 ? value : NONE;
}

const std::vector<Column>& columns() {
    static const std::vector<Column> all{
        {"field", nullptr, [](const PlateRow& r) { return r.field; }},
        {"side_over_l", [](const PlateRow& r) { return r.side_over_l; }, nullptr},
        {"method", nullptr, [](const PlateRow& r) { return r.method; }},
        {"nodes", [](const PlateRow& r) { return r.nodes > 0 ? static_cast<double>(r.nodes) : NONE; },
         nullptr},
        {"status", nullptr, [](const PlateRow& r) { return r.outcome.status; }},
        {"error_relative", [](const PlateRow& r) { return r.error; }, nullptr},
        {"reference_error_relative", [](const PlateRow& r) { return truth_of(r, &Truth::relative_error); },
         nullptr},
        {"discrete_error_relative", [](const PlateRow& r) { return r.discrete_error; }, nullptr},
        {"stated_error_relative", [](const PlateRow& r) { return r.outcome.stated_error.value_or(NONE); },
         nullptr},
        {"median_s", [](const PlateRow& r) { return timed_or_nan(r, r.timing.wall_s.median); }, nullptr},
        {"quartile_1_s", [](const PlateRow& r) { return timed_or_nan(r, r.timing.wall_s.low); }, nullptr},
        {"quartile_3_s", [](const PlateRow& r) { return timed_or_nan(r, r.timing.wall_s.high); }, nullptr},
        {"first_s", [](const PlateRow& r) { return timed_or_nan(r, r.timing.first_s); }, nullptr},
        {"repeats", [](const PlateRow& r) { return static_cast<double>(r.timing.repeats); }, nullptr},
        {"iterations", [](const PlateRow& r) { return static_cast<double>(r.outcome.iterations); }, nullptr},
        {"residual_relative", [](const PlateRow& r) { return r.outcome.residual; }, nullptr},
        {"memory_bytes",
         [](const PlateRow& r) { return r.memory_bytes > 0 ? static_cast<double>(r.memory_bytes) : NONE; },
         nullptr},
        {"memory_how", nullptr, [](const PlateRow& r) { return r.memory_how; }},
        {"kernel", nullptr, [](const PlateRow& r) { return r.outcome.kernel; }},
        {"timed", nullptr,
         [](const PlateRow& r) { return std::string(r.constructs ? "new-problem" : "new-rigidity"); }},
        {"compliance_m_per_n", [](const PlateRow& r) { return r.outcome.m_per_n; }, nullptr},
        {"reference_m_per_n", [](const PlateRow& r) { return truth_of(r, &Truth::m_per_n); }, nullptr},
        {"reference_how", nullptr, [](const PlateRow& r) { return r.truth ? r.truth->how : std::string(); }},
        {"discrete_reference_how", nullptr, [](const PlateRow& r) { return r.discrete_by; }},
        {"words", nullptr, [](const PlateRow& r) { return r.outcome.words; }},
    };
    return all;
}

/// Why a number of a row is not there.
std::string why_none(const PlateRow& row, const std::string& name) {
    if (!std::isfinite(row.outcome.m_per_n)) {
        return row.outcome.words.empty() ? "no number: " + row.outcome.status : row.outcome.words;
    }
    if (name == "nodes") return "no grid";
    if (name == "error_relative" || name.rfind("reference", 0) == 0) return "the row is the reference itself";
    if (name == "discrete_error_relative")
        return "no independent number for this grid, or another discrete plate";
    if (name == "stated_error_relative") return "the method states none";
    if (name == "residual_relative") return "not asked of this method";
    return "not measured";
}

Json row_json(const PlateRow& row) {
    Json json;
    for (const Column& column : columns()) {
        if (column.text != nullptr) {
            json[column.name] = column.text(row);
            continue;
        }
        const double value = column.number(row);
        json[column.name] = number_json(value);
        if (!std::isfinite(value)) json[std::string(column.name) + "_why"] = why_none(row, column.name);
    }
    return json;
}

Json best_json(const WithinTime::Best& best) {
    if (!std::isfinite(best.error)) return nullptr;
    return {{"nodes", best.nodes},
            {"time_s", best.time_s},
            {"error_relative", best.error},
            {"reference_error_relative", best.reference_error},
            {"status", best.status}};
}

Json within_json(std::span<const PlateRow> rows, double time_s) {
    Json lines = Json::array();
    for (const WithinTime& line : within_time(rows, time_s)) {
        lines.push_back({{"method", line.method},
                         {"hyperbolic", best_json(line.smooth)},
                         {"random", best_json(line.rough)},
                         {"nodule_on_foundation", best_json(line.founded)}});
    }
    return {{"time_s", time_s}, {"why_null", "no row of the method was done in that time"}, {"lines", lines}};
}

/// The field whose cost is told: the one with most grids.
std::string cost_field(std::span<const PlateRow> rows) {
    std::string best;
    Eigen::Index most = 0;
    for (const PlateRow& row : rows) {
        if (row.side_over_l != 0.0 || row.nodes <= most) continue;
        most = row.nodes;
        best = row.field;
    }
    return best;
}

std::string best_text(const WithinTime::Best& best) {
    if (!std::isfinite(best.error)) return best.status.empty() ? "-" : best.status;
    const bool known = best.error >= best.reference_error;
    return (known ? number_text(best.error, 2) : "<= " + number_text(best.reference_error, 2)) + " (" +
           (best.nodes > 0 ? "n = " + std::to_string(best.nodes) + ", " : "") + time_text(best.time_s) +
           (best.status == "solved" ? ")" : ", " + best.status + ")");
}

std::string within_markdown(std::span<const PlateRow> rows, double time_s) {
    std::string text =
        "What " + time_text(time_s) +
        " buys: the smallest error of the continuum's compliance, its grid, its time. <=: no larger than "
        "the reference's own error. A small error may be luck: two errors that cancel.\n\n"
        "| method | hyperbolic | random | nodule on a foundation |\n|---|---|---|---|\n";
    for (const WithinTime& line : within_time(rows, time_s)) {
        text += "| " + line.method + " | " + best_text(line.smooth) + " | " + best_text(line.rough) + " | " +
                best_text(line.founded) + " |\n";
    }
    return text + "\n";
}

std::string cost_markdown(std::span<const PlateRow> rows) {
    const std::string field = cost_field(rows);
    std::string text = "Cost against n nodes a side, field " + field +
                       ", bare, solved rows: time = factor n^exponent\n\n"
                       "| method | exponent | at |\n|---|---|---|\n";
    for (const Cost& cost : cost_against_nodes(rows, field)) {
        text += "| " + cost.method + " | ";
        text += cost.law
                    ? number_text(cost.law->exponent, 3) + " +- " + number_text(cost.law->exponent_error, 2)
                    : "-";
        text += " |";
        for (std::size_t i = 0; i < cost.nodes.size(); ++i)
            text += " " + std::to_string(cost.nodes[i]) + ": " + time_text(cost.median_s[i]);
        text += " |\n";
    }
    return text;
}

}  // namespace

std::string results_csv(std::span<const PlateRow> rows) {
    std::string csv;
    for (const Column& column : columns()) csv += (csv.empty() ? "" : ",") + std::string(column.name);
    csv += '\n';
    for (const PlateRow& row : rows) {
        bool first = true;
        for (const Column& column : columns()) {
            if (!first) csv += ',';
            first = false;
            csv += column.text != nullptr ? cell(column.text(row)) : number_text(column.number(row), 12);
        }
        csv += '\n';
    }
    return csv;
}

Json results_json(const Json& about, std::span<const PlateRow> rows) {
    Json json = about;
    json["rows"] = Json::array();
    for (const PlateRow& row : rows) json["rows"].push_back(row_json(row));
    json["within_160_ms"] = within_json(rows, PAPER_S);
    json["within_1_ms"] = within_json(rows, HAPTIC_S);
    json["cost_field"] = cost_field(rows);
    json["cost"] = Json::array();
    for (const Cost& cost : cost_against_nodes(rows, cost_field(rows))) {
        Json line = {{"method", cost.method},
                     {"nodes", cost.nodes},
                     {"median_s", cost.median_s},
                     {"exponent", cost.law ? Json(cost.law->exponent) : Json(nullptr)}};
        if (cost.law) {
            line["exponent_standard_error"] = cost.law->exponent_error;
        } else {
            line["exponent_why"] = "fewer than three grids were solved in the time given";
        }
        json["cost"].push_back(line);
    }
    return json;
}

std::string results_markdown(std::span<const PlateRow> rows) {
    return within_markdown(rows, PAPER_S) + within_markdown(rows, HAPTIC_S) + cost_markdown(rows);
}

}  // namespace palpate::study
