#include "host/rig/map.hpp"

#include <sstream>

namespace palpate::rig {
namespace {

struct Named {
    std::uint32_t value;
    const char* meaning;
};

constexpr std::array STATES{
    Named{PAL_STATE_DISABLED, "disabled"},
    Named{PAL_STATE_HOMING, "homing: waiting for the device to find its origin; no force"},
    Named{PAL_STATE_RAMP, "ramp: the force grows from zero after homing or after a stop"},
    Named{PAL_STATE_ENABLED, "enabled"},
    Named{PAL_STATE_PAUSED, "paused: an operator switched the forces off"},
    Named{PAL_STATE_FAULT, "fault: latched, see `stop`"},
};

constexpr std::array FAULTS{
    Named{PAL_FAULT_NOT_FINITE, "a sensed value was not finite"},
    Named{PAL_FAULT_WORKSPACE, "outside the workspace"},
    Named{PAL_FAULT_TABLE_MISSING, "no table has come yet"},
    Named{PAL_FAULT_TABLE_LEFT, "the tool left the table's valid radius"},
    Named{PAL_FAULT_TABLE_STALE, "the table is stale: frozen and damped"},
    Named{PAL_FAULT_TABLE_DROPPED, "the table is too old: force to zero"},
    Named{PAL_FAULT_TABLE_BAD, "a table was refused by its check"},
    Named{PAL_FAULT_FORCE_CLAMP, "the force was cut to its limit"},
    Named{PAL_FAULT_MOTOR_CLAMP, "the motor words were scaled down together"},
    Named{PAL_FAULT_LATE, "no fresh sample: the last force held or faded"},
    Named{PAL_FAULT_DEVICE_LOST, "the device is lost: zero force, latched"},
    Named{PAL_FAULT_ESTOP, "emergency stop, latched"},
    Named{PAL_FAULT_HOST_LOST, "the host process is gone"},
};

constexpr const char* HEAD = R"(# Modbus map

Made from the table in `host/rig/map.hpp`; a test compares the two. `palpate run SCENE --rig 127.0.0.1:1502` serves it
over Modbus TCP.

- Loopback addresses only (127.0.0.0/8, `localhost`): Modbus has no password.
- Any unit id is answered, with the same map, and comes back in the answer.
- Addresses count from 0, as on the wire. `mbpoll` does so with `-0`.
- A `u32` or `f32` takes two words, the high word first; an `f32` is IEEE-754 binary32. Read both words in one request:
  each value is whole within one answer, two values may be of neighbouring ticks.
)";

constexpr const char* RULES = R"(
## Functions

| code | function |
|---|---|
| 01 | read coils |
| 04 | read input registers |
| 05 | write single coil |
| 15 | write multiple coils |

A write is carried out whole or not at all, and before its answer is sent.

## Exceptions

| code | when |
|---|---|
| 01 | any other function |
| 03 | a request that reaches outside the map, a quantity that is zero or too large, a value that is not allowed, a frame whose length does not fit its function |

Modbus has code 02 for addresses outside the map; this server says 03 for everything that is out of range.

## Connections

16 clients at once; one more takes the place of the one that has been silent longest. The connection is closed on bytes
that are not Modbus TCP (protocol id not 0, length not 2 to 254, function 0 or above 127), on a frame that is not
complete one second after its first byte, and on a client that does not take its answers. None of this delays the other
clients or the loop.

## Worked examples

The force is 3.25 N (0x40500000):

    request 00 01 00 00 00 06 01 04 00 06 00 02
    answer  00 01 00 00 00 07 01 04 04 40 50 00 00

Emergency stop, then an attempt to release it:

    request 00 02 00 00 00 06 01 05 00 00 FF 00
    answer  00 02 00 00 00 06 01 05 00 00 FF 00
    request 00 03 00 00 00 06 01 05 00 00 00 00
    answer  00 03 00 00 00 03 01 85 03

The same by hand:

    mbpoll -0 -1 -t 3:float -B -r 6 -p 1502 127.0.0.1
    mbpoll -0 -1 -t 0 -r 0 -p 1502 127.0.0.1 1
)";

const char* kind_name(Kind kind) {
    switch (kind) {
        case Kind::U16:
            return "u16";
        case Kind::U32:
            return "u32";
        case Kind::F32:
            return "f32";
    }
    return "";
}

void write_registers(std::ostream& out) {
    out << "\n## Input registers (function 04)\n\n| address | name | type | unit | meaning "
           "|\n|---|---|---|---|---|\n";
    for (const Register& r : REGISTERS) {
        out << "| " << r.address;
        if (n_words_of(r.kind) > 1) out << "-" << r.address + n_words_of(r.kind) - 1;
        out << " | " << r.name << " | " << kind_name(r.kind) << " | " << (*r.unit != '\0' ? r.unit : "-")
            << " | " << r.meaning << " |\n";
    }
}

void write_coils(std::ostream& out) {
    out << "\n## Coils (functions 01, 05, 15)\n\n| address | name | meaning |\n|---|---|---|\n";
    for (std::size_t i = 0; i < COILS.size(); ++i) {
        out << "| " << i << " | " << COILS[i].name << " | " << COILS[i].meaning << " |\n";
    }
}

void write_named(std::ostream& out, const char* title, const char* column, std::span<const Named> all) {
    out << "\n## " << title << "\n\n| " << column << " | meaning |\n|---|---|\n";
    for (const Named& n : all) out << "| " << n.value << " | " << n.meaning << " |\n";
}

}  // namespace

std::array<std::uint16_t, N_WORDS> words(const Shown& shown) {
    std::array<std::uint16_t, N_WORDS> out{};
    for (const Register& r : REGISTERS) {
        const std::uint32_t bits = r.bits(shown);
        std::size_t at = r.address;
        if (n_words_of(r.kind) > 1) out[at++] = static_cast<std::uint16_t>(bits >> 16);
        out[at] = static_cast<std::uint16_t>(bits & 0xFFFFU);
    }
    return out;
}

std::string modbus_markdown() {
    std::ostringstream out;
    out << HEAD;
    write_registers(out);
    write_coils(out);
    write_named(out, "States", "state", STATES);
    write_named(out, "Faults", "bit", FAULTS);
    out << RULES;
    return out.str();
}

}  // namespace palpate::rig
