/// palpate-reference, the independent program, as a study sees it.
#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "host/plate/problem.hpp"

namespace palpate::study {

using Json = nlohmann::ordered_json;  ///< keys stay in the order in which they are written

/// palpate-reference found no answer; its words.
struct OracleError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Runs `palpate-reference COMMAND` with a request on its stdin and returns its answer. Throws OracleError.
/// Empty: not installed.
using Oracle = std::function<Json(const std::string& command, const Json& request)>;

/// Whether palpate-reference can be asked about a problem: clamped edges, even grid, no mask, one Poisson's
/// ratio, no laminate rule.
[[nodiscard]] bool can_ask_oracle(const plate::Problem& problem);

/// The problem in its words, the centre node held.
[[nodiscard]] Json oracle_request(const plate::Problem& problem);

}  // namespace palpate::study
