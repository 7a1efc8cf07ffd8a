#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <string>

#include "host/plate/plate.hpp"
#include "tests/host/plate/fields.hpp"

namespace palpate::plate {
namespace {

#ifdef PALPATE_REFERENCE_PROGRAM

using Eigen::Index;
using namespace fields;

struct Run {
    int status;
    std::string out;
};

Run reference(const std::string& arguments, const std::string& input) {
    std::string name = (std::filesystem::temp_directory_path() / "palpate-plate-XXXXXX").string();
    const int file = mkstemp(name.data());
    REQUIRE(file >= 0);
    close(file);
    std::ofstream(name) << input;
    const std::string command =
        std::string(PALPATE_REFERENCE_PROGRAM) + " " + arguments + " < " + name + " 2>&1";
    FILE* const pipe = popen(command.c_str(), "r");
    REQUIRE(pipe != nullptr);
    Run run{};
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) run.out.push_back(static_cast<char>(c));
    run.status = WEXITSTATUS(pclose(pipe));
    std::remove(name.c_str());
    return run;
}

std::string list(const Eigen::ArrayXXd& field) {
    std::ostringstream text;
    text << std::setprecision(17);
    for (Index ix = 0; ix < field.rows(); ++ix) {
        for (Index iz = 0; iz < field.cols(); ++iz) text << (ix + iz == 0 ? "[" : ",") << field(ix, iz);
    }
    text << (field.size() == 0 ? "[]" : "]");
    return text.str();
}

std::string request(const Problem& problem) {
    std::ostringstream text;
    text << std::setprecision(17) << R"({"size_m":[)" << problem.size_m.x() << "," << problem.size_m.y()
         << R"(],"nodes":[)" << problem.rigidity_n_m.rows() << "," << problem.rigidity_n_m.cols()
         << R"(],"poisson":)" << problem.poisson << R"(,"depth_m":0.002,"rigidity_n_m":)"
         << list(problem.rigidity_n_m) << R"(,"foundation_n_per_m3":)" << list(problem.foundation_n_per_m3)
         << "}";
    return text.str();
}

double number(const std::string& json, const std::string& key) {
    const std::size_t at = json.find("\"" + key + "\":");
    REQUIRE(at != std::string::npos);
    return std::stod(json.substr(at + key.size() + 3));
}

TEST_CASE("Ceres, from residuals of its own, finds the same plate to 1e-10") {
    Problem problem = unit_square(17, one);
    SECTION("uniform") {}
    SECTION("hyperbolic") {
        problem = unit_square(17, hyper10);
    }
    SECTION("jump by a thousand") {
        problem = unit_square(17, jump1000);
    }
    SECTION("a nodule in skin on tissue, in SI units") {
        problem = on_foundation(unit_square(17, gauss), 9.0);
        problem.size_m = {0.04, 0.04};
        problem.poisson = 0.45;
        problem.rigidity_n_m *= 4e-4;
        problem.foundation_n_per_m3 *= 4e-4 / 0.04 / 0.04 / 0.04 / 0.04;
    }
    SECTION("unequal sides and counts") {
        problem.rigidity_n_m = sampled(17, hyper10).leftCols(13);
        problem.size_m = {1.0, 0.6};
    }
    const Run run = reference("plate", request(problem));
    INFO(run.out);
    REQUIRE(run.status == 0);
    const double compliance = Plate(problem).centre_compliance_m_per_n();
    CHECK(number(run.out, "compliance_m_per_n") == Approx(compliance).epsilon(1e-10));
    CHECK(number(run.out, "reaction_n") == Approx(0.002 / compliance).epsilon(1e-10));
}

TEST_CASE("palpate-reference refuses bad input with a word about it and status 2") {
    Problem problem = unit_square(17, one);
    problem.rigidity_n_m(2, 3) = -1.0;
    const Run negative = reference("plate", request(problem));
    CHECK(negative.status == 2);
    CHECK_THAT(negative.out, Catch::Matchers::Contains("rigidity_n_m"));
    CHECK(reference("plate", "{").status == 2);
    CHECK(reference("plate", "{}").status == 2);
    CHECK(reference("plates", "{}").status == 2);
    CHECK(reference("--help", "").status == 0);
}

TEST_CASE("palpate-reference takes no count that is negative, a fraction, or larger than any array") {
    const std::string good = request(unit_square(17, one));
    REQUIRE(reference("plate", good).status == 0);
    const std::string bad =
        GENERATE(as<std::string>{}, "-1", "5.7", "5.1e31", "null", "18446744073709551615");
    INFO(bad);
    std::string contact = good;
    contact.insert(contact.size() - 1, R"(,"contact_node":[)" + bad + ",8]");
    const Run outside = reference("plate", contact);
    CHECK(outside.status == 2);
    CHECK_THAT(outside.out, Catch::Matchers::Contains("contact_node"));
    std::string nodes = good;
    nodes.replace(nodes.find("[17,"), 3, "[" + bad);
    const Run wrong = reference("plate", nodes);
    CHECK(wrong.status == 2);
    CHECK_THAT(wrong.out, Catch::Matchers::Contains("nodes"));
}

#else

TEST_CASE("Ceres reference") {
    WARN("skipped: palpate-reference was not built (PALPATE_REFERENCE=OFF)");
}

#endif

}  // namespace
}  // namespace palpate::plate
