// The NPY format, as numpy.lib.format describes it.
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <utility>

#include "host/cloud/text.hpp"
#include "host/scene/array_file.hpp"
#include "host/scene/scene.hpp"

namespace palpate::scene {
namespace {

using Eigen::Index;

constexpr std::string_view MAGIC = "\x93NUMPY";
constexpr std::size_t HEADER_ALIGN = 64;  // of all that stands before the numbers

struct Header {
    std::string type;  ///< "<f8"
    bool fortran_order = false;
    std::array<std::uint64_t, 2> shape{};
};

/// Little-endian number of `n_bytes` bytes at `offset`.
std::uint64_t little(std::string_view bytes, std::size_t offset, std::size_t n_bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = n_bytes; i > 0; --i)
        value = value << 8U | static_cast<unsigned char>(bytes[offset + i - 1]);
    return value;
}

/// The header, which is a Python dictionary: {'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }
class HeaderText {
public:
    HeaderText(std::string_view text, const std::string& name) : rest_(text), name_(name) {}

    Header read() {
        Header header;
        bool has_type = false, has_order = false, has_shape = false;
        take('{');
        while (!next_is('}')) {
            const std::string key = string();
            take(':');
            const auto is_first = [&](const char* name, bool& has) {
                if (key != name || has) return false;
                has = true;
                return true;
            };
            if (is_first("descr", has_type)) {
                header.type = type();
            } else if (is_first("fortran_order", has_order)) {
                header.fortran_order = boolean();
            } else if (is_first("shape", has_shape)) {
                header.shape = shape();
            } else {
                fail("has a key " + cloud::in_quotes(key) + " too many");
            }
            if (!next_is('}')) take(',');
        }
        take('}');
        if (!skip_space().empty()) fail("goes on behind its end");
        if (!has_type || !has_order || !has_shape) fail("lacks descr, fortran_order or shape");
        return header;
    }

private:
    [[noreturn]] void fail(const std::string& words) const {
        refuse(name_, "the header " + words + "; a .npy file as numpy.save writes it is expected");
    }
    std::string_view skip_space() {
        rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\n"), rest_.size()));
        return rest_;
    }
    bool next_is(char c) { return skip_space().starts_with(c); }
    void take(char c) {
        if (!next_is(c)) fail(std::string("has no ") + c + " where one belongs");
        rest_.remove_prefix(1);
    }
    std::string string() {
        const char quote = next_is('"') ? '"' : '\'';
        take(quote);
        const std::size_t end = rest_.find(quote);
        if (end == std::string_view::npos) fail("has a string without an end");
        std::string text(rest_.substr(0, end));
        rest_.remove_prefix(end + 1);
        return text;
    }
    std::string type() {
        if (next_is('['))
            refuse(name_, "is an array of records; numbers <f8, <f4, <i8, <i4 or big-endian are expected");
        return string();
    }
    bool boolean() {
        for (const std::string_view word : {"True", "False"}) {
            if (!skip_space().starts_with(word)) continue;
            rest_.remove_prefix(word.size());
            return word == "True";
        }
        fail("has neither True nor False as fortran_order");
    }
    std::uint64_t number() {
        skip_space();
        std::uint64_t value = 0;
        const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
        if (error != std::errc{}) fail("has a shape that is not made of whole numbers");
        rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
        return value;
    }
    std::array<std::uint64_t, 2> shape() {
        std::array<std::uint64_t, 2> shape{};
        std::size_t n = 0;
        take('(');
        while (!next_is(')')) {
            const std::uint64_t side = number();
            if (n < shape.size()) shape[n] = side;
            ++n;
            if (!next_is(')')) take(',');
        }
        take(')');
        if (n != shape.size())
            refuse(name_, "has " + std::to_string(n) + (n == 1 ? " dimension" : " dimensions") +
                              "; two are expected");
        return shape;
    }

    std::string_view rest_;
    const std::string& name_;
};

/// One number of a type, whichever way its bytes lie.
template <class T>
double number_at(const char* bytes, bool swap) {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), bytes, raw.size());
    if (swap) std::reverse(raw.begin(), raw.end());
    return static_cast<double>(std::bit_cast<T>(raw));
}

struct Type {
    std::string_view name;  ///< without the order of bytes
    std::size_t n_bytes;
    double (*at)(const char* bytes, bool swap);
};
constexpr Type TYPES[] = {{"f4", 4, number_at<float>},
                          {"f8", 8, number_at<double>},
                          {"i4", 4, number_at<std::int32_t>},
                          {"i8", 8, number_at<std::int64_t>}};

const Type& type_of(const Header& header, const std::string& name) {
    const std::string_view text = header.type;
    for (const Type& type : TYPES) {
        if (text.size() == 3 && (text[0] == '<' || text[0] == '>') && text.substr(1) == type.name)
            return type;
    }
    refuse(name, "holds numbers of type " + cloud::in_quotes(text) +
                     "; <f8, <f4, <i8, <i4 or big-endian are expected, such as D.astype(float)");
}

/// Where the header's text begins and ends.
std::pair<std::size_t, std::size_t> header_place(std::string_view bytes, const std::string& name) {
    constexpr std::size_t VERSION_AT = MAGIC.size(), SIZE_AT = MAGIC.size() + 2;
    const auto truncated = [&] { refuse(name, "ends within its header; a whole .npy file is expected"); };
    if (!bytes.starts_with(MAGIC)) refuse(name, "does not begin as a .npy file; one is expected");
    if (bytes.size() < SIZE_AT) truncated();
    const auto major = static_cast<unsigned char>(bytes[VERSION_AT]);
    const auto minor = static_cast<unsigned char>(bytes[VERSION_AT + 1]);
    if ((major != 1 && major != 2) || minor != 0)
        refuse(name,
               "is NPY " + std::to_string(major) + "." + std::to_string(minor) + "; 1.0 or 2.0 is expected");
    const std::size_t size_bytes = major == 1 ? 2 : 4, begin = SIZE_AT + size_bytes;
    if (bytes.size() < begin) truncated();
    const std::uint64_t size = little(bytes, SIZE_AT, size_bytes);
    if (size > bytes.size() - begin) truncated();
    return {begin, begin + size};
}

}  // namespace

Eigen::ArrayXXd parse_npy(std::string_view bytes, const std::string& name) {
    const auto [begin, end] = header_place(bytes, name);
    const Header header = HeaderText(bytes.substr(begin, end - begin), name).read();
    const Type& type = type_of(header, name);
    for (const std::uint64_t side : header.shape) {
        if (side < 1 || side > ARRAY_SIDE_MAX)
            refuse(name, "is " + std::to_string(header.shape[0]) + " x " + std::to_string(header.shape[1]) +
                             "; 1 to " + std::to_string(ARRAY_SIDE_MAX) + " each way are expected");
    }
    const std::string_view body = bytes.substr(end);
    const std::size_t n_bytes = header.shape[0] * header.shape[1] * type.n_bytes;
    if (body.size() != n_bytes)
        refuse(name, "has " + std::to_string(body.size()) + " bytes of numbers; " + std::to_string(n_bytes) +
                         " are expected (" + (body.size() < n_bytes ? "truncated" : "something follows") +
                         ")");
    const bool swap = (header.type[0] == '<') != (std::endian::native == std::endian::little);
    Eigen::ArrayXXd values(static_cast<Index>(header.shape[0]), static_cast<Index>(header.shape[1]));
    for (Index j = 0; j < values.cols(); ++j) {
        for (Index i = 0; i < values.rows(); ++i) {
            const Index at = header.fortran_order ? i + values.rows() * j : j + values.cols() * i;
            values(i, j) = type.at(body.data() + static_cast<std::size_t>(at) * type.n_bytes, swap);
        }
    }
    return values;
}

std::string npy_bytes(const Eigen::Ref<const Eigen::ArrayXXd>& values) {
    static_assert(std::endian::native == std::endian::little);
    std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (" +
                         std::to_string(values.rows()) + ", " + std::to_string(values.cols()) + "), }";
    const std::size_t before = MAGIC.size() + 4;
    while ((before + header.size() + 1) % HEADER_ALIGN != 0) header += ' ';
    header += '\n';
    std::string out(MAGIC);
    out += {'\1', '\0', static_cast<char>(header.size() & 0xFFU), static_cast<char>(header.size() >> 8U)};
    out += header;
    for (Index i = 0; i < values.rows(); ++i) {
        for (Index j = 0; j < values.cols(); ++j) {
            const auto raw = std::bit_cast<std::array<char, sizeof(double)>>(values(i, j));
            out.append(raw.data(), raw.size());
        }
    }
    return out;
}

}  // namespace palpate::scene
