/// Modbus TCP as bytes: where a frame ends, and whether its request can be answered. Pure; knows no socket.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace palpate::rig {

inline constexpr std::size_t FRAME_MAX_BYTES = 260;

enum class Function : std::uint8_t { ReadCoils = 1, ReadInputRegisters = 4, WriteCoil = 5, WriteCoils = 15 };

/// The values are the exception codes of the protocol.
enum class Verdict : std::uint8_t { Answer = 0, IllegalFunction = 1, IllegalValue = 3 };

struct Sizes {
    unsigned n_words;  ///< input registers from address 0
    unsigned n_coils;  ///< coils from address 0; at most 8
};

/// Length of the frame at the start of `bytes`; 0 when more bytes are needed; nullopt when this is not Modbus
/// TCP.
[[nodiscard]] std::optional<std::size_t> frame_bytes(std::span<const std::uint8_t> bytes);

/// Whether a map of these sizes can answer `frame`, a whole frame as told by frame_bytes().
[[nodiscard]] Verdict verdict_on(std::span<const std::uint8_t> frame, Sizes sizes);

/// Coils that a request sets: bit i of `mask` when coil i is written, its value in bit i of `values`.
struct CoilWrite {
    std::uint8_t mask = 0;
    std::uint8_t values = 0;
};

/// The coils that `frame` writes, none for a read. Only for frames with Verdict::Answer.
[[nodiscard]] CoilWrite coil_write(std::span<const std::uint8_t> frame);

}  // namespace palpate::rig
