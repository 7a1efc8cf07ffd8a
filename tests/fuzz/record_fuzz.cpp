// A record file of arbitrary bytes: a record or Error, and nothing else. Bits of the first byte mend what
// chance never hits: length and hashes (1), the number of ticks and where the tables begin (2).
#include <xxhash.h>

#include <string>

#include "host/record/csv.hpp"
#include "host/record/record.hpp"
#include "tests/fuzz/input.hpp"

namespace {

using namespace palpate;

fuzz::Reached parsed("record parsed"), with_tables("with a table"), with_ticks("with ticks");

constexpr std::size_t HEAD_BYTES = record::TICKS_OFFSET;
enum : unsigned { MEND_HASHES = 1, MEND_PLACES = 2 };

void put(std::string& bytes, std::size_t offset, std::uint64_t value) {
    std::memcpy(bytes.data() + offset, &value, sizeof value);
}

/// No more ticks than there is room for, and the tables right behind them (docs/PROTOCOL.md 5).
void mend_places(std::string& bytes) {
    std::uint64_t n_ticks = 0;
    std::memcpy(&n_ticks, bytes.data() + 24, sizeof n_ticks);
    n_ticks %= (bytes.size() - HEAD_BYTES) / sizeof(pal_tick) + 1;
    put(bytes, 24, n_ticks);
    put(bytes, 40, HEAD_BYTES + n_ticks * sizeof(pal_tick));
}

/// Magic, version, sizes and both hashes.
void mend_hashes(std::string& bytes) {
    std::memcpy(bytes.data(), "PALREC\r\n\1\0\0\0\0\1\0\0", 16);
    put(bytes, 16, bytes.size());
    put(bytes, 56, XXH64(bytes.data() + HEAD_BYTES, bytes.size() - HEAD_BYTES, 0));
    put(bytes, HEAD_BYTES - 8, XXH64(bytes.data(), HEAD_BYTES - 8, 0));
}

/// All that the programs make of a record's ticks and tables.
void use(const record::Record& record) {
    for (const auto& [id, table] : record.tables) {
        fuzz::require(table.size() <= sizeof(pal_table));
        try {
            fuzz::require(pal_table_header_ok(record::table_from(table).get()));
            with_tables.note();
        } catch (const record::Error&) {
        }
    }
    const std::vector<double> times_s = record::scene_times_s(record.ticks);
    fuzz::require(times_s.size() == record.ticks.size());
    for (std::size_t i = 0; i < std::min<std::size_t>(times_s.size(), 4); ++i) {
        const pal_tick& tick = record.ticks[i];
        std::string row = record::fault_words(tick.faults) + record::state_word(tick.state);
        for (const record::Column& column : record::columns()) {
            record::append_number(row, column.value(tick, times_s[i]));
        }
        with_ticks.note();
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
    if (bytes.size() >= HEAD_BYTES && (data[0] & MEND_PLACES) != 0) mend_places(bytes);
    if (bytes.size() >= HEAD_BYTES && (data[0] & MEND_HASHES) != 0) mend_hashes(bytes);
    try {
        const record::Record record = record::parse(bytes, "fuzz.palrec");
        fuzz::require(record.header.is_object());
        parsed.note();
        use(record);
    } catch (const record::Error&) {
    }
    return 0;
}
