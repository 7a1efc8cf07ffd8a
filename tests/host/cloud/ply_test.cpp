#include <array>
#include <catch2/catch.hpp>

#include "host/cloud/formats.hpp"
#include "tests/host/cloud/samples.hpp"

namespace palpate::cloud {
namespace {

using test::Encoding;
constexpr std::array ENCODINGS{Encoding::ascii, Encoding::little_endian, Encoding::big_endian};

Cloud ply(const std::string& bytes) {
    return read_ply(bytes, "t.ply");
}
std::string ply_error(const std::string& bytes) {
    return test::error_of([&bytes] { static_cast<void>(ply(bytes)); });
}

void check_sample(const Cloud& cloud) {
    CHECK(cloud.points_m == test::sample_points());
    CHECK(cloud.triangles == std::vector<std::array<Index, 3>>{{0, 1, 2}, {3, 2, 1}});
    CHECK(cloud.n_duplicates == 0);
    CHECK(cloud.normals.empty());
    CHECK(cloud.young_pa.empty());
}

}  // namespace

TEST_CASE("every encoding, every type of coordinate and every line end give the same cloud") {
    for (const Encoding encoding : ENCODINGS) {
        for (const std::string type :
             {"char", "int8", "uchar", "uint8", "short", "int16", "ushort", "uint16", "int", "int32", "uint",
              "uint32", "float", "float32", "double", "float64"}) {
            for (const std::string end : {"\n", "\r\n", "\r"}) {
                CAPTURE(static_cast<int>(encoding), type, end);
                check_sample(ply(test::sample_ply(encoding, type, end)));
            }
        }
    }
}

TEST_CASE("a binary body after CR line ends may begin with the byte of an LF") {
    const std::string head =
        "ply\rformat binary_little_endian 1.0\relement vertex 3\rproperty char x\rproperty char y\r"
        "property char z\rend_header\r";
    const Cloud cloud = ply(head + "\n\x01\x02\x03\x04\x05\x06\x07\x08");
    REQUIRE(cloud.points_m.size() == 3);
    CHECK(cloud.points_m[0] == Eigen::Vector3d(10, 1, 2));
}

TEST_CASE("elements come in any order, faces before their vertices too") {
    const Cloud cloud = ply(
        "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex 3\n"
        "property int z\nproperty int y\nproperty int x\nend_header\n3 2 1 0\n0 0 0\n0 0 1\n0 1 0\n");
    CHECK(cloud.points_m[1] == Eigen::Vector3d(1, 0, 0));
    CHECK(cloud.triangles.at(0) == std::array<Index, 3>{2, 1, 0});
}

TEST_CASE("values that are not needed may be anything a number can be") {
    const Cloud cloud =
        ply("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
            "property float nx\nend_header\n0 0 0 nan\n1 0 0 -inf\n\n0 1 0 +1\n\n");
    CHECK(cloud.points_m.size() == 3);
}

TEST_CASE(
    "a PLY cut off at any byte is refused; only the last digits and the last line end can go unnoticed") {
    for (const Encoding encoding : ENCODINGS) {
        const std::string whole = test::sample_ply(encoding, "double");
        for (std::size_t length = 0; length < whole.size(); ++length) {
            CAPTURE(static_cast<int>(encoding), length, whole.size());
            const std::string part = whole.substr(0, length);
            const bool only_line_end_missing = encoding == Encoding::ascii && whole.size() - length <= 2;
            if (only_line_end_missing)
                check_sample(ply(part));
            else
                CHECK_THAT(ply_error(part), Catch::Matchers::StartsWith("t.ply:"));
        }
    }
}

TEST_CASE("a PLY with any one byte changed is read or refused, never more") {
    for (const Encoding encoding : ENCODINGS) {
        const std::string whole = test::sample_ply(encoding);
        for (std::size_t at = 0; at < whole.size(); ++at) {
            for (const char byte : {'\0', '\xff', '9', ' ', '\n', '-'}) {
                std::string changed = whole;
                changed[at] = byte;
                const std::string error = ply_error(changed);
                if (error.empty()) CHECK(ply(changed).points_m.size() >= 3);
            }
        }
    }
}

}  // namespace palpate::cloud
