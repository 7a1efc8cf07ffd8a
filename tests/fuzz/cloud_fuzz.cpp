// Both readers on arbitrary bytes: they make a sound cloud or throw Error, and nothing else. The first byte
// of the input chooses the reader, so that one corpus serves both.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "host/cloud/formats.hpp"

namespace {

void require(bool holds) {
    if (!holds) std::abort();
}

void check(const palpate::cloud::Cloud& cloud) {
    require(cloud.points_m.size() >= 3);
    for (const Eigen::Vector3d& point_m : cloud.points_m) require(point_m.allFinite());
    for (const auto& triangle : cloud.triangles) {
        for (const palpate::cloud::Index corner : triangle) require(corner < cloud.points_m.size());
        require(triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0]);
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
    try {
        check(data[0] == 'o' ? palpate::cloud::read_obj(bytes, "fuzz.obj")
                             : palpate::cloud::read_ply(bytes, "fuzz.ply"));
    } catch (const palpate::cloud::Error& error) {
        const std::string_view message = error.what();
        require(message.find("; ") != std::string_view::npos);  // what would be right
        for (const char c : message) require(c >= ' ' && c <= '~');
    }
    return 0;
}
