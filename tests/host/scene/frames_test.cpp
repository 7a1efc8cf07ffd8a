#include "host/scene/frames.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <set>
#include <sstream>
#include <vector>

#include "common/frame.h"
#include "host/chart/chart.hpp"
#include "host/scene/world.hpp"

using namespace palpate::scene;
using Eigen::Vector3d;

namespace {

constexpr double DIGITS_M = 1e-12;       // the page's vectors have few digits, the turns are exact
constexpr double DIGITS_AZIMUTH = 2e-6;  // six digits on the page

std::vector<std::string> cells(const std::string& line) {
    std::vector<std::string> out;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, '|');) {
        const std::size_t first = cell.find_first_not_of(' ');
        if (first == std::string::npos) continue;
        out.push_back(cell.substr(first, cell.find_last_not_of(' ') - first + 1));
    }
    return out;
}

/// The rows of the first table under a heading of docs/FRAMES.md, without its head.
std::vector<std::vector<std::string>> rows_under(const std::string& heading) {
    std::ifstream in(PAL_FRAMES_MD);
    std::vector<std::vector<std::string>> rows;
    bool here = false;
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("## ")) here = line == "## " + heading;
        if (here && line.starts_with("|")) rows.push_back(cells(line));
    }
    REQUIRE(rows.size() > 2);
    rows.erase(rows.begin(), rows.begin() + 2);
    return rows;
}

Vector3d vector(const std::string& cell) {
    std::istringstream in(cell);
    char open = 0, comma = 0, close = 0;
    Vector3d v;
    in >> open >> v.x() >> comma >> v.y() >> comma >> v.z() >> close;
    INFO(cell);
    REQUIRE((in && open == '(' && close == ')'));
    return v;
}

std::string unquoted(const std::string& cell) {
    INFO(cell);
    REQUIRE((cell.size() > 2 && cell.front() == '`' && cell.back() == '`'));
    return cell.substr(1, cell.size() - 2);
}

std::set<std::string> names_in_code() {
    std::set<std::string> names;
    for (const Convention& c : conventions()) names.emplace(c.name);
    return names;
}

}  // namespace

TEST_CASE("every worked vector of docs/FRAMES.md is what the code makes of it, both ways") {
    std::set<std::string> with_place, with_force;
    for (const auto& row : rows_under("Worked vectors")) {
        REQUIRE(row.size() == 4);
        const Convention& c = convention(unquoted(row[0]));
        const Vector3d own = vector(row[2]), workspace = vector(row[3]);
        CAPTURE(c.name, row[1], row[2], row[3]);
        const bool place = row[1] == "place";
        REQUIRE((place || row[1] == "force"));
        if (place) {
            CHECK((to_workspace_m(c, own) - workspace).norm() < DIGITS_M);
            CHECK((from_workspace_m(c, workspace) - own).norm() < DIGITS_M);
        } else {
            CHECK((c.turn * own - workspace).norm() < DIGITS_M);
        }
        // Three components of different size tell every axis and sign from every other.
        const Vector3d size = own.cwiseAbs();
        const bool tells =
            size.minCoeff() > 0.0 && size.x() != size.y() && size.y() != size.z() && size.z() != size.x();
        if (tells) (place ? with_place : with_force).insert(std::string(c.name));
    }
    CHECK(with_place == names_in_code());
    CHECK(with_force == names_in_code());
}

TEST_CASE("docs/FRAMES.md describes the conventions of the code and no others") {
    std::set<std::string> described;
    for (const auto& row : rows_under("Conventions")) described.insert(unquoted(row[0]));
    CHECK(described == names_in_code());
}

TEST_CASE("every convention is a right-handed turn, and object axes move nothing") {
    for (const Convention& c : conventions()) {
        CAPTURE(c.name);
        CHECK(c.turn * c.turn.transpose() == Eigen::Matrix3d::Identity());
        CHECK(c.turn.determinant() == 1.0);
        if (c.is_object_axes) CHECK(c.origin_m == Vector3d::Zero());
    }
    CHECK_THROWS_AS(convention("SPL"), std::out_of_range);
}

TEST_CASE("the azimuth of docs/FRAMES.md is that of the chart") {
    for (const auto& row : rows_under("The contact frame and where its azimuth flips")) {
        REQUIRE(row.size() == 2);
        const auto frame = palpate::chart::frame_at(Vector3d::Zero(), vector(row[0]), 0.0);
        CAPTURE(row[0], row[1]);
        CHECK((frame.axes.row(0).transpose() - vector(row[1])).norm() < DIGITS_AZIMUTH);
    }
}

TEST_CASE("a scan in LPS or RAS is turned to face the operator, its numbers in a file's own axes stay") {
    struct Row {
        const char* axes;
        Vector3d expected;  // of the point 10 mm left, 30 mm in front, 20 mm towards the head in LPS
    };
    const Row row = GENERATE(values<Row>(
        {{"LPS", {0.01, 0.02, 0.03}}, {"RAS", {-0.01, 0.02, -0.03}}, {"file", {0.01, -0.03, 0.02}}}));
    Scene scene;
    scene.object.length_unit = "mm";
    scene.object.axes = row.axes;
    scene.skin.young_pa = 0.4e6;
    scene.skin.thickness_m = 0.0015;
    palpate::cloud::Cloud cloud;
    for (int i = -20; i <= 20; ++i) {
        for (int j = -20; j <= 20; ++j) cloud.points_m.emplace_back(10.0 + i, -30.0, 20.0 + j);
    }
    const auto world = build(scene, cloud);
    CHECK((world->cloud.points_m[41 * 20 + 20] - row.expected).norm() < DIGITS_M);
}

/// More and longer lines than a person writes.
const std::string LONG_HEAD = [] {
    std::string head = "ply\ncomment " + std::string(5000, 'x') + '\n';
    for (int i = 0; i < 400; ++i) head += "obj_info nothing\n";
    return head + "comment SPACE=RAS\nend_header\n";
}();

TEST_CASE("what a scan says about its axes is found in its head, with the line, and nowhere else") {
    struct Row {
        const char* text;
        const char* space;
        std::size_t line;
    };
    const Row row =
        GENERATE(values<Row>({{"ply\nformat ascii 1.0\ncomment SPACE=LPS\nend_header\n", "LPS", 3},
                              {"ply\r\ncomment made by x; SPACE=RAS\r\nend_header\r\n", "RAS", 2},
                              {"# SPACE=LPS\nv 0 0 0\n", "LPS", 1},
                              {LONG_HEAD.c_str(), "RAS", 403},
                              {"ply\rcomment SPACE=LPS\rend_header\r", "LPS", 2},
                              {"# nothing\nv 0 0 0\n", "", 0},
                              {"ply\nend_header\ncomment SPACE=LPS\n", "", 0},
                              {"ply\nelement SPACE=LPS\nend_header\n", "", 0},
                              {"", "", 0}}));
    const std::filesystem::path file = std::filesystem::path(PAL_TEST_FOLDER) / "space_comment.ply";
    std::ofstream(file, std::ios::binary) << row.text;
    CAPTURE(row.text);
    CHECK(space_comment(file).space == row.space);
    CHECK(space_comment(file).line == row.line);
    CHECK(space_comment(file / "missing").space.empty());
}

TEST_CASE("a scan that says RAS is refused by a scene that says LPS, with the comment's line") {
    const std::filesystem::path file = std::filesystem::path(PAL_TEST_FOLDER) / "in_ras.obj";
    std::ofstream(file) << "# a face\n# SPACE=RAS\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
    Scene scene;
    scene.file = file;
    scene.object.points = file;
    scene.object.length_unit = "mm";
    scene.object.axes = "LPS";
    CHECK_THROWS_WITH(build(scene), Catch::Matchers::Contains("in_ras.obj:2: the file says SPACE=RAS") &&
                                        Catch::Matchers::Contains("set object.axes"));
}

TEST_CASE("the falcon's origin on the page is that of the code") {
    CHECK(to_workspace_m(convention("falcon"), {PAL_WORKSPACE_CENTRE_X_M, PAL_WORKSPACE_CENTRE_Y_M,
                                                PAL_WORKSPACE_CENTRE_Z_M}) == Vector3d::Zero());
}
