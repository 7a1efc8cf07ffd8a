#include "host/study/machine.hpp"

#include <sys/utsname.h>

#include "host/latency/machine.hpp"

namespace palpate::study {
namespace {

Json or_null(std::optional<double> value) {
    return value ? Json(*value) : Json(nullptr);
}

Json kernel() {
    utsname name{};
    if (uname(&name) != 0) return nullptr;
    return std::string(name.sysname) + " " + name.release + " " + name.machine;
}

}  // namespace

Json machine_json() {
    const latency::Machine machine = latency::machine_facts();
    return {{"cpu", machine.cpu.empty() ? Json(nullptr) : Json(machine.cpu)},
            {"cores", machine.n_cores},
            {"kernel", kernel()},
            {"load_1_min", or_null(machine.load_1_min)},
            {"load_5_min", or_null(machine.load_5_min)}};
}

}  // namespace palpate::study
