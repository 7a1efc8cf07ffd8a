// Both readers of arrays on arbitrary bytes: an array that is written and read back alike, or Error on one
// line, and nothing else. Each input is read as a CSV and as an NPY, so that a seed is a file as it lies on a
// disk.
#include <cmath>

#include "host/scene/array_file.hpp"
#include "host/scene/plate_file.hpp"
#include "host/scene/scene.hpp"
#include "tests/fuzz/input.hpp"

namespace {

using fuzz::require;
using namespace palpate;

fuzz::Reached csv("CSV accepted"), npy("NPY accepted"), big_endian("NPY big-endian"),
    fortran("NPY by columns"), rigidity("a rigidity");

/// To the bit, but for which NaN it is.
bool same(const Eigen::ArrayXXd& a, const Eigen::ArrayXXd& b) {
    return a.rows() == b.rows() && a.cols() == b.cols() && (a == b || (a.isNaN() && b.isNaN())).all();
}

template <class Parse>
bool reads(Parse&& parse, std::string_view bytes) {
    try {
        const Eigen::ArrayXXd values = parse(bytes, "fuzz");
        require(values.rows() >= 1 && values.rows() <= scene::ARRAY_SIDE_MAX);
        require(values.cols() >= 1 && values.cols() <= scene::ARRAY_SIDE_MAX);
        require(static_cast<std::size_t>(values.size()) <= bytes.size());
        require(same(scene::parse_npy(scene::npy_bytes(values), "npy"), values));
        require(same(scene::parse_csv(scene::csv_text(values), "csv"), values));
        scene::check_rigidity(values, "fuzz");
        require((values > 0.0).all() && values.isFinite().all());
        rigidity.note();
    } catch (const scene::Error& error) {
        const std::string_view message = error.what();
        require(message.find("; ") != std::string_view::npos);  // what would be right
        for (const char c : message) require(c >= ' ' && c <= '~');
        return message.starts_with("fuzz: row ");  // an array, but no rigidity
    }
    return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view bytes = fuzz::text_of({data, size});
    if (reads(scene::parse_csv, bytes)) csv.note();
    if (!reads(scene::parse_npy, bytes)) return 0;
    npy.note();
    const std::string_view header = bytes.substr(0, 128);
    if (header.find("'>") != std::string_view::npos) big_endian.note();
    if (header.find("True") != std::string_view::npos) fortran.note();
    return 0;
}
