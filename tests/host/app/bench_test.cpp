// `palpate bench`: what people type, and what lies in the folder afterwards.
#include <csignal>

#include <catch2/catch.hpp>

#include "tests/host/app/processes.hpp"

using namespace palpate::test;
using Catch::Matchers::Contains;

namespace {

const std::vector<std::string> SMALL{"--fields", "hyperbolic", "--nodes",
                                     "9,17",     "--methods",  "cholesky,jacobi,damped-jacobi-change-1e-3",
                                     "--budget", "0.001"};

std::vector<std::string> bench(const std::string& what, const std::filesystem::path& out,
                               const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"bench", what, "--out", out.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
}

TEST_CASE("bench plate leaves a table, a document and words in its folder, and the document on stdout") {
    const Folder folder;
    std::vector<std::string> arguments = bench("plate", folder / "out", SMALL);
    arguments.emplace_back("--json");
    const Outcome outcome = call(PAL_PALPATE_PROGRAM, arguments, folder);
    INFO(outcome.err);
    REQUIRE(outcome.code == 0);
    const nlohmann::json document = json_of(folder / "out" / "results.json");
    CHECK(nlohmann::json::parse(outcome.out) == document);
    CHECK(document["schema"] == "palpate.bench_plate/1");
    for (const char* key : {"palpate", "build", "command", "started_utc", "machine"})
        CHECK(document.contains(key));
    CHECK(document["command"] ==
          "palpate bench plate --fields hyperbolic --methods cholesky,jacobi,damped-jacobi-change-1e-3 "
          "--nodes 9,17 --budget 0.001");
    CHECK(document["rows"].size() == 2 * 2 * 3);  // bare and founded, two grids, three methods
    const std::string csv = text_of(folder / "out" / "results.csv");
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 13);
    CHECK_THAT(csv, Contains("hyperbolic,0,jacobi,17,diverged,"));
    CHECK_THAT(text_of(folder / "out" / "results.md"), Contains("| jacobi | diverged |"));
    CHECK_FALSE(std::filesystem::exists(folder / "out.partial"));
    CHECK(scratch_in(folder).empty());
}

TEST_CASE("bench extreme passes on what its guards catch") {
    const Folder folder;
    const Outcome outcome =
        call(PAL_PALPATE_PROGRAM,
             bench("extreme", folder / "out", {"--groups", "one-node,bad-input", "--nodes", "17"}), folder);
    INFO(outcome.err);
    CHECK(outcome.code == 0);
    CHECK_THAT(outcome.out, Contains("eq7 gives a negative compliance"));
    CHECK_THAT(outcome.out, Contains("No method was wrong in silence."));
    CHECK(json_of(folder / "out" / "results.json")["silent"] == 0);
}

TEST_CASE("bench names what there is when a name is wrong, and leaves nothing") {
    const Folder folder;
    const auto refused = [&](const char* what, const std::vector<std::string>& more) {
        const Outcome outcome = call(PAL_PALPATE_PROGRAM, bench(what, folder / "out", more), folder);
        INFO(outcome.err);
        CHECK(outcome.code == 2);
        CHECK(outcome.out.empty());
        CHECK_FALSE(std::filesystem::exists(folder / "out"));
        return outcome.err;
    };
    CHECK_THAT(refused("plate", {"--methods", "choleski"}), Contains("cholesky-extrapolated"));
    CHECK_THAT(refused("plate", {"--fields", "bumpy"}), Contains("hyperbolic"));
    CHECK_THAT(refused("plate", {"--nodes", "18"}), Contains("8 m + 1"));
    CHECK_THAT(refused("extreme", {"--groups", "nothing"}), Contains("one-node"));
    refused("plate", {"--budget", "-1"});
    refused("planet", {});
}

TEST_CASE("bench that is interrupted leaves nothing half-written") {
    const Folder folder;
    Program program(PAL_PALPATE_PROGRAM, bench("plate", folder / "out", {"--quiet"}), folder);
    while (program.running() && !std::filesystem::exists(folder / "out.partial")) look_again();
    program.send(SIGINT);
    CHECK(program.wait() == 130);
    CHECK_FALSE(std::filesystem::exists(folder / "out"));
    CHECK_FALSE(std::filesystem::exists(folder / "out.partial"));
    CHECK(scratch_in(folder).empty());
}

}  // namespace
