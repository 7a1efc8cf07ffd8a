#include "host/study/extreme_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>

#include "host/plate/bounds/bounds.hpp"
#include "host/plate/compliance.hpp"
#include "host/plate/iterative/eq7.hpp"
#include "host/plate/uniform/closed_form.hpp"
#include "host/study/extended.hpp"
#include "host/study/text.hpp"

namespace palpate::study {
namespace {

using Eigen::Index;
using plate::Method;
using plate::Problem;

constexpr double DIRECT_ERROR = 2e-6;  ///< what the guards of MATH.md eq. 5 leave
constexpr double CERES_ERROR = 1e-5;   ///< what palpate-reference stops at
constexpr double TOLERANCE = 1e-6;     ///< of the residual, of the iterative ones
constexpr long SWEEPS_MAX = 20000;
constexpr double ROUNDING = 1e-12;  ///< of the truth and of a bracket's middle

/// c - c_h = r'w* with |r| <= residual at every node and w* about w: what a residual leaves open.
double error_from_residual(double residual, std::span<const double> w, double at_load) {
    const double sum = std::accumulate(w.begin(), w.end(), 0.0,
                                       [](double total, double value) { return total + std::fabs(value); });
    return 2.0 * residual * sum / std::fabs(at_load);
}

Outcome on_grid(Method method, const Problem& problem) {
    const plate::Options options{.tolerance = TOLERANCE, .sweeps_max = SWEEPS_MAX};
    const auto solver = plate::make_solver(method, problem, options);
    const std::vector<double> force = centre_force(problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols());
    std::vector<double> w(force.size());
    const plate::Report report = solver->solve(force, w);
    const auto load = static_cast<std::size_t>(std::max_element(force.begin(), force.end()) - force.begin());
    Outcome outcome;
    outcome.status = plate::name_of(report.status);
    outcome.m_per_n = w[load];
    outcome.iterations = report.iterations;
    outcome.residual = report.residual;
    if (method == Method::cholesky || method == Method::eigen) outcome.stated_error = DIRECT_ERROR;
    if (method == Method::multigrid || method == Method::jacobi || method == Method::damped_jacobi)
        outcome.stated_error = error_from_residual(report.residual, w, w[load]);
    if (method == Method::eq7) outcome.stated_error = plate::EQ7_OFF_ENERGY_FORM;
    return outcome;
}

Outcome by_bounds(const Problem& problem) {
    const std::vector<double> force = centre_force(problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols());
    if (const auto words = plate::problem_with(problem)) throw std::invalid_argument(*words);
    const plate::Bracket bracket = plate::bracket(problem, force);
    Outcome outcome;
    outcome.m_per_n = bracket.middle_m_per_n();
    outcome.stated_error = bracket.relative_error();
    return outcome;
}

Outcome by_ceres(const Problem& problem, const Oracle& oracle) {
    if (!can_ask_oracle(problem)) throw std::invalid_argument("palpate-reference has no such plates");
    if (const auto words = plate::problem_with(problem)) throw std::invalid_argument(*words);
    Outcome outcome;
    try {
        outcome.m_per_n = oracle("plate", oracle_request(problem)).at("compliance_m_per_n").get<double>();
        outcome.stated_error = CERES_ERROR;
    } catch (const OracleError& error) {
        outcome.status = "guard";
        outcome.words = error.what();
    }
    return outcome;
}

Outcome by_compliance(const plate::Sheet& sheet, const Problem& problem) {
    const std::array<plate::Load, 1> load{{{.at_m = 0.5 * sheet.size_m}}};
    const plate::Compliance answer =
        plate::compliance(sheet, {problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols()}, load,
                          {.tolerance = 1e-4, .method = Method::cholesky});
    Outcome outcome;
    outcome.status = plate::name_of(answer.status);
    outcome.m_per_n = answer.m_per_n;
    outcome.stated_error = answer.relative_error;
    return outcome;
}

double closed_form_m_per_n(const plate::Sheet& sheet) {
    const Eigen::Vector2d centre = 0.5 * sheet.size_m;
    const plate::UniformPlate uniform{.size_m = sheet.size_m,
                                      .rigidity_n_m = sheet.rigidity_n_m(centre.x(), centre.y()),
                                      .edges = sheet.edges};
    return plate::UniformSolution(uniform, {.at_m = centre}).compliance().m_per_n;
}

struct Entrant {
    const char* name;
    std::optional<Method> method;  ///< on the grid
};
constexpr std::array ENTRANTS{
    Entrant{"compliance", std::nullopt},     Entrant{"cholesky", Method::cholesky},
    Entrant{"multigrid", Method::multigrid}, Entrant{"eigen", Method::eigen},
    Entrant{"bounds", std::nullopt},         Entrant{"damped-jacobi", Method::damped_jacobi},
    Entrant{"jacobi", Method::jacobi},       Entrant{"eq7", Method::eq7},
    Entrant{"ceres", std::nullopt}};

/// nullopt: this method has nothing to do with such a case.
std::optional<Outcome> outcome_on(const Entrant& entrant, const ExtremeCase& extreme, const Oracle& oracle) {
    const std::string name = entrant.name;
    if (entrant.method) return outcome_of([&] { return on_grid(*entrant.method, extreme.problem); });
    if (name == "bounds") return outcome_of([&] { return by_bounds(extreme.problem); });
    if (name == "compliance") {
        if (!extreme.sheet) return std::nullopt;
        return outcome_of([&] { return by_compliance(*extreme.sheet, extreme.problem); });
    }
    if (!oracle || extreme.problem.rigidity_n_m.size() > 65 * 65 || !can_ask_oracle(extreme.problem))
        return std::nullopt;
    return outcome_of([&] { return by_ceres(extreme.problem, oracle); });
}

bool named(const std::vector<std::string>& names, const std::string& name) {
    return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

const char* name_of(Finding finding) {
    switch (finding) {
        case Finding::holds:
            return "holds";
        case Finding::refused:
            return "refused";
        case Finding::guarded:
            return "guarded";
        case Finding::status:
            return "status";
        case Finding::silent:
            return "silent";
    }
    return "unknown";
}

std::vector<std::string> extreme_methods() {
    std::vector<std::string> names;
    names.reserve(ENTRANTS.size());
    for (const Entrant& entrant : ENTRANTS) names.emplace_back(entrant.name);
    return names;
}

ExtremeRow judged(const ExtremeCase& extreme, const std::string& method, const Outcome& outcome,
                  double truth_m_per_n) {
    ExtremeRow row;
    row.group = extreme.group;
    row.name = extreme.name;
    row.method = method;
    row.words = outcome.words;
    row.m_per_n = outcome.m_per_n;
    row.truth_m_per_n = truth_m_per_n;
    row.error = std::fabs(outcome.m_per_n / truth_m_per_n - 1.0);
    if (outcome.status == "refused" || outcome.status == "guard") {
        row.finding = outcome.status == "refused" ? Finding::refused : Finding::guarded;
        return row;
    }
    if (outcome.status != "solved") {
        row.finding = Finding::status;
        row.words = outcome.status;
        row.error = std::numeric_limits<double>::quiet_NaN();
        return row;
    }
    if (extreme.judge == Judge::refusal) {
        row.finding = Finding::silent;
        row.words = "a number for a problem that has none";
        return row;
    }
    row.stated_error = outcome.stated_error.value_or(0.0);
    row.finding = row.error <= row.stated_error + ROUNDING ? Finding::holds : Finding::silent;
    return row;
}

std::vector<ExtremeRow> run(const ExtremeStudy& study, const Oracle& oracle,
                            const std::function<void(const std::string&)>& watch) {
    std::vector<ExtremeRow> rows;
    for (const ExtremeCase& extreme : extreme_cases(study.nodes)) {
        if (!named(study.groups, extreme.group)) continue;
        watch(extreme.group + ": " + extreme.name);
        const bool known = extreme.judge != Judge::refusal;
        const double none = std::numeric_limits<double>::quiet_NaN();
        const double on_grid_m_per_n = known ? extended_centre_compliance_m_per_n(extreme.problem) : none;
        const double continuum_m_per_n = extreme.sheet ? closed_form_m_per_n(*extreme.sheet) : none;
        for (const Entrant& entrant : ENTRANTS) {
            if (!named(study.methods, entrant.name)) continue;
            watch(extreme.group + ": " + extreme.name + ", " + entrant.name);
            const bool continuum = std::string(entrant.name) == "compliance";
            const double truth = continuum ? continuum_m_per_n : on_grid_m_per_n;
            if (const auto outcome = outcome_on(entrant, extreme, oracle)) {
                rows.push_back(judged(extreme, entrant.name, *outcome, truth));
                rows.back().grid_error = std::fabs(on_grid_m_per_n / continuum_m_per_n - 1.0);
                rows.back().truth_how = !known ? "none" : continuum ? "closed form" : "113 bits";
            }
        }
    }
    return rows;
}

}  // namespace palpate::study
