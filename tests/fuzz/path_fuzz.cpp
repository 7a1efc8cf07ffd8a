// A hand's path as palpate-falcon-sim reads it: points in reach at growing times, or one line that says where
// and what is wrong.
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <string>

#include "tests/fuzz/input.hpp"

extern "C" {
#include "sim/app/path_file.h"
}

namespace {

using fuzz::require;

fuzz::Reached accepted("path accepted"), longer("of several points"), refused("refused in a later line");

void check(const pal_path_file& path) {
    require(path.points != nullptr && path.n_points > 0);
    for (std::uint32_t i = 0; i < path.n_points; ++i) {
        const pal_hand_point& point = path.points[i];
        require(point.t_s >= 0.0 && std::isfinite(point.t_s));
        require(i == 0 || point.t_s > path.points[i - 1].t_s);
        for (const double x_m : point.at_m) require(std::fabs(x_m) <= 1.0);
    }
    accepted.note();
    if (path.n_points > 1) longer.note();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const int FILE_NUMBER = memfd_create("path", 0);
    static const std::string NAME = "/proc/self/fd/" + std::to_string(FILE_NUMBER);
    require(FILE_NUMBER >= 0 && ftruncate(FILE_NUMBER, 0) == 0);
    require(pwrite(FILE_NUMBER, data, size, 0) == static_cast<ssize_t>(size));
    pal_path_file path;
    std::array<char, 160> why{};
    if (pal_path_file_read(NAME.c_str(), &path, why.data(), why.size())) {
        check(path);
    } else {
        const std::string_view words = why.data();
        require(words.starts_with(NAME + ":") && words.find('\n') == std::string_view::npos);
        if (!words.starts_with(NAME + ":1:")) refused.note();
        require(path.points == nullptr && path.n_points == 0);
    }
    std::free(path.points);
    return 0;
}
