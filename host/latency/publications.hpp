/// What a record says of its tables.
#pragma once
#include "host/latency/measure.hpp"
#include "host/record/record.hpp"

namespace palpate::latency {

/// The tick that each table was made for, and, where the header has `published_ns`, an array of [id, ns],
/// when it was published. Throws record::Error when the header has something else there.
[[nodiscard]] Publications publications_of(const record::Record& record);

}  // namespace palpate::latency
