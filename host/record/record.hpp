/// The record of a run: every tick, every table, and what is needed to read them years later. Layout:
/// docs/PROTOCOL.md 5.
#pragma once
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/table.h"
#include "common/tick.h"

namespace palpate::record {

struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A published table's used bytes. Throws Error for a table without a valid header.
using TableBytes = std::vector<std::byte>;
[[nodiscard]] TableBytes table_bytes(const pal_table& table);

struct Record {
    nlohmann::json header;  ///< schema palpate.record/1, resolved scene, clocks, geometry, build
    std::vector<pal_tick> ticks;
    std::map<std::uint64_t, TableBytes> tables;  ///< by id
};

/// Written aside and renamed when complete; an exception leaves no file.
void write(const std::filesystem::path& file, const Record& record);
/// Throws Error with what is wrong and where; never trusts a size that the file cannot hold.
[[nodiscard]] Record read(const std::filesystem::path& file);
/// The same from a file's bytes; `name` begins the errors.
[[nodiscard]] Record parse(std::string_view bytes, const std::string& name);
/// The full table again from its used bytes; throws Error when pal_table_check's header part refuses it.
[[nodiscard]] std::unique_ptr<pal_table> table_from(std::span<const std::byte> bytes);

/// Running XXH64 digests of a virtual run.
class Digest {
public:
    Digest();
    ~Digest();
    void tick(
        const pal_tick& tick);  ///< io: counts, motor words, buttons, homed; state: every field but clocks
    void table(const pal_table& table);    ///< state: its used bytes
    [[nodiscard]] std::string io() const;  ///< 16 hex digits
    [[nodiscard]] std::string state() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// One member of pal_tick as it lies in the file: the table from which the numpy dtype is made.
struct Field {
    const char* name;
    const char* type;  ///< as numpy writes it, little-endian: "<f4"
    std::size_t count, offset, item_bytes;
};
[[nodiscard]] std::span<const Field> fields();
/// `[("t_ns", "<u8"), ...]`: numpy.fromfile(file, dtype=..., count=..., offset=TICKS_OFFSET) reads the ticks.
[[nodiscard]] std::string numpy_dtype();
inline constexpr std::size_t TICKS_OFFSET = 256;

/// One column of ticks.csv: the one table from which the CSV and ticks.json are made.
struct Column {
    const char* name;
    const char* unit;
    const char* description;
    double (*value)(const pal_tick&, double t_s);
};
[[nodiscard]] std::span<const Column> columns();

/// Scene time of each tick, s: 0 where the hand's path begins, negative before; from the first tick when no
/// path ran.
[[nodiscard]] std::vector<double> scene_times_s(std::span<const pal_tick> ticks);

/// ticks.csv, ticks.json, events.csv (t_s,tick,event,detail: state changes, stops, faults beginning and
/// ending, table swaps, first and last contact). Each written aside and renamed.
void write_ticks_csv(const std::filesystem::path& file, std::span<const pal_tick> ticks);
void write_ticks_json(const std::filesystem::path& file);
void write_events_csv(const std::filesystem::path& file, std::span<const pal_tick> ticks);

/// Words for fault bits, states and stops: "table-left", "enabled", "e-stop", "none".
[[nodiscard]] std::string fault_words(std::uint32_t faults);
[[nodiscard]] std::string state_word(std::uint32_t state);
/// 2026-11-28T04:06:14Z, as documents write a time.
[[nodiscard]] std::string utc_text(std::time_t unix_s);
/// A hash as records and summaries write it: 16 hexadecimal digits.
[[nodiscard]] std::string hash_text(std::uint64_t hash);
[[nodiscard]] std::string stop_word(std::uint32_t stop);

/// JSON as text, one line without an indent. What is not UTF-8 in it (a file's name may be anything) becomes
/// U+FFFD: no finished run is lost for a name.
template <class Json>  // nlohmann::json, or ordered_json, which keeps its order
[[nodiscard]] std::string json_text(const Json& json, int indent = -1) {
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}
/// Writes `content` to `file` by way of a file beside it and a rename; throws Error naming the file and the
/// reason.
void write_file(const std::filesystem::path& file, std::string_view content);
/// What `file` holds, without the blanks and line ends behind its last word; empty when it cannot be read.
[[nodiscard]] std::string text_in(const std::filesystem::path& file);
/// A directory that is written aside (DIR.partial) and takes its name on commit(); an earlier DIR moves to
/// DIR.1, DIR.1 to DIR.2 and so on (9 kept). Without commit() the earlier result is untouched and nothing
/// remains but flight records (flight-*, orphan-*.palrec), which the next one takes in as earlier-*.palrec.
/// Throws Error `DIR: cannot be written (reason); choose another with --out`.
class OutputDirectory {
public:
    explicit OutputDirectory(const std::filesystem::path& directory);
    ~OutputDirectory();
    [[nodiscard]] const std::filesystem::path& path() const;  ///< where to write now
    void commit();
    OutputDirectory(const OutputDirectory&) = delete;
    OutputDirectory& operator=(const OutputDirectory&) = delete;

private:
    [[nodiscard]] std::filesystem::path kept(int n) const;
    /// Where the earlier results make room: the first n without DIR.n, else the ninth, which is dropped.
    [[nodiscard]] int free_place() const;
    void rotate() const;
    std::filesystem::path final_, partial_;
    int lock_ = -1;  ///< held while alive: two runs never write into one directory
    bool committed_ = false;
};

}  // namespace palpate::record
