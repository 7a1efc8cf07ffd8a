#include "host/scene/array_file.hpp"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>
#include <vector>

#include "host/cloud/text.hpp"
#include "host/scene/keys.hpp"

namespace palpate::scene {
namespace {

using Eigen::Index;

constexpr std::uintmax_t FILE_BYTES_MAX = 32U * ARRAY_SIDE_MAX * ARRAY_SIDE_MAX;  // 32 characters a number
constexpr std::string_view BYTE_ORDER_MARK = "\xEF\xBB\xBF";

std::string lower_extension(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return extension;
}

std::string_view trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// Where in a CSV something is wrong.
struct CsvPlace {
    const std::string& name;
    std::size_t line;
    [[noreturn]] void fail(const std::string& words) const {
        refuse(name + ":" + std::to_string(line), words);
    }
};

double cell_value(std::string_view cell, const CsvPlace& place, std::size_t column) {
    const std::string_view word = trimmed(cell);
    if (const auto value = cloud::real(word)) return *value;
    const std::string where = "column " + std::to_string(column);
    if (word.empty()) place.fail(where + " is empty; a number is expected");
    if (place.line == 1 && column == 1 && word[0] == '#')
        place.fail("is a comment; numbers only are expected, without a header");
    const bool spaced = word.find_first_of(" \t;") != std::string_view::npos;
    place.fail(where + " is " + cloud::in_quotes(word) + "; a number is expected" +
               (spaced ? ", and commas between numbers" : ""));
}

std::size_t add_row(std::string_view line, const CsvPlace& place, std::vector<double>& values) {
    std::size_t n = 0;
    for (std::size_t begin = 0; begin <= line.size();) {
        const std::size_t end = std::min(line.find(',', begin), line.size());
        values.push_back(cell_value(line.substr(begin, end - begin), place, ++n));
        if (n > ARRAY_SIDE_MAX)
            place.fail("has more than " + std::to_string(ARRAY_SIDE_MAX) + " columns; fewer are expected");
        begin = end + 1;
    }
    return n;
}

std::string read_all(const std::filesystem::path& file, const std::string& place) {
    const auto fail = [&](const std::string& why) {
        refuse(place, file.string() + " cannot be read (" + why + "); a .csv or .npy file is expected");
    };
    std::error_code error;
    const auto status = std::filesystem::status(file, error);
    if (!std::filesystem::exists(status)) fail("No such file or directory");
    if (!std::filesystem::is_regular_file(status)) fail("it is not a plain file");
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    if (error) fail(error.message());
    if (size > FILE_BYTES_MAX) fail("it has more than " + std::to_string(FILE_BYTES_MAX >> 20U) + " MiB");
    errno = 0;
    std::ifstream in(file, std::ios::binary);
    std::string bytes;
    if (in) bytes.assign(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    if (!in) fail(std::generic_category().message(errno));
    return bytes;
}

}  // namespace

bool is_array_name(const std::filesystem::path& file) {
    const std::string extension = lower_extension(file);
    return extension == ".csv" || extension == ".npy";
}

Eigen::ArrayXXd read_array(const std::filesystem::path& file, const std::string& place) {
    const bool npy = lower_extension(file) == ".npy";
    if (!npy && !is_array_name(file)) refuse(place, file.string() + " is no .csv or .npy file");
    const std::string bytes = read_all(file, place);
    return npy ? parse_npy(bytes, file.string()) : parse_csv(bytes, file.string());
}

Eigen::ArrayXXd parse_csv(std::string_view text, const std::string& name) {
    if (text.starts_with(BYTE_ORDER_MARK)) text.remove_prefix(BYTE_ORDER_MARK.size());
    cloud::Lines lines(text);
    std::vector<double> values;
    std::size_t n_rows = 0, n_columns = 0, empty_line = 0;
    for (std::string_view line; lines.next(line);) {
        const CsvPlace place{name, lines.number()};
        if (trimmed(line).empty()) {
            if (empty_line == 0) empty_line = place.line;
            continue;
        }
        if (empty_line != 0) CsvPlace{name, empty_line}.fail("is empty; a row of numbers is expected");
        if (n_rows == ARRAY_SIDE_MAX)
            place.fail("there are more than " + std::to_string(ARRAY_SIDE_MAX) + " rows; fewer are expected");
        const std::size_t n = add_row(line, place, values);
        if (n_rows > 0 && n != n_columns)
            place.fail("has " + std::to_string(n) + (n == 1 ? " number" : " numbers") + "; " +
                       std::to_string(n_columns) + " are expected, as in the rows before");
        n_columns = n;
        ++n_rows;
    }
    if (n_rows == 0) CsvPlace{name, 1}.fail("the file is empty; rows of numbers are expected");
    using RowMajor = Eigen::Array<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<const RowMajor>(values.data(), static_cast<Index>(n_rows),
                                      static_cast<Index>(n_columns));
}

std::string csv_text(const Eigen::Ref<const Eigen::ArrayXXd>& values) {
    std::string out;
    for (Index i = 0; i < values.rows(); ++i) {
        for (Index j = 0; j < values.cols(); ++j) {
            if (j > 0) out += ',';
            out += number_text(values(i, j));
        }
        out += '\n';
    }
    return out;
}

std::string array_bytes(const std::filesystem::path& file, const Eigen::Ref<const Eigen::ArrayXXd>& values) {
    return lower_extension(file) == ".npy" ? npy_bytes(values) : csv_text(values);
}

}  // namespace palpate::scene
