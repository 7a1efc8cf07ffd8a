#include <catch2/catch.hpp>

#include "host/cloud/formats.hpp"
#include "tests/host/cloud/samples.hpp"

namespace palpate::cloud {
namespace {

using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

Cloud obj(const std::string& text) {
    return read_obj(text, "t.obj");
}
std::string obj_error(const std::string& text) {
    return test::error_of([&text] { static_cast<void>(obj(text)); });
}

const std::string THREE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

}  // namespace

TEST_CASE(
    "vertices are read with and without weight, colour and opacity, in any spacing and with any line end") {
    const std::string end = GENERATE(as<std::string>{}, "\n", "\r\n", "\r");
    const std::string text = "# a comment" + end + "mtllib a.mtl" + end + end + "v 1.5 -2e-1 +3" + end +
                             "\tv  .5\t1. 0 1  " + end + "vn 0 0 1" + end + "v 4 5 6 0.1 0.2 0.3" + end +
                             "v 7 8 9 0.1 0.2 0.3 1" + end + "vt 0 1" + end + "o name";
    const Cloud cloud = obj(text);
    REQUIRE(cloud.points_m.size() == 4);
    CHECK(cloud.points_m[0] == Eigen::Vector3d(1.5, -0.2, 3.0));
    CHECK(cloud.points_m[1] == Eigen::Vector3d(0.5, 1.0, 0.0));
    CHECK(cloud.points_m[2] == Eigen::Vector3d(4, 5, 6));
    CHECK(cloud.points_m[3] == Eigen::Vector3d(7, 8, 9));
    CHECK(cloud.triangles.empty());
}

TEST_CASE("faces are read in every form, with negative indices, before their vertices, and as polygons") {
    const std::array<Index, 3> first{0, 1, 2};
    CHECK(obj(THREE + "f 1 2 3").triangles.at(0) == first);
    CHECK(obj(THREE + "f 1/7 2/8 3/9\n").triangles.at(0) == first);
    CHECK(obj(THREE + "f 1//7 2//8 3//9\n").triangles.at(0) == first);
    CHECK(obj(THREE + "f 1/4/7 2/5/8 3/6/9\n").triangles.at(0) == first);
    CHECK(obj(THREE + "f -3 -2 -1\nv 5 5 5\n").triangles.at(0) == first);
    CHECK(obj("f 1 2 3\n" + THREE).triangles.at(0) == first);
    const Cloud pentagon = obj(THREE + "v 1 1 0\nv 2 2 0\nf 1 2 3 4 5\n");
    CHECK(pentagon.triangles == std::vector<std::array<Index, 3>>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}});
}

TEST_CASE(
    "exact repeats of a point are merged, the faces follow, and a face that loses a corner is dropped") {
    const Cloud cloud =
        obj("v 0 0 0\nv 1 0 0\nv -0 0 0\nv 0 1 0\nv 1 0 0\nv 1 0 1e-300\nf 3 5 4\nf 1 3 4\nf 6 5 4\n");
    CHECK(cloud.n_duplicates == 2);
    REQUIRE(cloud.points_m.size() == 4);
    CHECK(cloud.points_m[2] == Eigen::Vector3d(0, 1, 0));
    CHECK(cloud.points_m[3] == Eigen::Vector3d(1, 0, 1e-300));
    CHECK(cloud.triangles == std::vector<std::array<Index, 3>>{{0, 1, 2}, {3, 1, 2}});
}

TEST_CASE("numbers do not follow the locale and use all their digits") {
    CHECK(obj("v 0.1 0.30000000000000004 1e-7\n" + THREE).points_m[0] ==
          Eigen::Vector3d(0.1, 0.30000000000000004, 1e-7));
}

TEST_CASE("a bad OBJ is refused with its line, what is wrong, and what would be right") {
    struct Row {
        std::string text, begins, says;
    };
    const Row row = GENERATE_COPY(values<Row>({
        {"", "t.obj:1: ", "empty"},
        {"# nothing\n\n", "t.obj:2: ", "no vertex"},
        {"ply\nformat ascii 1.0\n", "t.obj:2: ", "no vertex"},
        {THREE + "v abc 0 0\n", "t.obj:4: ", "`abc` is not a number"},
        {"v 0 0 0\nv 0,5 0 0\n", "t.obj:2: ", "`0,5` is not a number"},
        {"v 0 0 0\nv 0x10 0 0\n", "t.obj:2: ", "`0x10` is not a number"},
        {"v 0 0 0\nv 1e999 0 0\n", "t.obj:2: ", "`1e999` is not a number"},
        {"v 0 0 0\nv +-1 0 0\n", "t.obj:2: ", "`+-1` is not a number"},
        {"v 0 0 0\nv 1 0 0 red green blue\n", "t.obj:2: ", "`red`"},
        {"v 0 0\n", "t.obj:1: ", "2 numbers; a vertex is x y z"},
        {"v\n", "t.obj:1: ", "0 numbers"},
        {"v 1 2 3 4 5\n", "t.obj:1: ", "5 numbers"},
        {"v 1 2 3 4 5 6 7 8\n", "t.obj:1: ", "more than 7"},
        {"v 0 0 0\nv nan 0 0\n", "t.obj:2: ", "x of the vertex is not finite"},
        {"v 0 0 0\nv 0 -inf 0\n", "t.obj:2: ", "y of the vertex is not finite"},
        {"v 0 0 0\nv 0 0 +Inf\n", "t.obj:2: ", "z of the vertex is not finite"},
        {"v 0 0 0\nv 0 0 1e13\n", "t.obj:2: ", "z of the vertex is beyond"},
        {THREE + "f 1 2 4\n", "t.obj:4: ", "vertex 4 in a face, but there are 3"},
        {THREE + "f 1 2 9\nf 1 2 4\nv 9 9 9\n", "t.obj:4: ", "vertex 9 in a face, but there are 4"},
        {THREE + "f 1 2 -4\n", "t.obj:4: ", "vertex -4 in a face, but there are 3"},
        {THREE + "f 1 2 99999999999\n", "t.obj:4: ", "vertex 99999999999"},
        {THREE + "f 0 1 2\n", "t.obj:4: ", "count from 1"},
        {THREE + "f 1 2\n", "t.obj:4: ", "a face with 2 corners"},
        {THREE + "f 1 2 3.5\n", "t.obj:4: ", "`3.5` is not a corner"},
        {THREE + "f 1 2 3/x\n", "t.obj:4: ", "`3/x` is not a corner"},
        {THREE + "f 1 2 3/1/2/3\n", "t.obj:4: ", "`3/1/2/3` is not a corner"},
        {THREE + "f 1 2 3//\n", "t.obj:4: ", "`3//` is not a corner"},
        {"v 0 0 0\nv 1 0 0\n", "t.obj:2: ", "only 2 points; a surface needs at least 3"},
        {"v 0 0 0\nv 1 0 0\nv 1 0 0\n", "t.obj:3: ", "only 2 points (and 1 repeats"},
    }));
    CAPTURE(row.text);
    CHECK_THAT(obj_error(row.text), StartsWith(row.begins) && Contains(row.says));
}

TEST_CASE("a byte-order mark hides no vertex") {
    const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n";
    const Cloud plain = obj(text), marked = obj("\xEF\xBB\xBF" + text);
    CHECK(marked.points_m == plain.points_m);
    CHECK(marked.normals == plain.normals);
}

TEST_CASE("words from a hostile file are shown shortened and printable") {
    CHECK_THAT(obj_error("v " + std::string(100000, '\x1b') + " 0 0\n"),
               Contains("`????????????????????????????????...`"));
}

TEST_CASE("an OBJ cut off at any byte is refused, or read as far as it is complete") {
    const std::string text = "v 0 0 0\nv 10 0 0 1 1 1\nv 0 10 0\nv 0 0 10\nf 1/1/1 2/2/2 3/3/3\nf -1 -2 -3\n";
    std::size_t n_read = 0;
    for (std::size_t length = 0; length < text.size(); ++length) {
        const std::string part = text.substr(0, length);
        if (obj_error(part).empty()) {
            ++n_read;
            CHECK(obj(part).points_m.size() >= 3);
        } else {
            CHECK_THAT(obj_error(part), StartsWith("t.obj:"));
        }
    }
    CHECK(n_read > 0);
    CHECK(n_read < text.size());
}

}  // namespace palpate::cloud
