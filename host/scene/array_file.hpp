/// Two-dimensional arrays of numbers in files: CSV as people write it, NPY as numpy does. Row i, column j of
/// a file is element (i, j).
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>

namespace palpate::scene {

/// Longest side of an array in a file: what is written on the finest grid can be read.
inline constexpr Eigen::Index ARRAY_SIDE_MAX = 4097;

/// `.csv` or `.npy`, by the name's extension, whatever its case; false for anything else.
[[nodiscard]] bool is_array_name(const std::filesystem::path& file);

/// Reads a file by its extension. Throws Error that begins with `place` (who names the file) when it cannot
/// be read, else as the parsers do.
[[nodiscard]] Eigen::ArrayXXd read_array(const std::filesystem::path& file, const std::string& place);

/// Comma-separated numbers, as many in each row, `.` decimals, no header, no comments; LF, CRLF or CR; spaces
/// around a number, a byte-order mark and empty lines at the end are allowed. `nan` and `inf` are numbers.
/// Throws Error `name:line: ...` with the column, counted from 1.
[[nodiscard]] Eigen::ArrayXXd parse_csv(std::string_view text, const std::string& name);

/// NPY 1.0 or 2.0: two dimensions, <f4 <f8 <i4 <i8 and the same big-endian, C or Fortran order. Integers
/// beyond 2^53 are rounded. Throws Error `name: ...`; never trusts a size that the bytes do not hold.
[[nodiscard]] Eigen::ArrayXXd parse_npy(std::string_view bytes, const std::string& name);

/// The same numbers when read again.
[[nodiscard]] std::string csv_text(const Eigen::Ref<const Eigen::ArrayXXd>& values);
/// NPY 1.0, <f8, C order.
[[nodiscard]] std::string npy_bytes(const Eigen::Ref<const Eigen::ArrayXXd>& values);
/// Either, by the name's extension.
[[nodiscard]] std::string array_bytes(const std::filesystem::path& file,
                                      const Eigen::Ref<const Eigen::ArrayXXd>& values);

}  // namespace palpate::scene
