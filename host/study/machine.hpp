/// On what a figure was measured.
#pragma once
#include "host/study/oracle.hpp"

namespace palpate::study {

/// {"cpu", "cores", "kernel", "load_1_min", "load_5_min"}; null where the system does not say.
[[nodiscard]] Json machine_json();

}  // namespace palpate::study
