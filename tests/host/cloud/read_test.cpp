#include <catch2/catch.hpp>
#include <fstream>
#include <iostream>

#include "host/cloud/formats.hpp"
#include "tests/host/cloud/samples.hpp"
#include "tests/lacking.hpp"

namespace palpate::cloud {
namespace {

using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
namespace fs = std::filesystem;

std::string read_error(const fs::path& file) {
    return test::error_of([&file] { static_cast<void>(read(file)); });
}

/// A folder of its own, removed at the end.
class Folder {
public:
    Folder() : path_(fs::temp_directory_path() / "palpate_cloud_read_test") {
        fs::remove_all(path_);
        fs::create_directories(path_);
    }
    ~Folder() { fs::remove_all(path_); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    [[nodiscard]] fs::path with(const std::string& name, const std::string& bytes) const {
        std::ofstream(path_ / name, std::ios::binary) << bytes;
        return path_ / name;
    }
    [[nodiscard]] const fs::path& path() const { return path_; }

private:
    fs::path path_;
};

}  // namespace

TEST_CASE("the extension names the format, in capitals too") {
    const Folder folder;
    CHECK(read(folder.with("a.OBJ", "v 0 0 0\nv 1 0 0\nv 0 1 0\n")).points_m.size() == 3);
    for (const auto encoding :
         {test::Encoding::ascii, test::Encoding::little_endian, test::Encoding::big_endian})
        CHECK(read(folder.with("a.Ply", test::sample_ply(encoding))).points_m == test::sample_points());
}

TEST_CASE("a file that cannot be read is refused with its name and what would be right") {
    const Folder folder;
    CHECK_THAT(read_error("missing.obj"), StartsWith("missing.obj:1: ") && Contains("no such file"));
    CHECK_THAT(read_error(folder.with("a.stl", "x")), Contains("`.stl`") && Contains(".obj or .ply"));
    CHECK_THAT(read_error(folder.with("none", "x")), Contains(".obj or .ply"));
    CHECK_THAT(read_error(folder.with("a.obj", "")), Contains("a.obj:1: ") && Contains("empty"));
    CHECK_THAT(read_error(folder.with("a.ply", "")), Contains("a.ply:1: ") && Contains("empty"));
    fs::create_directory(folder.path() / "d.obj");
    CHECK_THAT(read_error(folder.path() / "d.obj"), Contains("not a regular file"));
}

TEST_CASE("the installed bunny has 34835 points, none repeated, and 69666 faces") {
    const auto file = palpate::test::installed_bunny();
    if (!file) return;
    const Cloud cloud = read(*file);
    std::cout << "bunny: " << cloud.points_m.size() << " points, " << cloud.n_duplicates << " repeats\n";
    CHECK(cloud.points_m.size() + cloud.n_duplicates == 34835);
    CHECK(cloud.n_duplicates == 0);
    CHECK(cloud.triangles.size() == 69666);
    CHECK(cloud.points_m[0] == Eigen::Vector3d(0.296502, -0.907931, 0.450151));
}

TEST_CASE("the Stanford bunnies and the raw range image are read") {
    struct Row {
        std::string name;
        std::size_t n_points, n_triangles;
    };
    for (const Row& row : {Row{"bun_zipper.ply", 35947, 69451}, Row{"bun_zipper_res2.ply", 8171, 16301},
                           Row{"bun_zipper_res3.ply", 1889, 3851}, Row{"bun_zipper_res4.ply", 453, 948},
                           Row{"bun000.ply", 40256, 0}}) {
        const auto file = test::shared_file("bunny/" + row.name);
        if (!file) continue;
        const Cloud cloud = read(*file);
        CHECK(cloud.points_m.size() == row.n_points);
        CHECK(cloud.triangles.size() == row.n_triangles);
        CHECK(cloud.n_duplicates == 0);
    }
}

TEST_CASE("the odd but legal files of others are read, and the broken ones refused") {
    struct Row {
        std::string name;
        std::size_t n_points, n_duplicates, n_triangles;
    };
    for (const Row& row :
         {Row{"cube_att.ply", 8, 16, 12}, Row{"eof_test.obj", 3, 0, 1}, Row{"int_point_cloud.ply", 16, 0, 0},
          Row{"test_extra_whitespace.ply", 3, 0, 1}, Row{"test_more_datatypes.ply", 3, 0, 1}}) {
        const auto file = test::shared_file("formats/" + row.name);
        if (!file) continue;
        const Cloud cloud = read(*file);
        CHECK(cloud.points_m.size() == row.n_points);
        CHECK(cloud.n_duplicates == row.n_duplicates);
        CHECK(cloud.triangles.size() == row.n_triangles);
    }
    for (const auto& [name, says] :
         {std::pair{"float_inf_point_cloud.ply", ":8: z of the vertex is not finite"},
          std::pair{"inf_nan.obj", ":1: x of the vertex is not finite"},
          std::pair{"degenerate_mesh.obj", ":4: only 1 point (and 2 repeats"},
          std::pair{"object_template_0.pcd", ":1: extension `.pcd`"}}) {
        if (const auto file = test::shared_file(std::string("formats/") + name))
            CHECK_THAT(read_error(*file), Contains(says));
    }
}

TEST_CASE("the small files of others, cut off at any byte, are read or refused") {
    for (const std::string name : {"cube_att.ply", "int_point_cloud.ply", "test_extra_whitespace.ply",
                                   "test_more_datatypes.ply", "eof_test.obj"}) {
        const auto file = test::shared_file("formats/" + name);
        if (!file) continue;
        const std::string whole = test::bytes_of(*file);
        const auto read_part = name.ends_with(".obj") ? read_obj : read_ply;
        for (std::size_t length = 0; length < whole.size(); ++length) {
            const std::string error =
                test::error_of([&] { static_cast<void>(read_part(whole.substr(0, length), name)); });
            if (!error.empty()) REQUIRE_THAT(error, StartsWith(name + ':'));
        }
    }
}

}  // namespace palpate::cloud
