/// What D is likely to look like about the load, and the uniform plate's first answers to it.
#pragma once
#include "host/plate/bounds/uniform.hpp"

namespace palpate::plate::bounds {

/// `w0` and `stress0` are the uniform plate's own under the load (MATH.md eq. 52).
[[nodiscard]] Modes make_modes(const Uniform& uniform, const Vector& w0, const Vector& stress0,
                               bool with_foundation);

}  // namespace palpate::plate::bounds
