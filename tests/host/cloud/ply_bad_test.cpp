#include <catch2/catch.hpp>

#include "host/cloud/formats.hpp"
#include "tests/host/cloud/samples.hpp"

namespace palpate::cloud {
namespace {

using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

std::string ply_error(const std::string& bytes) {
    return test::error_of([&bytes] { static_cast<void>(read_ply(bytes, "t.ply")); });
}

struct Row {
    std::string bytes, begins, says;
};

const std::string START = "ply\nformat ascii 1.0\n";
const std::string XYZ = "property float x\nproperty float y\nproperty float z\n";
const std::string FACES = "property list uchar int vertex_indices\n";
const std::string VERTICES = "0 0 0\n1 0 0\n0 1 0\n";

std::string vertices(const std::string& count) {
    return START + "element vertex " + count + "\n" + XYZ;
}
std::string points_only(const std::string& body) {
    return vertices("3") + "end_header\n" + body;
}
std::string one_face(const std::string& face) {
    return vertices("3") + "element face 1\n" + FACES + "end_header\n" + VERTICES + face;
}
/// One binary face after three vertices of bytes; `length` and `corner` are PLY types.
std::string binary_face(const std::string& length, const std::string& corner, const std::string& face) {
    return "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty char x\nproperty char y\nproperty "
           "char z\n"
           "element face 1\nproperty list " +
           length + ' ' + corner + " vertex_indices\nend_header\n" + std::string(3, '\0') + "\1\2\3\4\5\6" +
           face;
}

void check(const Row& row) {
    CAPTURE(row.bytes.substr(0, 400));
    CHECK_THAT(ply_error(row.bytes), StartsWith(row.begins) && Contains(row.says) && Contains(";"));
}

}  // namespace

TEST_CASE("a bad PLY header is refused with its line, what is wrong, and what would be right") {
    const Row row = GENERATE_COPY(values<Row>({
        {"", "t.ply:1: ", "empty"},
        {"v 0 0 0\n", "t.ply:1: ", "first line is not `ply`"},
        {START + "element vertex 3\n" + XYZ, "t.ply:6: ", "ends inside its header"},
        {START + "element vertex 3\n" + XYZ + VERTICES, "t.ply:7: ", "`0` is not a header word"},
        {vertices("4000000000") + "end_header\n" + VERTICES, "t.ply:3: ", "declares 4000000000 entries"},
        {vertices("99999999999999999999") + "end_header\n" + VERTICES,
         "t.ply:3: ", "count `99999999999999999999`"},
        {vertices("9223372036854775807") + "end_header\n" + VERTICES, "t.ply:3: ", "has room for 3"},
        {vertices("-3") + "end_header\n" + VERTICES, "t.ply:3: ", "count `-3`"},
        {vertices("3.0") + "end_header\n" + VERTICES, "t.ply:3: ", "count `3.0`"},
        {START + "element vertex 3\nproperty float x\nproperty float y\nend_header\n0 0\n1 0\n0 1\n",
         "t.ply:3: ", "no property `z`"},
        {START + "element vertex 3\n" + XYZ + "property float y\nend_header\n",
         "t.ply:7: ", "property `y` of element `vertex` is declared twice"},
        {START + "element vertex 3\n" + XYZ + "element vertex 3\nend_header\n",
         "t.ply:7: ", "declared twice, first on line 3"},
        {START + "element vertex 3\nproperty list uchar float x\nproperty float y\nproperty float "
                 "z\nend_header\n",
         "t.ply:3: ", "`x` of element vertex is a list"},
        {START + "element face 1\n" + FACES + "end_header\n", "t.ply:5: ", "no element vertex"},
        {START + "property float x\n", "t.ply:3: ", "before any element"},
        {START + "element vertex 3\nproperty half x\n", "t.ply:4: ", "type `half`"},
        {START + "element vertex 3\nproperty float\n", "t.ply:4: ", "without a name"},
        {START + "element vertex 3\nproperty list float int a\n", "t.ply:4: ", "length of a list"},
        {START + "element vertex 3 4\n", "t.ply:3: ", "`4` is one word too many"},
        {START + "element\n", "t.ply:3: ", "without a name"},
        {START + "format ascii 1.0\n", "t.ply:3: ", "second line `format`"},
        {"ply\nelement vertex 3\n" + XYZ + "end_header\n" + VERTICES, "t.ply:6: ", "no line `format`"},
        {"ply\nformat ascii 2.0\n", "t.ply:2: ", "version `2.0`"},
        {"ply\nformat binary 1.0\n", "t.ply:2: ", "encoding `binary`"},
        {START + "comment " + std::string(1000000, 'a') + '\n' + vertices("3").substr(START.size()) +
             "end_header\n" + VERTICES,
         "t.ply:3: ", "over 64 KiB"},
        {START +
             [] {
                 std::string lines;
                 for (int i = 0; i < 10000; ++i) lines += "comment\n";
                 return lines;
             }(),
         "t.ply:10001: ", "over 10000 lines"},
        {vertices("3") + "element empty 4000000000\nend_header\n" + VERTICES, "t.ply:7: ", "no properties"},
        {vertices("3") + "element face 1\nproperty list uchar float vertex_indices\nend_header\n" + VERTICES +
             "3 0 1 2\n",
         "t.ply:7: ", "not whole numbers"},
    }));
    check(row);
}

TEST_CASE("a bad ascii PLY body is refused with its line, what is wrong, and what would be right") {
    const Row row = GENERATE_COPY(values<Row>({
        {points_only("0 0 0\n1.00000 0 0\n"), "t.ply:9: ", "ends after 2 of 3 entries of element vertex"},
        {points_only("0 0 0\n1.00000 0 0\n0.0000 1"), "t.ply:10: ", "ends before z of element vertex"},
        {points_only("0 0 0\nnan 0 0\n0 1 0\n"), "t.ply:9: ", "x of the vertex is not finite"},
        {points_only("0 0 0\n1 inf 0\n0 1 0\n"), "t.ply:9: ", "y of the vertex is not finite"},
        {points_only("0 0 0\n1 0 -inf\n0 1 0\n"), "t.ply:9: ", "z of the vertex is not finite"},
        {points_only("0 0 0\n1 abc 0\n0 1 0\n"), "t.ply:9: ", "y is `abc`"},
        {points_only("0 0 0\n0,5 0 0\n0 1 0\n"), "t.ply:9: ", "x is `0,5`"},
        {points_only("0 0 0\n1 0 0 7\n0 1 0\n"), "t.ply:9: ", "`7` is more than element vertex declares"},
        {points_only(VERTICES + "\n4 4 4\n"), "t.ply:12: ", "after the last declared entry"},
        {vertices("2") + "end_header\n0 0 0\n1 0 0\n",
         "t.ply:3: ", "only 2 points; a surface needs at least 3"},
        {vertices("0") + "end_header\n", "t.ply:3: ", "only 0 points"},
        {points_only("0 0 0\n0 0 0\n-0 0 0\n"), "t.ply:3: ", "only 1 point (and 2 repeats"},
        {one_face("3 0 1 3\n"), "t.ply:13: ", "vertex 3 in a face, but there are 3"},
        {one_face("3 0 1 -1\n"), "t.ply:13: ", "vertex -1 in a face"},
        {one_face("3 0 1 2.5\n"), "t.ply:13: ", "vertex_indices is `2.5`"},
        {one_face("4 0 1 2\n"), "t.ply:13: ", "ends before vertex_indices"},
        {one_face("2 0 1\n"), "t.ply:13: ", "a face with 2 corners"},
        {one_face("-1 0 1\n"), "t.ply:13: ", "length -1"},
        {one_face("9000000000000000000 0 1\n"), "t.ply:13: ", "length 9000000000000000000"},
    }));
    check(row);
}

TEST_CASE("a bad binary PLY body is refused with the element's line, the byte, and what would be right") {
    const std::string whole = test::sample_ply(test::Encoding::little_endian);
    const std::size_t body = whole.find("end_header\n") + 11;
    const std::string nan_x = "ply\nformat binary_big_endian 1.0\nelement vertex 3\n" + XYZ + "end_header\n" +
                              std::string(12, '\0') + "\x7f\xc0" + std::string(22, '\0');
    const Row row = GENERATE_COPY(values<Row>({
        {whole.substr(0, body + 17), "t.ply:5: byte 14 of element tristrips: ", "ends in entry 2 of 2"},
        {whole.substr(0, whole.size() - 1), "t.ply:14: byte 16 of element face: ", "length 3"},
        {whole.substr(0, whole.size() - 40), "t.ply:8: ", "declares 4 entries, but the file has room for 3"},
        {whole + "x", "t.ply:14: byte 28 of element face: ", "1 bytes after the last declared entry"},
        {nan_x, "t.ply:3: byte 24 of element vertex: ", "x of the vertex is not finite"},
        {binary_face("char", "uchar", "\xff"), "t.ply:7: byte 1 of element face: ", "length -1"},
        {binary_face("uint", "uchar", "\xff\xff\xff\xff"),
         "t.ply:7: byte 4 of element face: ", "length 4294967295"},
        {binary_face("uchar", "uchar", "\3\1\2\3"),
         "t.ply:7: byte 4 of element face: ", "vertex 3 in a face"},
        {binary_face("uchar", "char", "\3\1\2\xff"),
         "t.ply:7: byte 4 of element face: ", "vertex -1 in a face"},
    }));
    check(row);
}

TEST_CASE("a name with bytes that are no text is shown without them") {
    const std::string name("a\0\x1b[31m", 7);
    const std::string bytes =
        vertices("3") + "property float " + name + "\nend_header\n0 0 0 0\n1 0 0\n0 1 0 0 0\n";
    CHECK_THAT(ply_error(bytes), Contains("the line ends before a??[31m of element vertex; "));
}

}  // namespace palpate::cloud
