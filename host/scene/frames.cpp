#include "host/scene/frames.hpp"

#include <array>
#include <fstream>
#include <stdexcept>

#include "common/frame.h"

namespace palpate::scene {
namespace {

constexpr std::size_t HEADER_LINES_MAX = 200;
constexpr std::size_t HEADER_LINE_MAX = 256;  // a binary body may have no line end for long

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

/// Like std::getline, but never longer than a header's line can be. False at the end and for a longer one.
bool short_line(std::istream& in, std::string& line) {
    line.clear();
    for (char c = 0; in.get(c);) {
        if (c == '\n') return true;
        if (line.size() == HEADER_LINE_MAX) return false;
        line.push_back(c);
    }
    return !line.empty();
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
    std::string line;
    for (std::size_t number = 1; number <= HEADER_LINES_MAX && short_line(in, line); ++number) {
        if (line.starts_with("end_header")) break;
        if (!line.starts_with("comment") && !line.starts_with("#")) continue;
        const std::size_t at = line.find(KEY);
        if (at == std::string::npos) continue;
        const std::size_t first = at + KEY.size();
        const std::size_t last = line.find_first_of(" \t\r;,", first);
        return {line.substr(first, last == std::string::npos ? last : last - first), number};
    }
    return {};
}

}  // namespace palpate::scene
