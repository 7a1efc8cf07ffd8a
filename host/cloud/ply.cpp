#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "host/cloud/builder.hpp"
#include "host/cloud/formats.hpp"
#include "host/cloud/ply_header.hpp"

namespace palpate::cloud {
namespace {

using ply::Element;
using ply::Encoding;
using ply::Header;
using ply::Property;
using ply::Type;

/// The body as text: one line per entry of an element.
class AsciiBody {
public:
    AsciiBody(const Lines& lines, const std::string& name) : lines_(lines), name_(name) {}

    /// How many entries of `element` the bytes left can hold: a digit and a space or line end for each
    /// property.
    [[nodiscard]] std::size_t n_fit(const Element& element) const {
        return (lines_.n_left() + 1) / (2 * element.properties.size());
    }
    void begin_element(const Element& element) { element_ = &element; }
    void begin_entry(std::size_t i) {
        std::string_view line;
        std::string_view word;
        while (word.empty()) {
            if (!lines_.next(line))
                here().fail("the file ends after " + std::to_string(i) + " of " +
                            std::to_string(element_->n) + " entries of element " + printable(element_->name) +
                            "; it is truncated or the count is wrong");
            word = Words(line).next();
        }
        words_ = Words(line);
    }
    void end_entry() {
        if (const std::string_view extra = words_.next(); !extra.empty())
            here().fail(in_quotes(extra) + " is more than element " + printable(element_->name) +
                        " declares; one entry per line");
    }
    [[nodiscard]] double value(const Property& property) { return number(property, real, "a number"); }
    [[nodiscard]] std::int64_t index(const Property& property) {
        return number(property, whole, "a whole number");
    }
    [[nodiscard]] std::int64_t count(const Property& property) {
        return number(property, whole, "a whole number");
    }
    [[nodiscard]] bool can_hold(std::int64_t n, const Property&) const {
        return n <= static_cast<std::int64_t>(lines_.offset());  // the line has been taken
    }
    [[nodiscard]] Place here() const { return Place{&name_, lines_.number()}; }
    void end() {
        std::string_view line;
        while (lines_.next(line)) {
            if (const std::string_view word = Words(line).next(); !word.empty())
                here().fail(in_quotes(word) +
                            " after the last declared entry; the header's counts must cover the file");
        }
    }

private:
    template <class Number>
    Number number(const Property& property, std::optional<Number> (*parse)(std::string_view),
                  const char* kind) {
        const std::string_view word = words_.next();
        if (word.empty())
            here().fail("the line ends before " + printable(property.name) + " of element " +
                        printable(element_->name) + "; it is truncated or a value is missing");
        const std::optional<Number> number = parse(word);
        if (!number)
            here().fail(printable(property.name) + " is " + in_quotes(word) + "; it must be " + kind +
                        ", decimals with a point");
        return *number;
    }

    Lines lines_;
    const std::string& name_;
    const Element* element_ = nullptr;
    Words words_{{}};
};

/// The body as packed values.
class BinaryBody {
public:
    BinaryBody(std::string_view bytes, Encoding encoding, const std::string& name)
        : bytes_(bytes),
          swap_((encoding == Encoding::big_endian) != (std::endian::native == std::endian::big)),
          name_(name) {}

    [[nodiscard]] std::size_t n_fit(const Element& element) const {
        std::size_t stride = 0;
        for (const Property& property : element.properties)
            stride += size_of(property.count ? *property.count : property.type);
        return (bytes_.size() - offset_) / stride;
    }
    void begin_element(const Element& element) {
        element_ = &element;
        start_ = offset_;
    }
    void begin_entry(std::size_t i) { entry_ = i; }
    void end_entry() {}
    [[nodiscard]] double value(const Property& property) { return decoded<double>(property.type); }
    [[nodiscard]] std::int64_t index(const Property& property) {
        return decoded<std::int64_t>(property.type);
    }
    [[nodiscard]] std::int64_t count(const Property& property) {
        return decoded<std::int64_t>(*property.count);
    }
    [[nodiscard]] bool can_hold(std::int64_t n, const Property& property) const {
        return static_cast<std::size_t>(n) <= (bytes_.size() - offset_) / size_of(property.type);
    }
    [[nodiscard]] Place here() const {
        return Place{&name_, element_->line, element_->name, offset_ - start_};
    }
    void end() const {
        const std::string_view rest = bytes_.substr(offset_);
        if (rest.find_first_not_of(" \t\r\n") != std::string_view::npos)
            here().fail(std::to_string(rest.size()) +
                        " bytes after the last declared entry; the header's counts must cover the file");
    }

private:
    template <class As>
    As decoded(Type type) {
        switch (type) {
            case Type::i8:
                return static_cast<As>(raw<std::int8_t>());
            case Type::u8:
                return static_cast<As>(raw<std::uint8_t>());
            case Type::i16:
                return static_cast<As>(raw<std::int16_t>());
            case Type::u16:
                return static_cast<As>(raw<std::uint16_t>());
            case Type::i32:
                return static_cast<As>(raw<std::int32_t>());
            case Type::u32:
                return static_cast<As>(raw<std::uint32_t>());
            case Type::f32:
                return static_cast<As>(raw<float>());
            case Type::f64:
                return static_cast<As>(raw<double>());
        }
        return As{};
    }

    template <class Raw>
    Raw raw() {
        std::array<char, sizeof(Raw)> packed{};
        if (bytes_.size() - offset_ < packed.size())
            here().fail("the file ends in entry " + std::to_string(entry_ + 1) + " of " +
                        std::to_string(element_->n) + "; it is truncated or the count is wrong");
        std::memcpy(packed.data(), bytes_.data() + offset_, packed.size());
        if (swap_) std::reverse(packed.begin(), packed.end());
        offset_ += packed.size();
        return std::bit_cast<Raw>(packed);
    }

    std::string_view bytes_;
    bool swap_;
    const std::string& name_;
    const Element* element_ = nullptr;
    std::size_t offset_ = 0;
    std::size_t start_ = 0;  ///< offset of the element
    std::size_t entry_ = 0;
};

std::size_t n_vertices(const Header& header) {
    std::size_t n = 0;
    for (const Element& element : header.elements) n += element.name == "vertex" ? element.n : 0;
    return n;
}

/// What is to be done with one property of an element.
enum class Use { skip, x, y, z, corners };

Use use_of(const Element& element, const Property& property) {
    if (element.name == "vertex" && !property.count) {
        if (property.name == "x") return Use::x;
        if (property.name == "y") return Use::y;
        if (property.name == "z") return Use::z;
    }
    const bool is_corners = property.name == "vertex_indices" || property.name == "vertex_index";
    return element.name == "face" && is_corners && property.count ? Use::corners : Use::skip;
}

template <class Body>
class BodyReader {
public:
    BodyReader(Body body, const Header& header, const std::string& name)
        : body_(std::move(body)), header_(header), name_(name), n_vertices_(n_vertices(header)) {}

    Cloud run() {
        for (const Element& element : header_.elements) read(element);
        body_.end();
        const auto vertex = std::find_if(header_.elements.begin(), header_.elements.end(),
                                         [](const Element& element) { return element.name == "vertex"; });
        return builder_.finish(Place{&name_, vertex->line});
    }

private:
    void read(const Element& element) {
        body_.begin_element(element);
        if (element.n == 0) return;
        const Place declared{&name_, element.line};
        if (element.properties.empty())
            declared.fail("element " + printable(element.name) +
                          " has entries but no properties; declare them or drop it");
        if (const std::size_t n_fit = body_.n_fit(element); element.n > n_fit)
            declared.fail("element " + printable(element.name) + " declares " + std::to_string(element.n) +
                          " entries, but the file has room for " + std::to_string(n_fit) +
                          "; it is truncated or the count is wrong");
        std::vector<Use> uses;
        for (const Property& property : element.properties) {
            uses.push_back(use_of(element, property));
            if (uses.back() == Use::corners && !ply::is_integer(property.type))
                declared.fail("the corners of element face are not whole numbers; use int or uint");
        }
        if (element.name == "vertex") builder_.reserve_points(element.n);
        for (std::size_t i = 0; i < element.n; ++i) {
            body_.begin_entry(i);
            entry(element, uses);
            body_.end_entry();
        }
    }

    void entry(const Element& element, const std::vector<Use>& uses) {
        std::array<double, 3> xyz{};
        for (std::size_t i = 0; i < uses.size(); ++i) {
            const Property& property = element.properties[i];
            if (property.count) {
                list(property, uses[i]);
                continue;
            }
            const double value = body_.value(property);
            if (uses[i] != Use::skip)
                xyz[static_cast<std::size_t>(uses[i]) - static_cast<std::size_t>(Use::x)] = value;
        }
        if (element.name == "vertex") builder_.add_point(xyz, body_.here());
    }

    void list(const Property& property, Use use) {
        const std::int64_t n = body_.count(property);
        if (n < 0 || !body_.can_hold(n, property))
            body_.here().fail("a list " + printable(property.name) + " of length " + std::to_string(n) +
                              "; it must be from 0 to what the file still holds, or the file is truncated");
        if (use == Use::corners) {
            corners_.clear();
            for (std::int64_t i = 0; i < n; ++i) corners_.push_back(corner(property));
            builder_.add_polygon(corners_, body_.here());
        } else {
            for (std::int64_t i = 0; i < n; ++i) static_cast<void>(body_.value(property));
        }
    }

    Index corner(const Property& property) {
        const std::int64_t vertex = body_.index(property);
        if (vertex < 0 || static_cast<std::size_t>(vertex) >= n_vertices_)
            body_.here().fail("vertex " + std::to_string(vertex) + " in a face, but there are " +
                              std::to_string(n_vertices_) + " vertices; they count from 0");
        return static_cast<Index>(vertex);
    }

    Body body_;
    const Header& header_;
    const std::string& name_;
    std::size_t n_vertices_;
    Builder builder_;
    std::vector<Index> corners_;
};

}  // namespace

Cloud read_ply(std::string_view bytes, const std::string& name) {
    if (bytes.empty()) Place{&name}.fail("the file is empty; a PLY file begins with a line `ply`");
    Lines lines(bytes);
    const Header header = ply::read_header(lines, name);
    if (header.encoding == Encoding::ascii)
        return BodyReader<AsciiBody>(AsciiBody(lines, name), header, name).run();
    return BodyReader<BinaryBody>(BinaryBody(bytes.substr(lines.offset()), header.encoding, name), header,
                                  name)
        .run();
}

}  // namespace palpate::cloud
