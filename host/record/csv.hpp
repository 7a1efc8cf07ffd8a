/// Numbers in CSV files.
#pragma once
#include <string>

#include "host/record/record.hpp"

namespace palpate::record {

/// Shortest text that reads back to the same value (float32 where it is one); whole numbers without an
/// exponent.
void append_number(std::string& out, double value);

}  // namespace palpate::record
