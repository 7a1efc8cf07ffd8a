#include "host/study/machine.hpp"

#include <sys/utsname.h>

#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

namespace palpate::study {
namespace {

Json cpu() {
    std::ifstream in("/proc/cpuinfo");
    for (std::string line; std::getline(in, line);) {
        const std::size_t colon = line.find(": ");
        if (line.rfind("model name", 0) == 0 && colon != std::string::npos) return line.substr(colon + 2);
    }
    return nullptr;
}

Json kernel() {
    utsname name{};
    if (uname(&name) != 0) return nullptr;
    return std::string(name.sysname) + " " + name.release + " " + name.machine;
}

}  // namespace

Json machine_json() {
    double loads[2] = {0.0, 0.0};
    const int known = getloadavg(loads, 2);
    return {{"cpu", cpu()},
            {"cores", std::thread::hardware_concurrency()},
            {"kernel", kernel()},
            {"load_1_min", known > 0 ? Json(loads[0]) : Json(nullptr)},
            {"load_5_min", known > 1 ? Json(loads[1]) : Json(nullptr)}};
}

}  // namespace palpate::study
