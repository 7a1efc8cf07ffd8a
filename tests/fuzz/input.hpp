/// What every fuzz target needs: a claim that must hold, an input taken apart in order, and a count of the
/// inputs that got through to what is worth testing.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string_view>

namespace fuzz {

inline void require(bool holds) {
    if (!holds) std::abort();
}

using Bytes = std::span<const std::uint8_t>;

/// The next value of `bytes`, zeros where they end.
template <class T>
T take(Bytes& bytes) {
    std::array<std::uint8_t, sizeof(T)> raw{};
    const std::size_t n = std::min(bytes.size(), raw.size());
    std::copy_n(bytes.begin(), n, raw.begin());
    bytes = bytes.subspan(n);
    T value;
    std::memcpy(&value, raw.data(), sizeof value);
    return value;
}

inline std::string_view text_of(Bytes bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A place behind the checks. What it counted is printed at the end, and run.sh refuses a target with a place
/// where nothing ever came: it would fuzz a magic number or a CRC and no more.
class Reached {
public:
    explicit Reached(const char* place) : place_(place) {}
    void note() { ++n_inputs_; }
    Reached(const Reached&) = delete;
    Reached& operator=(const Reached&) = delete;
    ~Reached() { std::fprintf(stderr, "reached %llu %s\n", n_inputs_, place_); }

private:
    const char* place_;
    unsigned long long n_inputs_ = 0;
};

}  // namespace fuzz
