#include "host/scene/array_file.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "host/scene/scene.hpp"

using namespace palpate;
using Catch::Matchers::Contains;
using Eigen::ArrayXXd;

namespace {

std::string said_of(ArrayXXd (*parse)(std::string_view, const std::string&), std::string_view bytes) {
    try {
        static_cast<void>(parse(bytes, "a"));
    } catch (const scene::Error& error) {
        const std::string words = error.what();
        CHECK(words.find('\n') == std::string::npos);
        return words;
    }
    return "nothing";
}

std::string said_of_csv(std::string_view text) {
    return said_of(scene::parse_csv, text);
}
std::string said_of_npy(std::string_view bytes) {
    return said_of(scene::parse_npy, bytes);
}

/// A header as numpy writes it, version 1.0 or 2.0, then the numbers' bytes.
std::string npy(const std::string& descr, const std::string& order, const std::string& shape,
                const std::string& body, char major = 1) {
    std::string header =
        "{'descr': '" + descr + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }";
    header.resize(117, ' ');
    header += '\n';
    std::string out = "\x93NUMPY";
    out += {major, '\0', static_cast<char>(header.size()), '\0'};
    if (major == 2) out += {'\0', '\0'};
    return out + header + body;
}

template <class T>
std::string bytes_of(std::initializer_list<T> values, bool big_endian = false) {
    std::string out;
    for (const T& value : values) {
        std::array<char, sizeof(T)> raw{};
        std::memcpy(raw.data(), &value, raw.size());
        if (big_endian) std::reverse(raw.begin(), raw.end());
        out.append(raw.data(), raw.size());
    }
    return out;
}

/// The bytes that numpy 1.24 saves for np.array([[1, 2, 3], [4, 5, 6]], dtype='<f4').
std::string numpys_own() {
    std::string out = "\x93NUMPY";
    out += {'\1', '\0', '\x76', '\0'};
    out += "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }";
    out.resize(127, ' ');
    out += '\n';
    for (const char* value : {"\x80\x3f", "\x00\x40", "\x40\x40", "\x80\x40", "\xa0\x40", "\xc0\x40"})
        out += std::string("\0\0", 2) + std::string(value, 2);
    return out;
}

const ArrayXXd TWO_BY_THREE = (ArrayXXd(2, 3) << 1, 2, 3, 4, 5, 6).finished();

bool same(const ArrayXXd& a, const ArrayXXd& b) {
    return a.rows() == b.rows() && a.cols() == b.cols() && (a == b).all();
}

}  // namespace

TEST_CASE("a CSV of numbers is read by rows, with any line ends, spaces, signs and a byte-order mark") {
    for (const char* text :
         {"1,2,3\n4,5,6\n", "1,2,3\r\n4,5,6", "1,2,3\r4,5,6\r", " 1 ,\t2, +3\n4e0,50e-1,6.0\n",
          "\xEF\xBB\xBF"
          "1,2,3\n4,5,6\n\n\n"}) {
        INFO(text);
        CHECK(same(scene::parse_csv(text, "a"), TWO_BY_THREE));
    }
    CHECK(same(scene::parse_csv("7", "a"), ArrayXXd::Constant(1, 1, 7.0)));
    CHECK(std::isnan(scene::parse_csv("1,nan\n", "a")(0, 1)));
}

TEST_CASE("a bad CSV is refused with line and column") {
    CHECK(said_of_csv("") == "a:1: the file is empty; rows of numbers are expected");
    CHECK(said_of_csv("\n\n") == "a:1: the file is empty; rows of numbers are expected");
    CHECK(said_of_csv("1,2\n3,x\n") == "a:2: column 2 is `x`; a number is expected");
    CHECK(said_of_csv("1,2\n3,\n") == "a:2: column 2 is empty; a number is expected");
    CHECK(said_of_csv("1,2\n3,4,5\n") == "a:2: has 3 numbers; 2 are expected, as in the rows before");
    CHECK(said_of_csv("1,2\n3\n") == "a:2: has 1 number; 2 are expected, as in the rows before");
    CHECK(said_of_csv("1,2\n\n3,4\n") == "a:2: is empty; a row of numbers is expected");
    CHECK(said_of_csv("1 2\n") == "a:1: column 1 is `1 2`; a number is expected, and commas between numbers");
    CHECK(said_of_csv("1;2\n") == "a:1: column 1 is `1;2`; a number is expected, and commas between numbers");
    CHECK(said_of_csv("0x10\n") == "a:1: column 1 is `0x10`; a number is expected");
    CHECK(said_of_csv("# D in N m\n1\n") == "a:1: is a comment; numbers only are expected, without a header");
    CHECK_THAT(said_of_csv("1,\x01\xff\n"), Contains("a:1: column 2 is `??`"));
}

TEST_CASE("a CSV of more than 4097 rows or columns is refused, one of 4097 is not") {
    std::string row = "1", column = "1\n";
    for (int i = 1; i < 4097; ++i) {
        row += ",1";
        column += "1\n";
    }
    CHECK(scene::parse_csv(row, "a").cols() == 4097);
    CHECK(scene::parse_csv(column, "a").rows() == 4097);
    CHECK(said_of_csv(row + ",1") == "a:1: has more than 4097 columns; fewer are expected");
    CHECK(said_of_csv(column + "1\n") == "a:4098: there are more than 4097 rows; fewer are expected");
}

TEST_CASE("numpy's own bytes are read") {
    CHECK(same(scene::parse_npy(numpys_own(), "a"), TWO_BY_THREE));
}

TEST_CASE("an NPY is read in every type, byte order, array order and version") {
    const char major = GENERATE(as<char>{}, 1, 2);
    const bool big = GENERATE(false, true);
    const std::string end = big ? ">" : "<";
    const auto read = [&](const std::string& type, const std::string& order, const std::string& body) {
        return scene::parse_npy(npy(end + type, order, "(2, 3)", body, major), "a");
    };
    CHECK(same(read("f8", "False", bytes_of<double>({1, 2, 3, 4, 5, 6}, big)), TWO_BY_THREE));
    CHECK(same(read("f8", "True", bytes_of<double>({1, 4, 2, 5, 3, 6}, big)), TWO_BY_THREE));
    CHECK(same(read("f4", "False", bytes_of<float>({1, 2, 3, 4, 5, 6}, big)), TWO_BY_THREE));
    CHECK(same(read("f4", "True", bytes_of<float>({1, 4, 2, 5, 3, 6}, big)), TWO_BY_THREE));
    CHECK(same(read("i4", "False", bytes_of<std::int32_t>({-1, 2, 3, 4, 5, 6}, big)),
               (ArrayXXd(2, 3) << -1, 2, 3, 4, 5, 6).finished()));
    CHECK(same(read("i8", "True", bytes_of<std::int64_t>({-1, 4, 2, 5, 3, std::int64_t{1} << 40}, big)),
               (ArrayXXd(2, 3) << -1, 2, 3, 4, 5, 1099511627776.0).finished()));
}

TEST_CASE("a bad NPY is refused with what is wrong") {
    const std::string six = bytes_of<double>({1, 2, 3, 4, 5, 6});
    const std::string good = npy("<f8", "False", "(2, 3)", six);
    REQUIRE(said_of_npy(good) == "nothing");
    CHECK_THAT(said_of_npy("1,2\n"), Contains("a: does not begin as a .npy file"));
    CHECK_THAT(said_of_npy(npy("<f8", "False", "(2, 3)", six, 3)), Contains("is NPY 3.0; 1.0 or 2.0"));
    CHECK_THAT(said_of_npy(good.substr(0, good.size() - 1)),
               Contains("has 47 bytes of numbers; 48 are expected (truncated)"));
    CHECK_THAT(said_of_npy(good + "x"),
               Contains("has 49 bytes of numbers; 48 are expected (something follows)"));
    for (const std::size_t n : {std::size_t{7}, std::size_t{9}, std::size_t{60}})
        CHECK_THAT(said_of_npy(good.substr(0, n)), Contains("ends within its header"));
    CHECK_THAT(said_of_npy(npy("<f8", "False", "(6,)", six)), Contains("has 1 dimension; two are expected"));
    CHECK_THAT(said_of_npy(npy("<f8", "False", "(1, 2, 3)", six)), Contains("has 3 dimensions"));
    CHECK_THAT(said_of_npy(npy("<f8", "False", "()", six)), Contains("has 0 dimensions"));
    CHECK_THAT(said_of_npy(npy("<f8", "False", "(0, 3)", "")), Contains("is 0 x 3; 1 to 4097"));
    CHECK_THAT(said_of_npy(npy("<f8", "False", "(4098, 1)", "")), Contains("is 4098 x 1; 1 to 4097"));
    CHECK_THAT(said_of_npy(npy("<f8", "False", "(4294967296, 4294967296)", "")), Contains("1 to 4097"));
    CHECK_THAT(said_of_npy(npy("<f8", "False", "(99999999999999999999, 1)", "")), Contains("whole numbers"));
    CHECK_THAT(said_of_npy(npy("<f8", "False", "(-1, 3)", "")), Contains("whole numbers"));
    for (const char* type : {"<f2", "<c16", "|b1", "=f8", "f8", "<U3", "|O"})
        CHECK_THAT(said_of_npy(npy(type, "False", "(2, 3)", six)), Contains("holds numbers of type"));
    CHECK_THAT(said_of_npy(npy("<f8", "Maybe", "(2, 3)", six)), Contains("neither True nor False"));
    CHECK_THAT(said_of_npy(npy("<f8', 'descr': '<f8", "False", "(2, 3)", six)), Contains("`descr` too many"));
    CHECK_THAT(said_of_npy(npy("<f8', 'colour': 'red", "False", "(2, 3)", six)),
               Contains("`colour` too many"));
}

TEST_CASE("an array written as CSV or NPY reads back equal, to the last bit") {
    ArrayXXd values(3, 2);
    values << 1.0 / 3.0, -2.5e-17, 0.0, std::numeric_limits<double>::max(),
        std::numeric_limits<double>::denorm_min(), 6.02214076e23;
    CHECK(same(scene::parse_csv(scene::csv_text(values), "a"), values));
    const std::string bytes = scene::npy_bytes(values);
    CHECK(same(scene::parse_npy(bytes, "a"), values));
    CHECK((bytes.size() - 6 * sizeof(double)) % 64 == 0);
    CHECK(bytes == scene::array_bytes("w.npy", values));
    CHECK(scene::csv_text(values) == scene::array_bytes("w.CSV", values));
}

TEST_CASE("the first row of a written file is the first row of the array") {
    CHECK(scene::csv_text(TWO_BY_THREE) == "1,2,3\n4,5,6\n");
    CHECK(scene::npy_bytes(TWO_BY_THREE).substr(128) == bytes_of<double>({1, 2, 3, 4, 5, 6}));
    CHECK(scene::npy_bytes(TWO_BY_THREE) ==
          npy("<f8", "False", "(2, 3)", bytes_of<double>({1, 2, 3, 4, 5, 6})));
}

TEST_CASE("a file of numbers that cannot be read is refused by who names it") {
    const std::filesystem::path folder = std::filesystem::path(PAL_TEST_FOLDER) / "arrays";
    std::filesystem::create_directories(folder / "folder.csv");
    const auto said = [&](const std::filesystem::path& file) {
        try {
            static_cast<void>(scene::read_array(file, "p.toml:4"));
        } catch (const scene::Error& error) {
            return std::string(error.what());
        }
        return std::string("nothing");
    };
    CHECK_THAT(said(folder / "none.csv"),
               Contains("p.toml:4: ") && Contains("none.csv cannot be read (No such"));
    CHECK_THAT(said(folder / "folder.csv"), Contains("p.toml:4: ") && Contains("it is not a plain file"));
    CHECK_THAT(said("/dev/zero"), Contains("p.toml:4: ") && Contains("is no .csv or .npy"));
    std::filesystem::remove(folder / "zero.npy");
    std::filesystem::create_symlink("/dev/zero", folder / "zero.npy");
    CHECK_THAT(said(folder / "zero.npy"), Contains("it is not a plain file"));
    std::ofstream(folder / "a.csv") << "1,2\n3,x\n";
    CHECK_THAT(said(folder / "a.csv"), Contains("a.csv:2: column 2 is `x`"));
}
