#include "host/study/plate_study.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "host/study/plate_results.hpp"
#include "host/study/plate_tables.hpp"

namespace palpate::study {
namespace {

using Catch::Matchers::Contains;

PlateStudy small() {
    PlateStudy study;
    study.fields = {"uniform", "hyperbolic", "jump-on-line"};
    study.nodes = {17, 33};
    study.cost_nodes.clear();
    study.on_foundation = false;
    study.budget_s = 1e-4;
    study.sweeps_s = 1e-4;
    study.reference_nodes_max = 65;
    return study;
}

const std::vector<PlateRow>& small_rows() {
    static const std::vector<PlateRow> rows = run(small(), {}, [](const std::string&) {});
    return rows;
}

const PlateRow& row_of(const std::string& field, const std::string& method, Eigen::Index nodes) {
    const auto& rows = small_rows();
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const PlateRow& r) {
        return r.field == field && r.method == method && r.nodes == nodes;
    });
    REQUIRE(row != rows.end());
    return *row;
}

/// A row that was measured elsewhere.
PlateRow made(const std::string& field, const std::string& method, Eigen::Index nodes, double median_s,
              double error) {
    PlateRow row;
    row.field = field;
    row.method = method;
    row.nodes = nodes;
    row.outcome.m_per_n = 1.0;
    row.error = error;
    row.timing = {median_s, {median_s, median_s, median_s}, 3};
    return row;
}

std::vector<std::string> lines_of(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

TEST_CASE("errors about the continuum are those that are known of the grids") {
    // 5.0e-2, 1.5e-2: raw compliance of the uniform square on 17 and 33 nodes.
    CHECK(row_of("uniform", "cholesky", 17).error ==
          Approx(5.893088423e-3 / 5.612024020e-3 - 1.0).epsilon(1e-6));
    CHECK(row_of("uniform", "cholesky", 33).error ==
          Approx(5.696151392e-3 / 5.612024020e-3 - 1.0).epsilon(1e-6));
    CHECK(row_of("uniform", "cholesky-extrapolated", 33).error < 1e-9);
    CHECK(row_of("hyperbolic", "cholesky-extrapolated", 33).error < 2e-5);
    CHECK(row_of("uniform", "closed-form", 0).error < 1e-6);
    CHECK(row_of("hyperbolic", "eigen", 33).discrete_error < 1e-11);
    CHECK(row_of("hyperbolic", "bounds-modes", 33).discrete_error <=
          *row_of("hyperbolic", "bounds-modes", 33).outcome.stated_error);
}

TEST_CASE(
    "a row tells what became of a method: jacobi diverges, the laminate rule is refused by those without") {
    CHECK(row_of("hyperbolic", "jacobi", 17).outcome.status == "diverged");
    CHECK(row_of("hyperbolic", "damped-jacobi", 33).outcome.status == "not-converged");
    CHECK(row_of("jump-on-line", "eq7", 17).outcome.status == "refused");
    CHECK_FALSE(row_of("jump-on-line", "eq7", 17).outcome.words.empty());
    CHECK(row_of("jump-on-line", "cholesky", 17).constructs);
    CHECK_FALSE(row_of("hyperbolic", "cholesky", 17).constructs);
}

TEST_CASE("results.csv and results.json have the same rows, and a why for every number that is missing") {
    const auto& rows = small_rows();
    const std::vector<std::string> csv = lines_of(results_csv(rows));
    REQUIRE(csv.size() == rows.size() + 1);
    CHECK_THAT(csv[0], Catch::Matchers::StartsWith("field,side_over_l,method,nodes,status,error_relative,"));
    const auto commas = std::count(csv[0].begin(), csv[0].end(), ',');
    for (std::size_t i = 1; i < csv.size(); ++i) {
        if (csv[i].find('"') == std::string::npos)
            CHECK(std::count(csv[i].begin(), csv[i].end(), ',') == commas);
        CHECK(csv[i].find("nan") == std::string::npos);
    }
    const Json json = results_json({{"schema", "palpate.bench_plate/1"}}, rows);
    CHECK(json.begin().key() == "schema");
    REQUIRE(json["rows"].size() == rows.size());
    for (const Json& row : json["rows"]) {
        for (const auto& [name, value] : row.items()) {
            if (value.is_null()) CHECK_FALSE(row.at(name + "_why").get<std::string>().empty());
        }
    }
}

TEST_CASE("the cost of made-up times has the exponent they were made with") {
    std::vector<PlateRow> rows;
    for (const Eigen::Index nodes : {17, 33, 65, 129}) {
        const double n = static_cast<double>(nodes);
        rows.push_back(made("hyperbolic", "quick", nodes, 1e-8 * n * n, 1e-3));
        rows.push_back(made("hyperbolic", "slow", nodes, 1e-9 * n * n * n * n, 1e-3));
    }
    rows.push_back(made("hyperbolic", "slow", 257, 1.0, 1e-3));
    rows.back().outcome.status = "not-converged";  // does not count
    const std::vector<Cost> costs = cost_against_nodes(rows, "hyperbolic");
    REQUIRE(costs.size() == 2);
    CHECK(costs[0].law->exponent == Approx(2.0));
    CHECK(costs[1].law->exponent == Approx(4.0));
    CHECK(costs[1].nodes == std::vector<Eigen::Index>{17, 33, 65, 129});
}

TEST_CASE("what a time buys is the smallest error within it") {
    std::vector<PlateRow> rows{made("hyperbolic", "a", 17, 0.01, 1e-2),
                               made("hyperbolic", "a", 33, 0.1, 1e-3), made("hyperbolic", "a", 65, 1.0, 1e-4),
                               made("random", "a", 17, 2.0, 1e-1), made("hyperbolic", "b", 17, 0.01, 1e7)};
    rows.back().outcome.status = "diverged";
    const std::vector<WithinTime> table = within_time(rows, 0.16);
    REQUIRE(table.size() == 2);
    CHECK(table[0].smooth.error == 1e-3);
    CHECK(table[0].smooth.nodes == 33);
    CHECK_FALSE(std::isfinite(table[0].rough.error));
    CHECK(table[1].smooth.status == "diverged");
    CHECK_THAT(results_markdown(rows), Contains("| b | diverged | - | - |"));
}

TEST_CASE("an error below the reference's own is told as a bound") {
    std::vector<PlateRow> rows{made("hyperbolic", "a", 17, 0.01, 1e-7)};
    rows[0].truth = Truth{1.0, 3e-6, "extrapolated"};
    CHECK_THAT(results_markdown(rows), Contains("| a | <= 3e-06 (n = 17"));
    CHECK(results_json({}, rows)["within_160_ms"]["lines"][0]["hyperbolic"]["reference_error_relative"] ==
          3e-6);
    rows[0].truth->relative_error = 1e-9;
    CHECK_THAT(results_markdown(rows), Contains("| a | 1e-07 (n = 17"));
}

TEST_CASE("the picture's script marks each method once, the front, and both times") {
    const std::vector<PlateRow> rows{made("hyperbolic", "cholesky", 17, 1e-5, 1e-2),
                                     made("hyperbolic", "cholesky", 33, 1e-4, 1e-3),
                                     made("hyperbolic", "eigen", 33, 1e-3, 1e-3)};
    const std::string script = pareto_script(rows, "it's.png");
    CHECK_THAT(script,
               Contains("title 'cholesky'") && Contains("title 'eigen'") && Contains("title 'Pareto front'"));
    CHECK_THAT(script, Contains("1 ms") && Contains("160 ms") && Contains("'it''s.png'"));
    CHECK_THAT(script, Contains("$p0_0 << EOD\n0.01 0.01\n0.1 0.001\nEOD"));
    CHECK(pareto_script({}, "none.png").empty());
}

TEST_CASE("a study with a name that does not exist is refused, and the names that do are told") {
    PlateStudy study = small();
    study.methods = {"choleski"};
    CHECK_THAT(problem_with(study).value_or(""), Contains("choleski") && Contains("cholmod-supernodal"));
    CHECK_THROWS_AS(run(study, {}, [](const std::string&) {}), std::invalid_argument);
    study = small();
    study.nodes = {18};
    CHECK(problem_with(study));
}

TEST_CASE("whoever watches a study can end it") {
    struct Stop {};
    CHECK_THROWS_AS(run(small(), {}, [](const std::string&) { throw Stop{}; }), Stop);
}

}  // namespace
}  // namespace palpate::study
