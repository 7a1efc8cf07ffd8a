#include "host/rig/frame.hpp"

namespace palpate::rig {
namespace {

// Offsets in a frame: transaction (2 bytes), protocol (2), length (2), unit (1), function (1), data.
constexpr std::size_t AT_PROTOCOL = 2;
constexpr std::size_t AT_LENGTH = 4;
constexpr std::size_t AT_UNIT = 6;
constexpr std::size_t AT_FUNCTION = 7;
constexpr std::size_t AT_ADDRESS = 8;
constexpr std::size_t AT_QUANTITY = 10;  // or the value of a single write
constexpr std::size_t AT_N_BYTES = 12;
constexpr std::size_t AT_BITS = 13;
constexpr unsigned LENGTH_MIN = 2;    // unit and function
constexpr unsigned LENGTH_MAX = 254;  // unit and a PDU of 253 bytes
static_assert(AT_UNIT + LENGTH_MAX == FRAME_MAX_BYTES);
constexpr unsigned COIL_ON = 0xFF00;
constexpr unsigned COIL_OFF = 0x0000;

unsigned word_at(std::span<const std::uint8_t> bytes, std::size_t at) {
    return static_cast<unsigned>(bytes[at]) << 8U | bytes[at + 1];
}

bool inside(std::span<const std::uint8_t> frame, unsigned n_there) {
    const unsigned address = word_at(frame, AT_ADDRESS);
    const unsigned quantity = word_at(frame, AT_QUANTITY);
    return quantity > 0 && address + quantity <= n_there;
}

bool write_coils_is_whole(std::span<const std::uint8_t> frame) {
    if (frame.size() <= AT_BITS) return false;
    const std::size_t n_bytes = (word_at(frame, AT_QUANTITY) + 7U) / 8U;
    return frame[AT_N_BYTES] == n_bytes && frame.size() == AT_BITS + n_bytes;
}

bool in_range(std::span<const std::uint8_t> frame, Sizes sizes) {
    const bool two_words = frame.size() == AT_N_BYTES;
    switch (static_cast<Function>(frame[AT_FUNCTION])) {
        case Function::ReadCoils:
            return two_words && inside(frame, sizes.n_coils);
        case Function::ReadInputRegisters:
            return two_words && inside(frame, sizes.n_words);
        case Function::WriteCoil: {
            if (!two_words) return false;
            const unsigned value = word_at(frame, AT_QUANTITY);
            return word_at(frame, AT_ADDRESS) < sizes.n_coils && (value == COIL_ON || value == COIL_OFF);
        }
        case Function::WriteCoils:
            return write_coils_is_whole(frame) && inside(frame, sizes.n_coils);
    }
    return false;
}

bool known(std::uint8_t function) {
    switch (static_cast<Function>(function)) {
        case Function::ReadCoils:
        case Function::ReadInputRegisters:
        case Function::WriteCoil:
        case Function::WriteCoils:
            return true;
    }
    return false;
}

}  // namespace

std::optional<std::size_t> frame_bytes(std::span<const std::uint8_t> bytes) {
    if (bytes.size() >= AT_LENGTH && word_at(bytes, AT_PROTOCOL) != 0) return std::nullopt;
    if (bytes.size() < AT_UNIT) return 0;
    const unsigned length = word_at(bytes, AT_LENGTH);
    if (length < LENGTH_MIN || length > LENGTH_MAX) return std::nullopt;
    if (bytes.size() > AT_FUNCTION && (bytes[AT_FUNCTION] == 0 || bytes[AT_FUNCTION] > 127))
        return std::nullopt;
    return bytes.size() < AT_UNIT + length ? 0 : AT_UNIT + length;
}

Verdict verdict_on(std::span<const std::uint8_t> frame, Sizes sizes) {
    if (!known(frame[AT_FUNCTION])) return Verdict::IllegalFunction;
    return in_range(frame, sizes) ? Verdict::Answer : Verdict::IllegalValue;
}

CoilWrite coil_write(std::span<const std::uint8_t> frame) {
    const auto function = static_cast<Function>(frame[AT_FUNCTION]);
    const unsigned first = word_at(frame, AT_ADDRESS);
    const unsigned word = word_at(frame, AT_QUANTITY);
    unsigned mask = 0;
    unsigned values = 0;
    if (function == Function::WriteCoil) {
        mask = 1U;
        values = word == COIL_ON ? 1U : 0U;
    } else if (function == Function::WriteCoils) {
        mask = (1U << word) - 1U;
        values = frame[AT_BITS] & mask;
    }
    return {static_cast<std::uint8_t>(mask << first), static_cast<std::uint8_t>(values << first)};
}

}  // namespace palpate::rig
