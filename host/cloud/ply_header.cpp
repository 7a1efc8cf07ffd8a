#include "host/cloud/ply_header.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace palpate::cloud::ply {
namespace {

constexpr std::size_t LINE_MAX_CHARS = std::size_t{64} * 1024;
constexpr std::size_t LINES_MAX = 10000;

constexpr std::array<std::pair<std::string_view, Type>, 16> TYPES{{{"char", Type::i8},
                                                                   {"int8", Type::i8},
                                                                   {"uchar", Type::u8},
                                                                   {"uint8", Type::u8},
                                                                   {"short", Type::i16},
                                                                   {"int16", Type::i16},
                                                                   {"ushort", Type::u16},
                                                                   {"uint16", Type::u16},
                                                                   {"int", Type::i32},
                                                                   {"int32", Type::i32},
                                                                   {"uint", Type::u32},
                                                                   {"uint32", Type::u32},
                                                                   {"float", Type::f32},
                                                                   {"float32", Type::f32},
                                                                   {"double", Type::f64},
                                                                   {"float64", Type::f64}}};

class HeaderReader {
public:
    HeaderReader(Lines& lines, const std::string& name) : lines_(lines), name_(name) {}

    Header run() {
        std::string_view line;
        if (!lines_.next(line) || Words(line).next() != "ply" || line.size() > LINE_MAX_CHARS)
            here().fail("the first line is not `ply`; a PLY file begins with it");
        while (step()) {
        }
        if (!has_format_)
            here().fail("no line `format`; write `format ascii 1.0` or a binary one after `ply`");
        check_vertex();
        return std::move(header_);
    }

private:
    [[nodiscard]] Place here() const { return Place{&name_, std::max<std::size_t>(lines_.number(), 1)}; }

    /// One line; false after `end_header`.
    bool step() {
        std::string_view line;
        if (!lines_.next(line))
            here().fail("the file ends inside its header; the header ends with `end_header`");
        if (line.size() > LINE_MAX_CHARS) here().fail("a header line over 64 KiB; keep them shorter");
        if (lines_.number() > LINES_MAX) here().fail("a header of over 10000 lines; keep it shorter");
        Words words(line);
        const std::string_view keyword = words.next();
        if (keyword == "end_header") return false;
        if (keyword.empty() || keyword == "comment" || keyword == "obj_info") return true;
        if (keyword == "format")
            format(words);
        else if (keyword == "element")
            element(words);
        else if (keyword == "property")
            property(words);
        else
            here().fail(
                in_quotes(keyword) +
                " is not a header word; use format, comment, obj_info, element, property or end_header");
        if (const std::string_view extra = words.next(); !extra.empty())
            here().fail(in_quotes(extra) + " is one word too many on this line; end the line before it");
        return true;
    }

    void format(Words& words) {
        if (has_format_) here().fail("a second line `format`; keep one");
        const std::string_view encoding = words.next();
        const std::string_view version = words.next();
        if (encoding == "ascii")
            header_.encoding = Encoding::ascii;
        else if (encoding == "binary_little_endian")
            header_.encoding = Encoding::little_endian;
        else if (encoding == "binary_big_endian")
            header_.encoding = Encoding::big_endian;
        else
            here().fail("encoding " + in_quotes(encoding) +
                        "; it must be ascii, binary_little_endian or binary_big_endian");
        if (version != "1.0") here().fail("format version " + in_quotes(version) + "; it must be 1.0");
        has_format_ = true;
    }

    void element(Words& words) {
        const std::string name(words.next());
        const std::string_view count = words.next();
        const std::optional<std::int64_t> n = whole(count);
        if (name.empty()) here().fail("an element without a name; write `element NAME COUNT`");
        if (!n || *n < 0)
            here().fail("element " + in_quotes(name) + " has the count " + in_quotes(count) +
                        "; a count is a whole number from 0");
        for (const Element& earlier : header_.elements) {
            if (earlier.name == name)
                here().fail("element " + in_quotes(name) + " is declared twice, first on line " +
                            std::to_string(earlier.line) + "; declare it once");
        }
        header_.elements.push_back({name, static_cast<std::size_t>(*n), lines_.number(), {}});
    }

    void property(Words& words) {
        if (header_.elements.empty()) here().fail("a property before any element; declare its element first");
        Element& element = header_.elements.back();
        Property property{{}, Type::f32, std::nullopt};
        std::string_view word = words.next();
        if (word == "list") {
            property.count = type(words.next());
            if (!is_integer(*property.count))
                here().fail("the length of a list is not of a whole type; use uchar or int");
            word = words.next();
        }
        property.type = type(word);
        property.name = words.next();
        if (property.name.empty()) here().fail("a property without a name; write `property TYPE NAME`");
        for (const Property& earlier : element.properties) {
            if (earlier.name == property.name)
                here().fail("property " + in_quotes(property.name) + " of element " +
                            in_quotes(element.name) + " is declared twice; declare it once");
        }
        element.properties.push_back(std::move(property));
    }

    [[nodiscard]] Type type(std::string_view word) const {
        for (const auto& [name, type] : TYPES) {
            if (name == word) return type;
        }
        here().fail(
            "type " + in_quotes(word) +
            "; it must be one of char uchar short ushort int uint float double, or of int8 ... float64");
    }

    void check_vertex() const {
        const auto vertex = std::find_if(header_.elements.begin(), header_.elements.end(),
                                         [](const Element& element) { return element.name == "vertex"; });
        if (vertex == header_.elements.end())
            here().fail("no element vertex; points come as `element vertex COUNT`");
        const Place place{&name_, vertex->line};
        for (const std::string_view axis : {"x", "y", "z"}) {
            const auto found =
                std::find_if(vertex->properties.begin(), vertex->properties.end(),
                             [axis](const Property& property) { return property.name == axis; });
            if (found == vertex->properties.end())
                place.fail("element vertex has no property " + in_quotes(axis) + "; it needs x, y and z");
            if (found->count)
                place.fail("property " + in_quotes(axis) +
                           " of element vertex is a list; it must be a number");
        }
    }

    Lines& lines_;
    const std::string& name_;
    Header header_;
    bool has_format_ = false;
};

}  // namespace

std::size_t size_of(Type type) {
    switch (type) {
        case Type::i8:
        case Type::u8:
            return 1;
        case Type::i16:
        case Type::u16:
            return 2;
        case Type::i32:
        case Type::u32:
        case Type::f32:
            return 4;
        case Type::f64:
            return 8;
    }
    return 0;
}

bool is_integer(Type type) {
    return type != Type::f32 && type != Type::f64;
}

Header read_header(Lines& lines, const std::string& name) {
    return HeaderReader(lines, name).run();
}

}  // namespace palpate::cloud::ply
