/// The readers of one format each, from memory. `name` is what messages call the bytes; errors are those of
/// read().
#pragma once
#include <string>
#include <string_view>

#include "host/cloud/cloud.hpp"

namespace palpate::cloud {

/// Wavefront OBJ: `v` and `f`; every other statement is passed over. Negative indices count back from the
/// last vertex.
[[nodiscard]] Cloud read_obj(std::string_view bytes, const std::string& name);

/// PLY 1.0 in its three encodings, any scalar type. Elements and properties that are not needed are skipped
/// by their declared layout.
[[nodiscard]] Cloud read_ply(std::string_view bytes, const std::string& name);

}  // namespace palpate::cloud
