/// What palpate-reference reads and writes.
#pragma once
#include <istream>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/plate/reference/cap.hpp"
#include "host/plate/reference/linear.hpp"
#include "host/plate/reference/shell.hpp"
#include "host/plate/reference/square.hpp"

namespace palpate::reference {

/// Bad input, in words for a person.
struct BadRequest : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Something to press and where to hold it, in increasing order.
template <class Body>
struct Press {
    Body body;
    std::vector<double> depths_m;
};

/// From JSON; the keys are those that --help lists, and no others. Each throws BadRequest.
[[nodiscard]] Plate read_plate(std::istream& in);
[[nodiscard]] Press<Shell> read_shell(std::istream& in);
[[nodiscard]] Press<Square> read_square(std::istream& in);
[[nodiscard]] Press<Cap> read_cap(std::istream& in);

/// One JSON object.
[[nodiscard]] std::string answer_text(const Answer& answer);
[[nodiscard]] std::string answer_text(const Pressed& pressed);

}  // namespace palpate::reference
