// The record file, little-endian. docs/PROTOCOL.md 5 has the same for other readers.
//      0  char[8]  "PALREC\r\n"
//      8  u32      version of the layout, 1
//     12  u32      bytes of a tick, 256
//     16  u64      bytes of the whole file
//     24  u64      n_ticks
//     32  u64      n_tables
//     40  u64      offset of the tables, 256 + 256 n_ticks
//     48  u64      offset of the JSON header, which reaches to the end of the file
//     56  u64      XXH64 (seed 0) of the bytes from 256 to the end
//     64  u64[23]  0
//    248  u64      XXH64 (seed 0) of the bytes 0 to 248
//    256  pal_tick[n_ticks], then the tables, each: u64 id, u64 n_bytes, the bytes, zeros up to a multiple of
//    8
#include "host/record/record.hpp"

#include <xxhash.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <new>
#include <system_error>

#include "host/record/aside.hpp"

namespace palpate::record {
namespace {

constexpr char MAGIC[8] = {'P', 'A', 'L', 'R', 'E', 'C', '\r', '\n'};
constexpr std::uint32_t VERSION = 1;

struct FileHeader {
    char magic[8];
    std::uint32_t version, tick_bytes;
    std::uint64_t file_bytes, n_ticks, n_tables, tables_offset, json_offset, content_xxh64;
    std::uint64_t reserved[23];
    std::uint64_t header_xxh64;
};
static_assert(offsetof(FileHeader, content_xxh64) == 56 && offsetof(FileHeader, header_xxh64) == 248);
static_assert(sizeof(FileHeader) == TICKS_OFFSET && sizeof(pal_tick) == 256);

struct TableHeader {
    std::uint64_t id, n_bytes;
};

std::uint64_t header_digest(const FileHeader& header) {
    return XXH64(&header, offsetof(FileHeader, header_xxh64), 0);
}

std::size_t padded(std::size_t n_bytes) {
    return (n_bytes + 7) / 8 * 8;
}

std::string tables_text(const std::map<std::uint64_t, TableBytes>& tables) {
    std::string out;
    for (const auto& [id, bytes] : tables) {
        const TableHeader header{.id = id, .n_bytes = bytes.size()};
        out.append(reinterpret_cast<const char*>(&header), sizeof header);
        out.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        out.append(padded(bytes.size()) - bytes.size(), '\0');
    }
    return out;
}

/// A file's bytes on their way into a Record.
class Parser {
public:
    Parser(std::string name, std::string_view bytes) : name_(std::move(name)), bytes_(bytes) {}

    [[nodiscard]] Record record() {
        read_header();
        Record out;
        read_ticks(out);
        read_tables(out);
        const std::string_view json = bytes_.substr(header_.json_offset);
        out.header = nlohmann::json::parse(json.begin(), json.end(), nullptr, false);
        if (!out.header.is_object()) fail(header_.json_offset, "the header is not a JSON object");
        return out;
    }

private:
    [[noreturn]] void fail(std::uint64_t offset, const std::string& what) const {
        throw Error(name_ + ": byte " + std::to_string(offset) + ": " + what);
    }

    void read_header() {
        if (bytes_.size() < sizeof header_) {
            fail(bytes_.size(), "the file ends within the first 256 bytes; not a record, or cut short");
        }
        std::memcpy(&header_, bytes_.data(), sizeof header_);
        if (std::memcmp(header_.magic, MAGIC, sizeof MAGIC) != 0) fail(0, "not a record of this program");
        if (header_.version != VERSION) {
            fail(8, "layout " + std::to_string(header_.version) + "; this program reads layout 1");
        }
        if (header_.header_xxh64 != header_digest(header_)) fail(0, "the first 256 bytes are damaged");
        if (header_.file_bytes != bytes_.size()) {
            fail(bytes_.size(), "the file has " + std::to_string(bytes_.size()) + " bytes and should have " +
                                    std::to_string(header_.file_bytes) + "; cut short or added to");
        }
        check_sizes();
        const std::string_view content = bytes_.substr(TICKS_OFFSET);
        if (header_.content_xxh64 != XXH64(content.data(), content.size(), 0)) {
            fail(TICKS_OFFSET, "the content does not match its XXH64; damaged");
        }
    }

    /// Nothing is believed that the file cannot hold.
    void check_sizes() const {
        const std::uint64_t room = (bytes_.size() - TICKS_OFFSET) / sizeof(pal_tick);
        if (header_.tick_bytes != sizeof(pal_tick)) fail(12, "ticks of another size than 256 bytes");
        if (header_.n_ticks > room) fail(24, "more ticks than the file can hold");
        if (header_.tables_offset != TICKS_OFFSET + header_.n_ticks * sizeof(pal_tick)) {
            fail(40, "the tables do not begin where the ticks end");
        }
        if (header_.json_offset < header_.tables_offset || header_.json_offset > bytes_.size()) {
            fail(48, "the header does not lie behind the tables");
        }
    }

    void read_ticks(Record& out) const {
        out.ticks.resize(header_.n_ticks);
        if (out.ticks.empty()) return;
        std::memcpy(out.ticks.data(), bytes_.data() + TICKS_OFFSET, out.ticks.size() * sizeof(pal_tick));
    }

    void read_tables(Record& out) const {
        std::uint64_t at = header_.tables_offset;
        for (std::uint64_t i = 0; i < header_.n_tables; ++i) {
            TableHeader table{};
            if (header_.json_offset - at < sizeof table) fail(at, "a table's head lies outside the tables");
            std::memcpy(&table, bytes_.data() + at, sizeof table);
            at += sizeof table;
            if (table.n_bytes > sizeof(pal_table) || padded(table.n_bytes) > header_.json_offset - at) {
                fail(at - sizeof table, "a table is larger than the file can hold");
            }
            const auto* begin = reinterpret_cast<const std::byte*>(bytes_.data() + at);
            if (!out.tables.emplace(table.id, TableBytes(begin, begin + table.n_bytes)).second) {
                fail(at - sizeof table, "table " + std::to_string(table.id) + " for the second time");
            }
            at += padded(table.n_bytes);
        }
        if (at != header_.json_offset) fail(at, "bytes between the tables and the header");
    }

    std::string name_;
    std::string_view bytes_;
    FileHeader header_{};
};

}  // namespace

TableBytes table_bytes(const pal_table& table) {
    if (!pal_table_header_ok(&table))
        throw Error("table " + std::to_string(table.id) + ": not a sealed table");
    const auto* begin = reinterpret_cast<const std::byte*>(&table);
    return {begin, begin + table.n_bytes};
}

std::unique_ptr<pal_table> table_from(std::span<const std::byte> bytes) {
    auto table = std::make_unique<pal_table>();
    const bool fits = bytes.size() >= offsetof(pal_table, coef) && bytes.size() <= sizeof(pal_table);
    if (fits) std::memcpy(table.get(), bytes.data(), bytes.size());
    if (!fits || !pal_table_header_ok(table.get()) || table->n_bytes != bytes.size()) {
        throw Error("a table of " + std::to_string(bytes.size()) +
                    " bytes: its header is not that of a sealed table");
    }
    return table;
}

void write(const std::filesystem::path& file, const Record& record) {
    const std::string tables = tables_text(record.tables);
    const std::string json = json_text(record.header);
    const std::size_t ticks_bytes = record.ticks.size() * sizeof(pal_tick);
    std::string content;
    content.reserve(ticks_bytes + tables.size() + json.size());
    if (ticks_bytes > 0) content.append(reinterpret_cast<const char*>(record.ticks.data()), ticks_bytes);
    content += tables;
    content += json;

    FileHeader header{};
    std::memcpy(header.magic, MAGIC, sizeof MAGIC);
    header.version = VERSION;
    header.tick_bytes = sizeof(pal_tick);
    header.file_bytes = sizeof header + content.size();
    header.n_ticks = record.ticks.size();
    header.n_tables = record.tables.size();
    header.tables_offset = TICKS_OFFSET + ticks_bytes;
    header.json_offset = header.tables_offset + tables.size();
    header.content_xxh64 = XXH64(content.data(), content.size(), 0);
    header.header_xxh64 = header_digest(header);

    AsideFile aside(file);
    aside.add(&header, sizeof header);
    aside.add(content.data(), content.size());
    aside.commit();
}

Record parse(std::string_view bytes, const std::string& name) {
    return Parser(name, bytes).record();
}

Record read(const std::filesystem::path& file) {
    std::error_code error;
    const std::uint64_t size =
        std::filesystem::file_size(file, error);  // an error for what is not a regular file
    if (error) throw Error(file.string() + ": cannot be read (" + error.message() + ")");
    std::ifstream in(file, std::ios::binary);
    std::string bytes;
    try {
        bytes.resize(size);
    } catch (const std::exception&) {
        throw Error(file.string() + ": " + std::to_string(size) + " bytes do not fit into memory");
    }
    in.read(bytes.data(), static_cast<std::streamsize>(size));
    if (!in) throw Error(file.string() + ": cannot be read to its end");
    return parse(bytes, file.string());
}

}  // namespace palpate::record
