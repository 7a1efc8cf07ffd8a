/// What the text at the head of a PLY file says about the rest.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/cloud/text.hpp"

namespace palpate::cloud::ply {

enum class Encoding { ascii, little_endian, big_endian };
enum class Type { i8, u8, i16, u16, i32, u32, f32, f64 };

[[nodiscard]] std::size_t size_of(Type type);  ///< bytes
[[nodiscard]] bool is_integer(Type type);

struct Property {
    std::string name;
    Type type;                  ///< of the value, or of each entry of a list
    std::optional<Type> count;  ///< of a list's length; nullopt for a plain value
};

struct Element {
    std::string name;
    std::size_t n = 0;
    std::size_t line = 0;  ///< that declares it
    std::vector<Property> properties;
};

struct Header {
    Encoding encoding = Encoding::ascii;
    std::vector<Element> elements;
};

/// Reads up to and with `end_header`. Throws Error; `vertex` with plain x, y, z is there once when it
/// returns.
[[nodiscard]] Header read_header(Lines& lines, const std::string& name);

}  // namespace palpate::cloud::ply
