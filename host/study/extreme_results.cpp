#include "host/study/extreme_results.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/study/text.hpp"

namespace palpate::study {
namespace {

void remember(std::vector<std::string>& names, const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

/// What a cell of the table says of a row.
std::string summary(const ExtremeRow& row, std::vector<std::string>& notes) {
    const auto note = [&] {
        remember(notes, row.words);
        const auto at = std::find(notes.begin(), notes.end(), row.words) - notes.begin();
        return " [" + std::to_string(at + 1) + "]";
    };
    switch (row.finding) {
        case Finding::holds:
            return number_text(row.error, 2);
        case Finding::status:
            return row.words;
        case Finding::refused:
            return "refused" + note();
        case Finding::guarded:
            return "guard" + note();
        case Finding::silent:
            return "**SILENT " + number_text(row.error, 2) + "**";
    }
    return "";
}

}  // namespace

std::size_t count_silent(std::span<const ExtremeRow> rows) {
    return static_cast<std::size_t>(std::count_if(
        rows.begin(), rows.end(), [](const ExtremeRow& row) { return row.finding == Finding::silent; }));
}

std::string extreme_csv(std::span<const ExtremeRow> rows) {
    std::string csv =
        "group,case,method,finding,error_relative,stated_error_relative,grid_error_relative,"
        "compliance_m_per_n,reference_m_per_n,reference_how,words\n";
    for (const ExtremeRow& row : rows) {
        csv += row.group + "," + cell(row.name) + "," + row.method + "," + name_of(row.finding);
        for (const double value :
             {row.error, row.stated_error, row.grid_error, row.m_per_n, row.truth_m_per_n}) {
            csv += "," + number_text(value, 12);
        }
        csv += "," + row.truth_how + "," + cell(row.words) + "\n";
    }
    return csv;
}

Json extreme_json(const Json& about, std::span<const ExtremeRow> rows) {
    Json json = about;
    json["silent"] = count_silent(rows);
    json["null_why"] =
        "no number: refused, guarded or not solved; no stated error: no number; no grid error: "
        "the continuum is not known";
    json["rows"] = Json::array();
    for (const ExtremeRow& row : rows) {
        json["rows"].push_back({{"group", row.group},
                                {"case", row.name},
                                {"method", row.method},
                                {"finding", name_of(row.finding)},
                                {"words", row.words},
                                {"error_relative", number_json(row.error)},
                                {"stated_error_relative", number_json(row.stated_error)},
                                {"grid_error_relative", number_json(row.grid_error)},
                                {"compliance_m_per_n", number_json(row.m_per_n)},
                                {"reference_m_per_n", number_json(row.truth_m_per_n)},
                                {"reference_how", row.truth_how}});
    }
    return json;
}

std::string extreme_markdown(std::span<const ExtremeRow> rows) {
    std::vector<std::string> methods, notes;
    for (const ExtremeRow& row : rows) remember(methods, row.method);
    std::string text =
        "Relative error of the centre's compliance about the same grid in 113 bits; `compliance`: "
        "about the continuum. In brackets: a baseline that states no error.\n\n| case | grid |";
    for (const std::string& method : methods) text += " " + method + " |";
    text += "\n|---|---|";
    for (std::size_t i = 0; i < methods.size(); ++i) text += "---|";
    for (std::size_t begin = 0; begin < rows.size();) {
        std::size_t end = begin;
        while (end < rows.size() && rows[end].name == rows[begin].name &&
               rows[end].group == rows[begin].group)
            ++end;
        text += "\n| " + rows[begin].group + ": " + rows[begin].name + " | " +
                number_text(rows[begin].grid_error, 2) + " |";
        for (const std::string& method : methods) {
            const auto row = std::find_if(rows.begin() + static_cast<std::ptrdiff_t>(begin),
                                          rows.begin() + static_cast<std::ptrdiff_t>(end),
                                          [&](const ExtremeRow& r) { return r.method == method; });
            const bool there = row != rows.begin() + static_cast<std::ptrdiff_t>(end);
            text += " " + (there ? summary(*row, notes) : std::string()) + " |";
        }
        begin = end;
    }
    text += "\n\n";
    for (std::size_t i = 0; i < notes.size(); ++i)
        text += "[" + std::to_string(i + 1) + "] " + notes[i] + "\n";
    return text;
}

}  // namespace palpate::study
