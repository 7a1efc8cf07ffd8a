#include "host/study/extreme_study.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <sstream>

#include "host/study/extended.hpp"
#include "host/study/extreme_results.hpp"
#include "host/study/plates.hpp"

namespace palpate::study {
namespace {

using Catch::Matchers::Contains;

plate::Problem unit_square(Eigen::Index nodes, const plate::Field& rigidity) {
    plate::Sheet sheet;
    sheet.size_m = {1.0, 1.0};
    sheet.rigidity_n_m = rigidity;
    return plate::on_grid(sheet, nodes, nodes);
}

std::vector<ExtremeRow> rows_of(const std::string& group) {
    return run(ExtremeStudy{.groups = {group}, .methods = {}, .nodes = 17}, {}, [](const std::string&) {});
}

const ExtremeRow& row_of(const std::vector<ExtremeRow>& rows, const std::string& name,
                         const std::string& method) {
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const ExtremeRow& r) {
        return r.method == method && r.name.find(name) != std::string::npos;
    });
    REQUIRE(row != rows.end());
    return *row;
}

TEST_CASE("113 bits find the compliances that were computed elsewhere") {
    struct Anchor {
        Eigen::Index nodes;
        plate::Field rigidity;
        double m_per_n;
    };
    const Anchor anchor = GENERATE(
        as<Anchor>{}, Anchor{17, [](double, double) { return 1.0; }, 5.893088423e-3},
        Anchor{33, [](double, double) { return 1.0; }, 5.696151392e-3},
        Anchor{17, [](double x, double) { return 10.0 / (1.0 + 9.0 * x); }, 2.883232925e-3},
        Anchor{17, [](double x, double) { return 1.0 + 9.0 * x; }, 1.140287018e-3},
        Anchor{17, [](double x, double) { return x > 0.4 ? 1e3 : 1.0; }, 1.338722452e-5},
        Anchor{17, [](double x, double z) { return x == 0.5 && z == 0.5 ? 0.5 : 1.0; }, 6.362091482e-3});
    // Half of the last digit given is up to 4.4e-10 of the value.
    CHECK(extended_centre_compliance_m_per_n(unit_square(anchor.nodes, anchor.rigidity)) ==
          Approx(anchor.m_per_n).epsilon(5e-10));
}

TEST_CASE("113 bits do not mind which way the plate lies") {
    plate::Problem along = unit_square(17, [](double, double) { return 1.0; });
    along.rigidity_n_m = Eigen::ArrayXXd::Constant(33, 17, 1.0);
    along.size_m = {1.0, 0.7};
    for (Eigen::Index ix = 0; ix < 33; ++ix) along.rigidity_n_m.row(ix) += 0.1 * static_cast<double>(ix);
    plate::Problem across = along;
    across.rigidity_n_m = along.rigidity_n_m.transpose();
    across.size_m = {0.7, 1.0};
    CHECK(extended_centre_compliance_m_per_n(along) ==
          Approx(extended_centre_compliance_m_per_n(across)).epsilon(1e-14));
}

TEST_CASE("113 bits refuse what they do not describe") {
    plate::Problem problem = unit_square(17, [](double x, double) { return x > 0.5 ? 10.0 : 1.0; });
    REQUIRE(problem.harmonic_x_n_m.size() > 0);
    CHECK_THROWS_AS(extended_centre_compliance_m_per_n(problem), std::invalid_argument);
    problem = unit_square(17, [](double, double) { return 1.0; });
    problem.edges[1] = plate::Edge::free;
    CHECK_THROWS_AS(extended_centre_compliance_m_per_n(problem), std::invalid_argument);
}

TEST_CASE("no method is wrong in silence on the small extremes") {
    const std::string group = GENERATE(as<std::string>{}, "one-node", "hole", "bad-input", "poisson");
    const std::vector<ExtremeRow> rows = rows_of(group);
    REQUIRE_FALSE(rows.empty());
    for (const ExtremeRow& row : rows) {
        INFO(row.name << ", " << row.method << ": " << row.error << " of " << row.stated_error << ' '
                      << row.words);
        CHECK(row.finding != Finding::silent);
    }
    CHECK(count_silent(rows) == 0);
}

TEST_CASE("one stiff or soft node makes equation 7 negative, which is said; the energy form holds") {
    const std::vector<ExtremeRow> rows = rows_of("one-node");
    for (const char* const factor : {"0.2", "5"}) {
        const ExtremeRow& eq7 = row_of(rows, std::string("D = ") + factor + " ", "eq7");
        CHECK(eq7.finding == Finding::guarded);
        CHECK_THAT(eq7.words, Contains("negative compliance"));
        CHECK(row_of(rows, std::string("D = ") + factor + " ", "cholesky").finding == Finding::holds);
    }
    for (const char* const factor :
         {"0.5", "2"}) {  // not negative, and wrong by a factor of 40 and by a third
        const ExtremeRow& eq7 = row_of(rows, std::string("D = ") + factor + " ", "eq7");
        CHECK(eq7.finding == Finding::guarded);
        CHECK_THAT(eq7.words, Contains("eq7 cannot be trusted"));
    }
}

TEST_CASE("jacobi says that it diverges, and what has no answer is refused in words") {
    const std::vector<ExtremeRow> rows = rows_of("one-node");
    CHECK(row_of(rows, "D = 2 ", "jacobi").finding == Finding::status);
    CHECK(row_of(rows, "D = 2 ", "jacobi").words == "diverged");
    for (const ExtremeRow& row : rows_of("bad-input")) {
        CHECK(row.finding == Finding::refused);
        CHECK_FALSE(row.words.empty());
    }
}

TEST_CASE("a number above its stated error, or for a problem without an answer, is silence") {
    const std::vector<ExtremeCase> cases = extreme_cases(17);
    const auto of = [&](Judge judge) {
        return *std::find_if(cases.begin(), cases.end(),
                             [&](const ExtremeCase& c) { return c.judge == judge; });
    };
    Outcome outcome;
    outcome.m_per_n = 1.01;
    outcome.stated_error = 2e-2;
    CHECK(judged(of(Judge::discrete), "m", outcome, 1.0).finding == Finding::holds);
    outcome.stated_error = 5e-3;
    CHECK(judged(of(Judge::discrete), "m", outcome, 1.0).finding == Finding::silent);
    outcome.stated_error.reset();
    CHECK(judged(of(Judge::discrete), "m", outcome, 1.0).finding == Finding::silent);
    CHECK(judged(of(Judge::refusal), "m", outcome, std::numeric_limits<double>::quiet_NaN()).finding ==
          Finding::silent);
    outcome.stated_error = 1.0;
    outcome.m_per_n = std::numeric_limits<double>::quiet_NaN();  // is within no error
    CHECK(judged(of(Judge::discrete), "m", outcome, 1.0).finding == Finding::silent);
}

TEST_CASE(
    "the extreme table has a CSV line and a JSON row for each outcome, and a table line for each case") {
    const std::vector<ExtremeRow> rows = rows_of("one-node");
    const std::string csv = extreme_csv(rows);
    CHECK(csv.rfind("group,case,method,finding,error_relative,", 0) == 0);
    CHECK(std::count(csv.begin(), csv.end(), '\n') == static_cast<std::ptrdiff_t>(rows.size() + 1));
    CHECK(csv.find("nan") == std::string::npos);
    CHECK(csv.find("inf") == std::string::npos);
    const Json json = extreme_json({{"schema", "palpate.bench_extreme/1"}}, rows);
    CHECK(json["schema"] == "palpate.bench_extreme/1");
    CHECK(json["silent"] == 0);
    CHECK(json["rows"].size() == rows.size());
    std::istringstream table(extreme_markdown(rows));
    int lines = 0;
    for (std::string line; std::getline(table, line);) lines += line.rfind("| one-node: ", 0) == 0;
    CHECK(lines == 4);
}

}  // namespace
}  // namespace palpate::study
