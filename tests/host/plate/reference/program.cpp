#include "tests/host/plate/reference/program.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace palpate::reference_program {

Run run(const std::string& command, const std::string& input) {
    std::string name = (std::filesystem::temp_directory_path() / "palpate-reference-XXXXXX").string();
    const int file = mkstemp(name.data());
    REQUIRE(file >= 0);
    close(file);
    std::ofstream(name) << input;
    const std::string line = std::string(PALPATE_REFERENCE_PROGRAM) + " " + command + " < " + name + " 2>&1";
    FILE* const pipe = popen(line.c_str(), "r");
    REQUIRE(pipe != nullptr);
    Run result{};
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) result.out.push_back(static_cast<char>(c));
    result.status = WEXITSTATUS(pclose(pipe));
    std::remove(name.c_str());
    return result;
}

nlohmann::json answer(const std::string& command, const nlohmann::json& problem) {
    const Run result = run(command, problem.dump());
    INFO(result.out);
    REQUIRE(result.status == 0);
    return nlohmann::json::parse(result.out);
}

bool soak() {
    return std::getenv("PALPATE_SOAK") != nullptr;
}

}  // namespace palpate::reference_program
