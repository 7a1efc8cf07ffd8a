// A record file of arbitrary bytes: a record or Error, and nothing else. An odd first byte repairs length and
// hashes, so that what lies behind them is reached.
#include <xxhash.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "host/record/record.hpp"

namespace {

void put(std::string& bytes, std::size_t offset, std::uint64_t value) {
    std::memcpy(bytes.data() + offset, &value, sizeof value);
}

/// Magic, version, length and both hashes of docs/PROTOCOL.md 5.
void repair(std::string& bytes) {
    constexpr std::size_t HEAD = palpate::record::TICKS_OFFSET;
    if (bytes.size() < HEAD) return;
    std::memcpy(bytes.data(), "PALREC\r\n\1\0\0\0\0\1\0\0", 16);
    put(bytes, 16, bytes.size());
    put(bytes, 56, XXH64(bytes.data() + HEAD, bytes.size() - HEAD, 0));
    put(bytes, HEAD - 8, XXH64(bytes.data(), HEAD - 8, 0));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace palpate;
    if (size == 0) return 0;
    std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
    if (data[0] % 2 == 1) repair(bytes);
    try {
        const record::Record record = record::parse(bytes, "fuzz.palrec");
        for (const auto& [id, table] : record.tables) static_cast<void>(record::table_from(table));
        static_cast<void>(record::scene_times_s(record.ticks));
    } catch (const record::Error&) {
    }
    return 0;
}
