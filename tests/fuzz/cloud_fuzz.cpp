// Both readers on arbitrary bytes: they make a sound cloud or throw Error, and nothing else. Each input is
// read as an OBJ and as a PLY, so that a seed is a file as it lies on a disk.
#include "host/cloud/formats.hpp"
#include "tests/fuzz/input.hpp"

namespace {

using fuzz::require;
using palpate::cloud::Cloud;

fuzz::Reached obj_points("OBJ with points"), obj_triangles("OBJ with triangles");
fuzz::Reached ply_points("PLY with points"), ply_triangles("PLY with triangles");

void check(const Cloud& cloud) {
    require(cloud.points_m.size() >= 3);
    for (const Eigen::Vector3d& point_m : cloud.points_m) require(point_m.allFinite());
    for (const auto& triangle : cloud.triangles) {
        for (const palpate::cloud::Index corner : triangle) require(corner < cloud.points_m.size());
        require(triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0]);
    }
}

void read_as(Cloud (*read)(std::string_view, const std::string&), fuzz::Bytes bytes, fuzz::Reached& points,
             fuzz::Reached& triangles) {
    try {
        const Cloud cloud = read(fuzz::text_of(bytes), "fuzz");
        check(cloud);
        points.note();
        if (!cloud.triangles.empty()) triangles.note();
    } catch (const palpate::cloud::Error& error) {
        const std::string_view message = error.what();
        require(message.find("; ") != std::string_view::npos);  // what would be right
        for (const char c : message) require(c >= ' ' && c <= '~');
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    read_as(palpate::cloud::read_obj, {data, size}, obj_points, obj_triangles);
    read_as(palpate::cloud::read_ply, {data, size}, ply_points, ply_triangles);
    return 0;
}
