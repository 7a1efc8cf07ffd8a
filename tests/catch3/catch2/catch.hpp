/// Catch2 3 (Ubuntu 24.04) under the name of Catch2 2; not tested yet. On the include path only where Catch2
/// is that new.
#pragma once
#include <catch2/catch_all.hpp>

using Catch::Approx;
