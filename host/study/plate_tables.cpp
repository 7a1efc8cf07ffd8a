#include "host/study/plate_tables.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::study {
namespace {

std::vector<std::string> methods_in(std::span<const PlateRow> rows) {
    std::vector<std::string> names;
    for (const PlateRow& row : rows) {
        if (std::find(names.begin(), names.end(), row.method) == names.end()) names.push_back(row.method);
    }
    return names;
}

void improve(WithinTime::Best& best, const PlateRow& row) {
    if (row.outcome.status == "diverged") {
        if (best.status.empty()) best.status = row.outcome.status;
        return;
    }
    if (!std::isfinite(row.error) || best.error <= row.error) return;
    best = {row.nodes, row.timing.wall_s.median, row.error, row.truth ? row.truth->relative_error : 0.0,
            row.outcome.status};
}

}  // namespace

std::vector<WithinTime> within_time(std::span<const PlateRow> rows, double time_s) {
    std::vector<WithinTime> table;
    for (const std::string& method : methods_in(rows)) {
        WithinTime line{.method = method, .smooth = {}, .rough = {}, .founded = {}};
        for (const PlateRow& row : rows) {
            if (row.method != method || row.timing.repeats == 0 || !(row.timing.wall_s.median <= time_s))
                continue;
            const bool bare = row.side_over_l == 0.0;
            if (row.field == "hyperbolic" && bare) improve(line.smooth, row);
            if (row.field == "random" && bare) improve(line.rough, row);
            if (row.field == "nodule" && !bare) improve(line.founded, row);
        }
        table.push_back(line);
    }
    return table;
}

std::vector<Cost> cost_against_nodes(std::span<const PlateRow> rows, const std::string& field) {
    std::vector<Cost> costs;
    for (const std::string& method : methods_in(rows)) {
        Cost cost{.method = method, .nodes = {}, .median_s = {}, .law = std::nullopt};
        std::vector<double> n;
        for (const PlateRow& row : rows) {
            if (row.method != method || row.field != field || row.side_over_l != 0.0 || row.nodes == 0)
                continue;
            if (row.outcome.status != "solved" || row.timing.repeats == 0) continue;
            cost.nodes.push_back(row.nodes);
            cost.median_s.push_back(row.timing.wall_s.median);
            n.push_back(static_cast<double>(row.nodes));
        }
        cost.law = power_law(n, cost.median_s);
        if (!cost.nodes.empty()) costs.push_back(cost);
    }
    return costs;
}

std::vector<PlateRow> comparable(std::span<const PlateRow> rows, const std::string& field,
                                 double side_over_l) {
    std::vector<PlateRow> chosen;
    for (const PlateRow& row : rows) {
        if (row.field == field && row.side_over_l == side_over_l && std::isfinite(row.error) &&
            row.timing.repeats > 0 && row.outcome.status != "diverged") {
            chosen.push_back(row);
        }
    }
    return chosen;
}

std::vector<Trade> trades_of(std::span<const PlateRow> rows) {
    std::vector<Trade> trades;
    for (const PlateRow& row : rows) trades.push_back({row.timing.wall_s.median, row.error});
    return trades;
}

}  // namespace palpate::study
