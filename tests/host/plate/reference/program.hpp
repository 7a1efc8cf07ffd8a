/// palpate-reference as a process.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace palpate::reference_program {

struct Run {
    int status;
    std::string out;  ///< standard output and error
};

[[nodiscard]] Run run(const std::string& command, const std::string& input);

/// The answer to a problem that can be solved; fails the test when there is none.
[[nodiscard]] nlohmann::json answer(const std::string& command, const nlohmann::json& problem);

/// Whether the long runs are wanted as well.
[[nodiscard]] bool soak();

}  // namespace palpate::reference_program
