// For text formats: every second mutation changes one number, or takes out, doubles or swaps a line, so that
// most of a valid input stays valid. Left to itself libFuzzer breaks the syntax nearly always, and what lies
// behind the syntax, indices and ranges, is hardly ever tried.
#include <cctype>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/input.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

using Random = std::minstd_rand;

std::size_t below(Random& random, std::size_t n) {
    return random() % n;
}

bool is_digit(char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// A neighbour of `digits`, or a value at which something overflows.
std::string other_number(Random& random, const std::string& digits) {
    constexpr std::array EDGES{"0",          "1",          "-1",
                               "0.5",        "255",        "65536",
                               "4294967295", "4294967296", "9223372036854775807",
                               "1e-9",       "1e12",       "1e31",
                               "1e309",      "nan",        "18446744073709551615"};
    const std::size_t which = below(random, 4);
    if (which == 0 || digits.size() > 9) return EDGES[below(random, EDGES.size())];
    const long value = std::stol(digits);
    return std::to_string(which == 1 ? value + 1 : which == 2 ? value - 1 : -value);
}

bool change_number(Random& random, std::string& text) {
    std::vector<std::size_t> begins;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (is_digit(text[i]) && (i == 0 || !is_digit(text[i - 1]))) begins.push_back(i);
    }
    if (begins.empty()) return false;
    const std::size_t begin = begins[below(random, begins.size())];
    std::size_t end = begin;
    while (end < text.size() && is_digit(text[end])) ++end;
    text.replace(begin, end - begin, other_number(random, text.substr(begin, end - begin)));
    return true;
}

bool change_lines(Random& random, std::string& text) {
    std::vector<std::string> lines;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
        lines.push_back(text.substr(begin, end - begin));
        begin = end;
    }
    if (lines.size() < 2) return false;
    const auto at = static_cast<std::ptrdiff_t>(below(random, lines.size()));
    const std::string line = lines[static_cast<std::size_t>(at)];
    const std::size_t which = below(random, 3);
    if (which != 1) lines.erase(lines.begin() + at);
    if (which != 0) {
        lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(below(random, lines.size() + 1)), line);
    }
    text.clear();
    for (const std::string& each : lines) text += each;
    return true;
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
    Random random(seed + 1U);
    const std::size_t which = below(random, 8);
    std::string text(fuzz::text_of({data, size}));
    const bool changed = which < 3 ? change_number(random, text) : which == 3 && change_lines(random, text);
    if (!changed || text.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
    std::copy(text.begin(), text.end(), data);
    return text.size();
}
