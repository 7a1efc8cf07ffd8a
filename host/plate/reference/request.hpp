/// What palpate-reference reads and writes.
#pragma once
#include <istream>
#include <stdexcept>
#include <string>

#include "host/plate/reference/linear.hpp"

namespace palpate::reference {

/// Bad input, in words for a person.
struct BadRequest : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A plate from JSON; the keys are those that --help lists. Throws BadRequest.
[[nodiscard]] Plate read_plate(std::istream& in);

/// One JSON object.
[[nodiscard]] std::string answer_text(const Answer& answer);

}  // namespace palpate::reference
