#include "host/cloud/text.hpp"

#include <charconv>

#include "host/cloud/cloud.hpp"

namespace palpate::cloud {
namespace {

constexpr std::size_t SHOWN_MAX_CHARS = 32;

template <class Number>
std::optional<Number> parsed(std::string_view word) {
    if (word.size() > 1 && word[0] == '+' && word[1] != '-')
        word.remove_prefix(1);  // from_chars knows no plus sign
    Number number{};
    const char* const end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, number);
    if (error != std::errc() || stop != end) return std::nullopt;
    return number;
}

bool is_space(char c) {
    return c == ' ' || c == '\t';
}

}  // namespace

void Place::fail(const std::string& what) const {
    std::string message = *name + ':' + std::to_string(line) + ": ";
    if (byte) message += "byte " + std::to_string(*byte) + " of element " + printable(element) + ": ";
    throw Error(message + what);
}

bool Lines::next(std::string_view& line) {
    if (offset_ == bytes_.size()) return false;
    const std::string_view rest = bytes_.substr(offset_);
    const std::size_t length = std::min(only_cr_ ? rest.find('\r') : rest.find_first_of("\r\n"), rest.size());
    line = rest.substr(0, length);
    offset_ += length;
    ++number_;
    if (length == rest.size()) return true;
    const bool is_cr = rest[length] == '\r';
    const bool is_crlf = is_cr && !only_cr_ && length + 1 < rest.size() && rest[length + 1] == '\n';
    offset_ += is_crlf ? 2 : 1;
    if (number_ == 1 && is_cr && !is_crlf) only_cr_ = true;
    return true;
}

std::string_view Words::next() {
    std::size_t begin = 0;
    while (begin < rest_.size() && is_space(rest_[begin])) ++begin;
    std::size_t end = begin;
    while (end < rest_.size() && !is_space(rest_[end])) ++end;
    const std::string_view word = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    return word;
}

std::optional<double> real(std::string_view word) {
    return parsed<double>(word);
}
std::optional<std::int64_t> whole(std::string_view word) {
    return parsed<std::int64_t>(word);
}

std::string printable(std::string_view word) {
    std::string result;
    for (const char c : word.substr(0, SHOWN_MAX_CHARS)) result += c >= ' ' && c <= '~' ? c : '?';
    return result + (word.size() > SHOWN_MAX_CHARS ? "..." : "");
}

std::string in_quotes(std::string_view word) {
    return '`' + printable(word) + '`';
}

}  // namespace palpate::cloud
