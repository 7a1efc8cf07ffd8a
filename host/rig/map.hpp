/// The register map: the one table from which the server answers and docs/MODBUS.md is made.
#pragma once
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/tick.h"
#include "host/rig/rig.hpp"

namespace palpate::rig {

enum class Kind { U16, U32, F32 };

/// Words of 16 bits that a register of this kind takes.
constexpr std::uint16_t n_words_of(Kind kind) {
    return kind == Kind::U16 ? 1 : 2;
}

struct Register {
    std::uint16_t address;  ///< of its first word
    Kind kind;
    const char* name;
    const char* unit;
    const char* meaning;
    std::uint32_t (*bits)(const Shown&);  ///< the value; an F32 as its IEEE-754 bits
};

inline constexpr std::uint16_t MAP_VERSION = 1;  ///< grows with every change that an old client would misread

template <std::atomic<std::uint32_t> Shown::*Member>
std::uint32_t count_bits(const Shown& shown) {
    return (shown.*Member).load();
}
template <std::atomic<float> Shown::*Member>
std::uint32_t float_bits(const Shown& shown) {
    return std::bit_cast<std::uint32_t>((shown.*Member).load());
}
inline std::uint32_t version_bits(const Shown& /*shown*/) {
    return MAP_VERSION;
}

inline constexpr std::array REGISTERS{
    Register{0, Kind::U16, "state", "", "what the loop is doing, see States", count_bits<&Shown::state>},
    Register{1, Kind::U16, "map_version", "", "version of this map", version_bits},
    Register{2, Kind::U32, "tick", "ticks", "ticks of 1 ms since the loop's start", count_bits<&Shown::tick>},
    Register{4, Kind::F32, "rate", "Hz", "ticks per second, measured", float_bits<&Shown::rate_hz>},
    Register{6, Kind::F32, "force", "N", "magnitude of the commanded force", float_bits<&Shown::force_n>},
    Register{8, Kind::U32, "faults", "bits", "faults of the latest tick, see Faults",
             count_bits<&Shown::faults>},
    Register{10, Kind::U32, "stop", "bit", "the fault that latched the stop; 0: none",
             count_bits<&Shown::stop>},
    Register{12, Kind::U32, "missed", "periods", "missed since the start", count_bits<&Shown::n_missed>},
    Register{14, Kind::U32, "table_age", "ticks", "since a table was last taken",
             count_bits<&Shown::table_age_ticks>},
    Register{16, Kind::F32, "depth", "m", "of the tool below the undeformed skin; <= 0: no contact",
             float_bits<&Shown::depth_m>},
    Register{18, Kind::F32, "stiffness", "N/m", "under the tool; 0: no contact",
             float_bits<&Shown::k_n_per_m>},
    Register{20, Kind::F32, "x", "m", "tool centre, workspace frame", float_bits<&Shown::x_m>},
    Register{22, Kind::F32, "y", "m", "tool centre, workspace frame, up", float_bits<&Shown::y_m>},
    Register{24, Kind::F32, "z", "m", "tool centre, workspace frame", float_bits<&Shown::z_m>},
};

struct Coil {
    const char* name;
    const char* meaning;
};

enum CoilAddress : std::uint16_t { COIL_ESTOP = 0, COIL_ENABLE = 1 };

inline constexpr std::array COILS{
    Coil{"estop",
         "reads 1 while the emergency stop is latched, whoever asked for it. Writing 1 latches it. Writing "
         "0 releases nothing: it is refused (exception 03) while the stop is latched"},
    Coil{"enable", "forces on; 0 pauses them. Writing 1 does not override a latched stop"},
};

inline constexpr std::uint16_t N_WORDS = REGISTERS.back().address + n_words_of(REGISTERS.back().kind);
inline constexpr std::uint16_t N_COILS = COILS.size();

/// Whether the registers follow one another from address 0 without a gap.
constexpr bool contiguous(std::span<const Register> registers) {
    std::uint16_t next = 0;
    for (const Register& r : registers) {
        if (r.address != next) return false;
        next = static_cast<std::uint16_t>(next + n_words_of(r.kind));
    }
    return true;
}
static_assert(contiguous(REGISTERS));
static_assert(N_WORDS >= 16 && N_WORDS <= 125, "one request reads the whole map");
static_assert(N_COILS == COIL_ENABLE + 1);

/// What the registers hold now: N_WORDS words, the high word of a pair first.
[[nodiscard]] std::array<std::uint16_t, N_WORDS> words(const Shown& shown);

}  // namespace palpate::rig
