/// Lines, words and numbers of a text file in memory, free of locale, and places in it for messages.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace palpate::cloud {

/// Where in a file something is wrong.
struct Place {
    const std::string* name;
    std::size_t line = 1;
    std::string_view element = {};         ///< of a binary body; `line` then declares it
    std::optional<std::size_t> byte = {};  ///< from the start of that element
    /// Throws Error `name:line: what`, for a binary body `name:line: byte N of element E: what`.
    [[noreturn]] void fail(const std::string& what) const;
};

/// Lines of a text that ends them with LF, CRLF or CR. A text whose first line ends with a lone CR knows no
/// other end, so that a binary body after it may begin with an LF.
class Lines {
public:
    /// A byte-order mark at the beginning belongs to no line.
    explicit Lines(std::string_view bytes)
        : bytes_(bytes), offset_(bytes.starts_with("\xEF\xBB\xBF") ? 3 : 0) {}
    /// False at the end. The view is without its line end.
    bool next(std::string_view& line);
    [[nodiscard]] std::size_t number() const { return number_; }  ///< of the line that next() gave, from 1
    [[nodiscard]] std::size_t offset() const { return offset_; }  ///< of the first byte after it
    [[nodiscard]] std::size_t n_left() const { return bytes_.size() - offset_; }

private:
    std::string_view bytes_;
    std::size_t offset_;
    std::size_t number_ = 0;
    bool only_cr_ = false;
};

/// Words between spaces and tabs.
class Words {
public:
    explicit Words(std::string_view line) : rest_(line) {}
    /// Empty at the end.
    std::string_view next();

private:
    std::string_view rest_;
};

/// The whole word as a number; nullopt when it is none or does not fit. "nan" and "inf" are numbers here.
[[nodiscard]] std::optional<double> real(std::string_view word);
[[nodiscard]] std::optional<std::int64_t> whole(std::string_view word);

/// A word of a file as a message may show it: ASCII, shortened when it is long.
[[nodiscard]] std::string printable(std::string_view word);
/// The same between back quotes.
[[nodiscard]] std::string in_quotes(std::string_view word);

}  // namespace palpate::cloud
