#include <catch2/catch.hpp>
#include <cstdlib>
#include <sstream>
#include <string>

#include "host/plate/depth_law.hpp"
#include "tests/host/plate/reference/program.hpp"

namespace palpate {
namespace {

using nlohmann::json;
using reference_program::run;
using reference_program::soak;

json good(const std::string& command) {
    json problem = {{"thickness_m", 1e-3}, {"rigidity_n_m", 1e-4}, {"depths_m", {1e-4}}};
    if (command == "shell") {
        problem["size_m"] = {0.04, 0.04};
        problem["nodes"] = {5, 5};
    } else {
        problem["elements"] = 4;
        problem[command == "cap" ? "radius_m" : "side_m"] = 0.02;
    }
    return problem;
}

struct Bad {
    const char* key;
    json value;
};

TEST_CASE("palpate-reference refuses what a shell, a square or a cap cannot be, by key, with status 2") {
    const auto command = GENERATE(as<std::string>{}, "shell", "square", "cap");
    REQUIRE(run(command, good(command).dump()).status == 0);
    for (const Bad& bad :
         {Bad{"thickness_m", 0.0}, Bad{"thickness_m", "thin"}, Bad{"rigidity_n_m", -1.0},
          Bad{"depths_m", json::array()}, Bad{"depths_m", {2e-4, 1e-4}}, Bad{"depths_m", {0.0}},
          Bad{"poisson", 0.5}, Bad{"edge", "loose"}, Bad{"curvature", 30.0}}) {
        json problem = good(command);
        problem[bad.key] = bad.value;
        const auto refused = run(command, problem.dump());
        INFO(problem.dump() << refused.out);
        CHECK(refused.status == 2);
        if (!bad.value.is_string() || bad.value == "loose")
            CHECK_THAT(refused.out, Catch::Matchers::Contains(bad.key));
    }
}

TEST_CASE("palpate-reference refuses counts that no body has") {
    for (const char* const command : {"square", "cap"}) {
        for (const json& elements : {json(3), json(257), json(-4), json(8.5), json("8")}) {
            json problem = good(command);
            problem["elements"] = elements;
            CHECK(run(command, problem.dump()).status == 2);
        }
    }
    json problem = good("shell");
    problem["nodes"] = {5, 4};
    CHECK(run("shell", problem.dump()).status == 2);
    problem = good("shell");
    problem["rigidity_n_m"] = {1.0, 2.0};
    CHECK(run("shell", problem.dump()).status == 2);
    problem = good("cap");
    problem["curvature_per_m"] = {1.0, 1.0};
    CHECK(run("cap", problem.dump()).status == 2);
    CHECK(run("shell", "[]").status == 2);
}

TEST_CASE("a field may be one number for all nodes") {
    json one = good("shell");
    json many = one;
    many["rigidity_n_m"] = std::vector<double>(25, 1e-4);
    one["foundation_n_per_m3"] = 1e5;
    many["foundation_n_per_m3"] = std::vector<double>(25, 1e5);
    CHECK(run("shell", one.dump()).out == run("shell", many.dump()).out);
}

TEST_CASE("the help's example is what it says") {
    const std::string help = run("--help", "").out;
    const std::size_t begin = help.find("echo '") + 6;
    const auto dome = json::parse(run("cap", help.substr(begin, help.find('\'', begin) - begin)).out);
    CHECK(dome["force_ratio"][1].get<double>() == Approx(0.6).margin(0.01));
}

TEST_CASE("depth-law writes the checked-in table") {
    if (!soak()) {
        WARN("skipped: a minute; PALPATE_SOAK=1 runs it");
        return;
    }
    std::istringstream lines(run("depth-law", "").out);
    std::size_t n_rows = 0;
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line.front() != '{') continue;
        REQUIRE(n_rows < plate::depth_law_table().size());
        const plate::DepthLawRow& row = plate::depth_law_table()[n_rows++];
        const json found = json::parse("[" + line.substr(1, line.find('}') - 1) + "]");
        CHECK(found[0].get<double>() == row.x);
        CHECK(found[1].get<double>() == Approx(row.flat).epsilon(1e-5));
        CHECK(found[2].get<double>() == Approx(row.convex).epsilon(1e-5));
        CHECK(found[3].get<double>() == Approx(row.concave).epsilon(1e-5));
    }
    CHECK(n_rows == plate::depth_law_table().size());
}

}  // namespace
}  // namespace palpate
