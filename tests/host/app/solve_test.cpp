// `palpate solve` as a person and a script see it: the number and how sure it is, one document on stdout,
// files that read back, and every bad input on one line.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>

#include "host/scene/array_file.hpp"
#include "tests/host/app/processes.hpp"

using namespace palpate::test;
using Catch::Matchers::Contains;
using Catch::Matchers::Matches;
using palpate::scene::parse_csv;
using palpate::scene::parse_npy;

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Clamped square of side 1, D = 1, 1 N in the middle: S. P. Timoshenko and S. Woinowsky-Krieger, Theory of
/// Plates and Shells, table 37, to the digits of MATH.md eq. 6.
constexpr double SQUARE = 0.005612024020;

const std::string UNIT_SQUARE = "[plate]\nsize_m = [1, 1]\npoisson = 0.3\n[rigidity]\nvalue_n_m = 1\n";

/// The same in the eyes of a file of numbers.
std::string square_from(const std::string& file, const std::string& more = "") {
    return "[plate]\nsize_m = [1, 1]\npoisson = 0.3\n[rigidity]\nfile = \"" + file + "\"\n" + more;
}

struct Solved {
    Solved(const Folder& folder, const std::string& toml, std::vector<std::string> more = {"--json"}) {
        write_text(folder / "p.toml", toml);
        std::vector<std::string> arguments{"solve", (folder / "p.toml").string()};
        arguments.insert(arguments.end(), more.begin(), more.end());
        outcome = call(PAL_PALPATE_PROGRAM, arguments, folder);
        INFO(outcome.err);
        if (!outcome.out.empty() && outcome.out[0] == '{') document = json::parse(outcome.out);
    }
    [[nodiscard]] double m_per_n() const { return document.at("compliance_m_per_n").get<double>(); }
    Outcome outcome;
    json document;
};

/// What is said of a bad plate, without "palpate: FOLDER/".
std::string refused(const Folder& folder, const std::string& toml,
                    const std::vector<std::string>& more = {}) {
    const Outcome outcome = Solved(folder, toml, more).outcome;
    INFO(outcome.err);
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
    REQUIRE(outcome.err.starts_with("palpate: "));
    const std::string line = outcome.err.substr(9), begin = (folder / "").string();
    return line.starts_with(begin) ? line.substr(begin.size()) : line;
}

/// Every null has a sibling that says why; a warning alone may be absent without a word.
void check_nulls(const json& document) {
    for (const auto& [name, value] : document.items()) {
        INFO(name);
        if (value.is_null() && name != "warning") {
            REQUIRE(document.contains(name + "_why"));
            CHECK_FALSE(document[name + "_why"].get<std::string>().empty());
        }
        if (!value.is_null()) CHECK_FALSE(document.contains(name + "_why"));
    }
}

/// No file that is being written, nor any other than these.
void check_files(const Folder& folder, std::vector<std::string> names) {
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder.path())) {
        const std::string name = entry.path().filename().string();
        if (name.ends_with(".partial") || name.starts_with("w.")) found.push_back(name);
    }
    std::sort(found.begin(), found.end());
    std::sort(names.begin(), names.end());
    CHECK(found == names);
}

}  // namespace

TEST_CASE("a uniform clamped square gives way as the table says, within the error that is told", "[solve]") {
    const Folder folder;
    const std::string method = GENERATE(as<std::string>{}, "auto", "cholesky", "multigrid", "closed-form");
    const Solved solved(folder, UNIT_SQUARE, {"--json", "--set", "solver.method=" + method});
    INFO(method << " " << solved.outcome.err);
    REQUIRE(solved.outcome.code == 0);
    CHECK(solved.document["status"] == "solved");
    const double error = solved.document["estimated_relative_error"].get<double>();
    CHECK(error <= 1e-3);
    CHECK(std::fabs(solved.m_per_n() / SQUARE - 1.0) <= error + 1e-9);
    if (solved.document["lower_m_per_n"].is_number()) {
        CHECK(solved.document["lower_m_per_n"] <= SQUARE * (1.0 + 1e-9));
        CHECK(solved.document["upper_m_per_n"] >= SQUARE * (1.0 - 1e-9));
    }
}

TEST_CASE("the document of a solve has its keys, and a reason for every null", "[solve]") {
    const Folder folder;
    const Solved solved(folder,
                        UNIT_SQUARE + "[load]\nforce_n = 2\n[output]\npoints_m = [[0.5, 0.5], [0, 0.5]]\n");
    INFO(solved.outcome.err);
    REQUIRE(solved.outcome.code == 0);
    const json& document = solved.document;
    CHECK(document["schema"] == "palpate.solve/1");
    for (const char* name : {"palpate", "build", "method", "why", "kernel"}) {
        INFO(name);
        CHECK_FALSE(document[name].get<std::string>().empty());
    }
    CHECK_THAT(document["started_utc"].get<std::string>(), Matches(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ)"));
    CHECK_THAT(document["command"].get<std::string>(), Contains("palpate solve ") && Contains("p.toml"));
    for (const char* name :
         {"compliance_m_per_n", "deflection_m", "lower_m_per_n", "upper_m_per_n", "estimated_relative_error",
          "nodes", "residual", "wall_s", "status", "iterations", "load", "points_m", "field", "plot"}) {
        INFO(name);
        CHECK(document.contains(name));
    }
    check_nulls(document);
    REQUIRE(document["deflection_m"].size() == 2);
    CHECK(document["deflection_m"][0].get<double>() == Approx(2.0 * SQUARE).epsilon(1e-3));
    CHECK(std::fabs(document["deflection_m"][1].get<double>()) <= 1e-9);
    CHECK(document["load"]["at_m"] == json{0.5, 0.5});
    CHECK_THAT(solved.outcome.err, Contains("compliance"));
}

TEST_CASE("a solve without --json is words on stdout; with --quiet the number alone", "[solve]") {
    const Folder folder;
    const Outcome words = Solved(folder, UNIT_SQUARE, {}).outcome;
    CHECK(words.code == 0);
    CHECK(words.err.empty());
    CHECK_THAT(words.out, Contains("compliance    0.00561") && Contains("error") && Contains("method"));
    const Outcome number = Solved(folder, UNIT_SQUARE, {"--quiet"}).outcome;
    CHECK(number.code == 0);
    CHECK(number.err.empty());
    CHECK(std::stod(number.out) == Approx(SQUARE).epsilon(1e-3));
    CHECK(std::count(number.out.begin(), number.out.end(), '\n') == 1);
    const Outcome document = Solved(folder, UNIT_SQUARE, {"--quiet", "--json"}).outcome;
    CHECK(document.err.empty());
    CHECK(json::parse(document.out)["status"] == "solved");
}

TEST_CASE("a uniform rigidity in a file of any resolution is the uniform plate", "[solve]") {
    const Folder folder;
    const auto [n_rows, n_columns] = GENERATE(std::array{1, 1}, std::array{2, 7}, std::array{130, 3});
    const Eigen::ArrayXXd values = Eigen::ArrayXXd::Ones(n_rows, n_columns);
    write_text(folder / "d.csv", palpate::scene::csv_text(values));
    write_text(folder / "d.npy", palpate::scene::npy_bytes(values));
    for (const char* more : {"sampling = \"linear\"\n", "sampling = \"nearest\"\n"}) {
        CHECK(Solved(folder, square_from("d.csv", more)).m_per_n() == Approx(SQUARE).epsilon(1e-3));
        CHECK(Solved(folder, square_from("d.npy", more)).m_per_n() == Approx(SQUARE).epsilon(1e-3));
    }
}

TEST_CASE("linear and nearest sampling of two rows differ, and their mirror images do not", "[solve]") {
    const Folder folder;
    write_text(folder / "d.csv", "1,1\n4,4\n");
    write_text(folder / "mirror.csv", "4,4\n1,1\n");
    write_text(folder / "turned.csv", "1,4\n1,4\n");
    const std::string low = "[load]\nat_m = [0.25, 0.5]\n", high = "[load]\nat_m = [0.75, 0.5]\n";
    const double linear = Solved(folder, square_from("d.csv", low)).m_per_n();
    CHECK(Solved(folder, square_from("mirror.csv", high)).m_per_n() == Approx(linear).epsilon(1e-6));
    CHECK(Solved(folder, square_from("turned.csv", "[load]\nat_m = [0.5, 0.25]\n")).m_per_n() ==
          Approx(linear).epsilon(1e-6));
    CHECK(Solved(folder, square_from("d.csv", high)).m_per_n() < 0.6 * linear);  // row 2 is x high, and stiff
    const double nearest = Solved(folder, square_from("d.csv", "sampling = \"nearest\"\n" + low)).m_per_n();
    CHECK(nearest > 1.2 * linear);  // D = 1 up to the middle, in place of 1 to 2.5
    CHECK(nearest > 0.0);
}

TEST_CASE("a field is written as asked, CSV and NPY alike, and reads back equal", "[solve]") {
    const Folder folder;
    const std::string output = "[output]\npoints_m = [[0.25, 0.5], [0.5, 0.75]]\nfield = ";
    const std::string toml =
        "[plate]\nsize_m = [1, 2]\nnodes = [17, 33]\npoisson = 0.3\n[rigidity]\nvalue_n_m = 1\n[load]\n"
        "at_m = [0.5, 0.75]\n[solver]\nmethod = \"cholesky\"\n";
    const Solved csv(folder, toml + output + "\"w.csv\"\n"), npy(folder, toml + output + "\"w.npy\"\n");
    INFO(csv.outcome.err);
    REQUIRE(csv.outcome.code == 0);
    CHECK(csv.document["field"] == (folder / "w.csv").string());
    const Eigen::ArrayXXd w = parse_csv(text_of(folder / "w.csv"), "w.csv");
    CHECK((w == parse_npy(text_of(folder / "w.npy"), "w.npy")).all());
    REQUIRE(w.rows() == 17);
    REQUIRE(w.cols() == 33);
    CHECK(w(4, 8) == csv.document["deflection_m"][0].get<double>());  // (0.25, 0.5): a quarter each way
    CHECK(w(8, 12) == csv.document["deflection_m"][1].get<double>());
    CHECK(w(8, 12) == csv.m_per_n());
    CHECK(w.row(0).abs().maxCoeff() <= 1e-12);
    CHECK((w - w.colwise().reverse()).abs().maxCoeff() <= 1e-9);  // alike on both sides of x = 1/2
    check_files(folder, {"w.csv", "w.npy"});
}

TEST_CASE("results go to --out when it is given, else to the plate file's folder", "[solve]") {
    const Folder folder;
    const Solved solved(folder, UNIT_SQUARE + "[output]\nfield = \"a/w.csv\"\n",
                        {"--out", (folder / "new" / "out").string()});
    INFO(solved.outcome.err);
    CHECK(solved.outcome.code == 0);
    CHECK_THAT(solved.outcome.out, Contains((folder / "new" / "out" / "a" / "w.csv").string()));
    CHECK(fs::exists(folder / "new" / "out" / "a" / "w.csv"));
    CHECK_FALSE(fs::exists(folder / "a"));
}

TEST_CASE("a picture is drawn, or its absence said with exit code 1", "[solve]") {
    const Folder folder;
    const Solved solved(folder, UNIT_SQUARE + "[output]\nplot = \"w.png\"\n");
    if (solved.outcome.code == 0) {
        CHECK(text_of(folder / "w.png").starts_with("\x89PNG"));
        CHECK(solved.document["plot"] == (folder / "w.png").string());
        check_files(folder, {"w.png"});
    } else {
        CHECK(solved.outcome.code == 1);
        CHECK_THAT(solved.outcome.err, Contains("w.png was not made: gnuplot"));
        CHECK(solved.document["plot"].is_null());
        check_files(folder, {});
    }
    check_nulls(solved.document);
}

TEST_CASE("a method that diverges is an answer: its name, exit code 1, no number, no file", "[solve]") {
    const Folder folder;
    const Solved solved(folder, UNIT_SQUARE +
                                    "[solver]\nmethod = \"jacobi\"\n[output]\npoints_m = [[0.5, 0.5]]\n"
                                    "field = \"w.csv\"\nplot = \"w.png\"\n");
    CHECK(solved.outcome.code == 1);
    CHECK_THAT(solved.outcome.err, Contains("p.toml: diverged jacobi"));
    CHECK(solved.document["status"] == "diverged");
    CHECK(solved.document["method"] == "jacobi");
    for (const char* name :
         {"compliance_m_per_n", "estimated_relative_error", "deflection_m", "field", "plot"}) {
        INFO(name);
        CHECK(solved.document[name].is_null());
    }
    check_nulls(solved.document);
    check_files(folder, {});
    CHECK(Solved(folder, UNIT_SQUARE, {"--quiet", "--set", "solver.method=jacobi"}).outcome.out.empty());
}

TEST_CASE("a bad plate file is refused with file, line and key", "[solve][bad]") {
    const Folder folder;
    CHECK_THAT(
        refused(folder, UNIT_SQUARE + "valeu_n_m = 2\n"),
        Contains("p.toml:6: rigidity.valeu_n_m is unknown; the nearest known key is rigidity.value_n_m"));
    CHECK_THAT(refused(folder, UNIT_SQUARE, {"--set", "plate.nodes=[64,65]"}),
               Contains("--set plate.nodes: plate.nodes[0] is 64") && Contains("61 or 65"));
    CHECK_THAT(refused(folder, square_from("d.csv")),
               Contains("p.toml:5: ") && Contains("d.csv cannot be read"));
    write_text(folder / "d.csv", "1,2\n3,-4\n");
    CHECK_THAT(refused(folder, square_from("d.csv")), Contains("d.csv: row 2, column 2 is -4"));
    write_text(folder / "d.npy", palpate::scene::npy_bytes(Eigen::ArrayXXd::Constant(2, 3, std::nan(""))));
    CHECK_THAT(refused(folder, square_from("d.npy")), Contains("d.npy: row 1, column 1 is nan"));
    write_text(folder / "d.npy", palpate::scene::npy_bytes(Eigen::ArrayXXd::Ones(2, 3)).substr(0, 150));
    CHECK_THAT(refused(folder, square_from("d.npy")), Contains("d.npy: ") && Contains("truncated"));
    CHECK_THAT(
        refused(folder, UNIT_SQUARE + "[solver]\nmethod = \"closed-form\"\n", {"--set", "plate.edges=free"}),
        Contains("p.toml: "));
    CHECK(call(PAL_PALPATE_PROGRAM, {"solve"}, folder).code == 2);
    CHECK(call(PAL_PALPATE_PROGRAM, {"solve", (folder / "none.toml").string()}, folder).code == 2);
}

TEST_CASE("an output that cannot be written, or is an input, is refused before anything is solved",
          "[solve][bad]") {
    const Folder folder;
    write_text(folder / "d.csv", "1\n");
    CHECK_THAT(refused(folder, square_from("d.csv", "[output]\nfield = \"d.csv\"\n")),
               Contains("p.toml:7: ") && Contains("it is an input"));
    CHECK(text_of(folder / "d.csv") == "1\n");
    CHECK_THAT(refused(folder, square_from("d.csv", "[output]\nfield = \"d.csv/w.csv\"\n")),
               Contains("p.toml:7: ") && Contains("cannot be written"));
    fs::create_directory(folder / "w.png");
    CHECK_THAT(refused(folder, square_from("d.csv", "[output]\nplot = \"w.png\"\n")),
               Contains("p.toml:7: ") && Contains("it is a directory"));
}

TEST_CASE("an earlier field stays whole until the new one takes its place", "[solve]") {
    const Folder folder;
    const std::string toml = UNIT_SQUARE + "[output]\nfield = \"w.csv\"\n";
    write_text(folder / "w.csv", "earlier\n");
    CHECK(Solved(folder, toml, {"--set", "solver.method=jacobi"}).outcome.code == 1);
    CHECK(text_of(folder / "w.csv") == "earlier\n");
    // Where the new one is written first there is a folder: it cannot be.
    fs::create_directory(folder / "w.csv.partial");
    const Outcome outcome = Solved(folder, toml).outcome;
    CHECK(outcome.code == 2);
    CHECK_THAT(outcome.err, Contains("w.csv: cannot be written"));
    CHECK(outcome.out.empty());
    CHECK(text_of(folder / "w.csv") == "earlier\n");
    fs::remove(folder / "w.csv.partial");
    CHECK(Solved(folder, toml).outcome.code == 0);
    CHECK(parse_csv(text_of(folder / "w.csv"), "w.csv").rows() == 65);
}

TEST_CASE("an interrupted solve ends with 130 and leaves nothing", "[solve]") {
    const Folder folder;
    // Minutes of sweeps.
    write_text(folder / "p.toml", UNIT_SQUARE +
                                      "[solver]\nmethod = \"damped-jacobi\"\ntolerance = 1e-9\n[output]\n"
                                      "field = \"w.csv\"\n");
    Program program(PAL_PALPATE_PROGRAM,
                    {"solve", (folder / "p.toml").string(), "--set", "plate.nodes=[1025,1025]"}, folder);
    const std::string status = "/proc/" + std::to_string(program.pid()) + "/status";
    while (program.running() && text_of(status).find("Threads:\t2") == std::string::npos) look_again();
    program.send(SIGINT);
    CHECK(program.wait() == 130);
    CHECK(program.out().empty());
    CHECK(program.err() == "palpate: interrupted\n");
    check_files(folder, {});
}
