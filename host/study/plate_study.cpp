#include "host/study/plate_study.hpp"

#include <algorithm>
#include <array>

namespace palpate::study {
namespace {

using Eigen::Index;

constexpr std::array<const char*, 2> CHOLMOD{"simplicial", "supernodal"};
const std::string CHOLMOD_PREFIX = "cholmod-";

bool named(const std::vector<std::string>& names, const std::string& name) {
    return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

/// One plate: its truth, and its rows.
class Bench {
public:
    Bench(const PlateStudy& study, const Oracle& oracle, const Watch& watch, const RigidityField& field,
          double side_over_l)
        : study_(study),
          oracle_(oracle),
          watch_(watch),
          field_(field),
          side_over_l_(side_over_l),
          sheet_(sheet_of(field, side_over_l)),
          name_(field.name + (side_over_l > 0.0 ? " on a foundation" : "")) {
        watch_(name_ + ": the truth");
        truth_ = continuum_truth(field, sheet_, study.reference_nodes_max);
    }

    void add_rows(Index nodes, const std::vector<Contestant>& contestants,
                  std::vector<PlateRow>& rows) const {
        watch_(name_ + ", " + std::to_string(nodes) + " nodes: the truth on the grid");
        const plate::Problem problem = plate::on_grid(sheet_, nodes, nodes);
        const std::optional<Truth> discrete = discrete_truth(problem, oracle_);
        const auto judged = [&](PlateRow row) {
            judge(row, discrete);
            rows.push_back(std::move(row));
        };
        for (const Contestant& contestant : contestants) {
            if (!named(study_.methods, contestant.name)) continue;
            if (contestant.uniform_only && (!field_.uniform || nodes != study_.nodes.front())) continue;
            watch_(name_ + ", " + std::to_string(nodes) + " nodes: " + contestant.name);
            judged(row_of(contestant, nodes));
        }
        if (!oracle_ || !can_ask_oracle(problem)) return;
        const auto wanted = [&](const char* kind) { return named(study_.methods, CHOLMOD_PREFIX + kind); };
        if (std::none_of(CHOLMOD.begin(), CHOLMOD.end(), wanted)) return;
        watch_(name_ + ", " + std::to_string(nodes) + " nodes: CHOLMOD");
        Json request = oracle_request(problem);
        request["budget_s"] = study_.budget_s;
        Json answer;
        std::string refused;
        try {
            answer = oracle_("cholmod", request);
        } catch (const OracleError& error) {
            refused = error.what();
        }
        for (const char* kind : CHOLMOD) {
            if (!wanted(kind)) continue;
            PlateRow row = blank(CHOLMOD_PREFIX + kind, nodes);
            row.outcome.status = "refused";
            row.outcome.words = refused;
            judged(refused.empty() ? cholmod_row(kind, answer, nodes) : row);
        }
    }

private:
    [[nodiscard]] PlateRow blank(const std::string& method, Index nodes) const {
        PlateRow row;
        row.field = field_.name;
        row.side_over_l = side_over_l_;
        row.method = method;
        row.nodes = nodes;
        row.constructs = field_.on_lines;
        return row;
    }

    [[nodiscard]] PlateRow row_of(const Contestant& contestant, Index nodes) const {
        PlateRow row = blank(contestant.name, contestant.uniform_only ? 0 : nodes);
        const std::size_t before = heap_in_use_bytes();
        std::function<Outcome()> call;
        row.outcome = outcome_of([&] {
            call = contestant.prepare(
                {.sheet = sheet_, .on_lines = field_.on_lines, .nodes = nodes, .budget_s = study_.sweeps_s});
            return Outcome{};
        });
        if (!call) return row;
        const Timing timing =
            timed([&] { row.outcome = outcome_of(call); }, study_.budget_s, [&] { watch_(""); });
        const std::size_t after = heap_in_use_bytes();
        row.memory_bytes = after > before ? after - before : 0;
        row.memory_how = "kept";
        if (row.outcome.status != "refused" && row.outcome.status != "guard") row.timing = timing;
        return row;
    }

    [[nodiscard]] PlateRow cholmod_row(const std::string& kind, const Json& answer, Index nodes) const {
        PlateRow row = blank(CHOLMOD_PREFIX + kind, nodes);
        const Json& of = answer.at(kind);
        row.outcome.m_per_n = of.at("compliance_m_per_n").get<double>();
        row.outcome.kernel = answer.at("blas").get<std::string>();
        row.timing.first_s = of.at("first_s").get<double>();
        row.timing.wall_s = {of.at("quartile_1_s").get<double>(), of.at("median_s").get<double>(),
                             of.at("quartile_3_s").get<double>()};
        row.timing.repeats = of.at("repeats").get<std::size_t>();
        row.memory_bytes = of.at("memory_peak_bytes").get<std::size_t>();
        row.memory_how = "peak";
        return row;
    }

    /// Errors, where there is a number that is not the truth's own.
    void judge(PlateRow& row, const std::optional<Truth>& discrete) const {
        const double c = row.outcome.m_per_n;
        row.truth = truth_;
        const bool own = row.method == "cholesky-extrapolated" &&
                         truth_.how.rfind("extrapolated from " + std::to_string(row.nodes) + " ", 0) == 0;
        if (own) row.truth.reset();
        if (row.method == "closed-form")
            row.truth = extrapolated_truth(field_, sheet_, study_.reference_nodes_max);
        if (row.truth) row.error = std::fabs(c / row.truth->m_per_n - 1.0);
        const bool of_grid = row.nodes > 0 && row.method != "cholesky-extrapolated" && row.method != "eq7";
        if (!discrete || !of_grid) return;
        row.discrete_error = std::fabs(c / discrete->m_per_n - 1.0);
        row.discrete_by = discrete->how;
    }

    const PlateStudy& study_;
    const Oracle& oracle_;
    const Watch& watch_;
    const RigidityField& field_;
    double side_over_l_;
    plate::Sheet sheet_;
    std::string name_;
    Truth truth_{};
};

std::optional<std::string> unknown(const std::vector<std::string>& asked,
                                   const std::vector<std::string>& known, const std::string& what) {
    for (const std::string& name : asked) {
        if (std::find(known.begin(), known.end(), name) != known.end()) continue;
        std::string words = "no " + what + " '" + name + "'; there are";
        for (const std::string& one : known) words += " " + one;
        return words;
    }
    return std::nullopt;
}

}  // namespace

std::vector<std::string> field_names() {
    std::vector<std::string> names;
    for (const RigidityField& field : rigidity_fields()) names.push_back(field.name);
    return names;
}

std::vector<std::string> method_names() {
    std::vector<std::string> names;
    for (const Contestant& contestant : contestants()) names.push_back(contestant.name);
    for (const char* kind : CHOLMOD) names.push_back(CHOLMOD_PREFIX + kind);
    return names;
}

std::optional<std::string> problem_with(const PlateStudy& study) {
    if (auto words = unknown(study.fields, field_names(), "field")) return words;
    if (auto words = unknown(study.methods, method_names(), "method")) return words;
    if (study.nodes.empty()) return "no grid";
    for (const Index nodes : study.nodes) {
        if (nodes < 9 || nodes > 513 || nodes % 8 != 1)
            return "nodes " + std::to_string(nodes) + "; must be 8 m + 1 between 9 and 513";
    }
    if (!(study.budget_s > 0.0 && study.sweeps_s > 0.0)) return "the budgets must be positive";
    return std::nullopt;
}

std::vector<PlateRow> run(const PlateStudy& study, const Oracle& oracle, const Watch& watch) {
    if (const auto words = problem_with(study)) throw std::invalid_argument(*words);
    std::vector<PlateRow> rows;
    const std::vector<Contestant> all = contestants();  // once: they keep what one grid has in common
    for (const RigidityField& field : rigidity_fields()) {
        if (!named(study.fields, field.name)) continue;
        for (const double side_over_l : {0.0, FOUNDATION_SIDE_OVER_L}) {
            if (side_over_l > 0.0 ? !study.on_foundation : !study.bare) continue;
            const Bench bench(study, oracle, watch, field, side_over_l);
            for (const Index nodes : study.nodes) bench.add_rows(nodes, all, rows);
            if (field.name != study.cost_field || side_over_l > 0.0) continue;
            for (const Index nodes : study.cost_nodes) {
                if (nodes > study.nodes.back()) bench.add_rows(nodes, all, rows);
            }
        }
    }
    return rows;
}

}  // namespace palpate::study
