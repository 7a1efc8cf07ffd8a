#include "host/scene/frames.hpp"

#include <array>
#include <fstream>
#include <stdexcept>

#include "common/frame.h"
#include "host/cloud/text.hpp"

namespace palpate::scene {
namespace {

constexpr std::size_t HEAD_MAX_BYTES = 1U << 20U;  // of a file that has no end_header, such as an OBJ

Eigen::Matrix3d rows(const Eigen::Vector3d& x, const Eigen::Vector3d& y, const Eigen::Vector3d& z) {
    Eigen::Matrix3d turn;
    turn << x.transpose(), y.transpose(), z.transpose();
    return turn;
}

std::array<Convention, 8> make_table() {
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
                          z = Eigen::Vector3d::UnitZ(), zero = Eigen::Vector3d::Zero();
    const Eigen::Vector3d base(-PAL_WORKSPACE_CENTRE_X_M, -PAL_WORKSPACE_CENTRE_Y_M,
                               -PAL_WORKSPACE_CENTRE_Z_M);
    // Rows: what the workspace's x (right), y (up) and z (towards the user) are in the other frame.
    return {{{"workspace", rows(x, y, z), zero, false},
             {"falcon", rows(x, y, z), base, false},
             {"hdal", rows(x, y, z), zero, false},
             {"chai3d", rows(y, z, x), zero, false},
             {"force-dimension", rows(y, z, x), zero, false},
             {"ros", rows(-y, z, -x), zero, false},
             {"LPS", rows(x, z, -y), zero, true},
             {"RAS", rows(-x, z, y), zero, true}}};
}

const std::array<Convention, 8>& table() {
    static const std::array<Convention, 8> all = make_table();
    return all;
}

}  // namespace

std::span<const Convention> conventions() {
    return table();
}

const Convention& convention(std::string_view name) {
    for (const Convention& c : table()) {
        if (c.name == name) return c;
    }
    throw std::out_of_range("no frame convention is called " + std::string(name));
}

Eigen::Vector3d to_workspace_m(const Convention& from, const Eigen::Vector3d& at_m) {
    return from.turn * at_m + from.origin_m;
}

Eigen::Vector3d from_workspace_m(const Convention& to, const Eigen::Vector3d& at_m) {
    return to.turn.transpose() * (at_m - to.origin_m);
}

SpaceComment space_comment(const std::filesystem::path& points) {
    static constexpr std::string_view KEY = "SPACE=";
    std::ifstream in(points, std::ios::binary);
    std::string head(HEAD_MAX_BYTES, '\0');
    in.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(in.gcount()));
    cloud::Lines lines(head);
    for (std::string_view line; lines.next(line);) {
        if (line.starts_with("end_header")) break;
        if (!line.starts_with("comment") && !line.starts_with("#")) continue;
        const std::size_t at = line.find(KEY);
        if (at == std::string::npos) continue;
        const std::size_t first = at + KEY.size();
        const std::size_t last = line.find_first_of(" \t;,", first);
        return {std::string(line.substr(first, last == std::string::npos ? last : last - first)),
                lines.number()};
    }
    return {};
}

}  // namespace palpate::scene
