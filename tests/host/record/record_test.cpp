#include <catch2/catch.hpp>
#include <cstring>

#include "tests/host/record/sample.hpp"

using namespace palpate;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

template <class T>
T value_at(const std::string& bytes, std::size_t offset) {
    T out{};
    std::memcpy(&out, bytes.data() + offset, sizeof out);
    return out;
}

}  // namespace

TEST_CASE("a record reads back byte for byte") {
    const auto folder = sample::folder("round_trip");
    const record::Record first = sample::record();
    record::write(folder / "a.palrec", first);
    const record::Record second = record::read(folder / "a.palrec");
    CHECK(second.header == first.header);
    REQUIRE(second.ticks.size() == first.ticks.size());
    CHECK(std::memcmp(second.ticks.data(), first.ticks.data(), 256 * first.ticks.size()) == 0);
    CHECK(second.tables == first.tables);
    record::write(folder / "b.palrec", second);
    CHECK(sample::text_in(folder / "a.palrec") == sample::text_in(folder / "b.palrec"));
    CHECK(std::distance(std::filesystem::directory_iterator(folder), {}) == 2);  // nothing left beside them
}

TEST_CASE("an empty record reads back") {
    const auto folder = sample::folder("empty");
    record::write(folder / "a.palrec",
                  record::Record{.header = {{"schema", "x"}}, .ticks = {}, .tables = {}});
    const record::Record back = record::read(folder / "a.palrec");
    CHECK(back.ticks.empty());
    CHECK(back.tables.empty());
    CHECK(back.header["schema"] == "x");
}

TEST_CASE("the ticks lie at byte 256 and their number at byte 24, as the protocol says") {
    const auto folder = sample::folder("layout");
    const record::Record record = sample::record();
    record::write(folder / "a.palrec", record);
    const std::string bytes = sample::text_in(folder / "a.palrec");
    CHECK(bytes.substr(0, 8) == "PALREC\r\n");
    CHECK(value_at<std::uint32_t>(bytes, 12) == 256);
    CHECK(value_at<std::uint64_t>(bytes, 16) == bytes.size());
    REQUIRE(value_at<std::uint64_t>(bytes, 24) == record.ticks.size());
    CHECK(std::memcmp(bytes.data() + 256, record.ticks.data(), 256 * record.ticks.size()) == 0);
    CHECK(value_at<std::uint64_t>(bytes, 256 + 256 * record.ticks.size()) == 1);  // first table's id
    const auto json = value_at<std::uint64_t>(bytes, 48);
    CHECK(nlohmann::json::parse(bytes.substr(json)) == record.header);
}

TEST_CASE("the numpy dtype has 256 bytes and the members where C puts them") {
    std::size_t next = 0;
    for (const record::Field& field : record::fields()) {
        INFO(field.name);
        const std::string type = field.type;
        CHECK(field.offset == next);
        CHECK(field.item_bytes == static_cast<std::size_t>(type.back() - '0'));
        next += field.count * field.item_bytes;
    }
    CHECK(next == 256);
    CHECK_THAT(record::numpy_dtype(), StartsWith("[(\"t_ns\", \"<u8\"), (\"tick\", \"<u4\"), "));
    CHECK_THAT(record::numpy_dtype(), Contains("(\"encoder_counts\", \"<i2\", (3,))"));
    CHECK_THAT(sample::text_in(PAL_PROTOCOL_MD), Contains(record::numpy_dtype()));
}

TEST_CASE("a record that is cut short is refused, wherever") {
    const auto folder = sample::folder("cut");
    record::write(folder / "a.palrec", sample::record());
    const std::string bytes = sample::text_in(folder / "a.palrec");
    for (std::size_t n = 0; n < bytes.size(); n += 64) {
        INFO(n);
        CHECK_THROWS_AS(record::parse(bytes.substr(0, n), "cut"), record::Error);
    }
    CHECK_THROWS_AS(record::parse(bytes.substr(0, bytes.size() - 1), "cut"), record::Error);
    CHECK_THROWS_AS(record::parse(bytes + "x", "longer"), record::Error);
    CHECK_NOTHROW(record::parse(bytes, "whole"));
}

TEST_CASE("a record with any one bit flipped is refused") {
    const auto folder = sample::folder("flip");
    record::write(folder / "a.palrec", sample::record());
    std::string bytes = sample::text_in(folder / "a.palrec");
    std::size_t accepted = 0;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += bit < 8 * 256 ? 1 : 13) {
        const auto flip = [&] { bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << bit % 8)); };
        flip();
        try {
            static_cast<void>(record::parse(bytes, "flipped"));
            ++accepted;
        } catch (const record::Error&) {
        }
        flip();
    }
    CHECK(accepted == 0);
}

TEST_CASE("what is wrong with a record is said with the file and the byte") {
    const auto folder = sample::folder("words");
    const auto file = folder / "a.palrec";
    CHECK_THROWS_WITH(record::read(file), file.string() + ": cannot be read (No such file or directory)");
    CHECK_THROWS_WITH(record::read(folder), StartsWith(folder.string() + ": cannot be read ("));
    record::write_file(file, "not a record");
    CHECK_THROWS_WITH(record::read(file), StartsWith(file.string() + ": byte 12: the file ends within"));
    record::write_file(file, std::string(500, 'x'));
    CHECK_THROWS_WITH(record::read(file), file.string() + ": byte 0: not a record of this program");
}

TEST_CASE("an unwritable record leaves no file and says why") {
    const auto folder = sample::folder("unwritable");
    record::write_file(folder / "file", "x");
    CHECK_THROWS_WITH(record::write(folder / "file" / "a.palrec", sample::record()),
                      (folder / "file/a.palrec").string() + ": cannot be written (Not a directory)");
    CHECK_THROWS_AS(record::write("/dev/full/a.palrec", sample::record()), record::Error);
    std::filesystem::create_directories(folder / "taken.palrec");
    CHECK_THROWS_AS(record::write(folder / "taken.palrec", sample::record()), record::Error);
    CHECK(std::distance(std::filesystem::directory_iterator(folder), {}) == 2);
}

TEST_CASE("a table comes back from its used bytes, and from nothing else") {
    const auto table = sample::table(3);
    record::TableBytes bytes = record::table_bytes(*table);
    CHECK(bytes.size() == table->n_bytes);
    const auto back = record::table_from(bytes);
    CHECK(std::memcmp(back.get(), table.get(), sizeof(pal_table)) == 0);
    CHECK_THROWS_AS(record::table_from(std::span(bytes).first(bytes.size() - 1)), record::Error);
    CHECK_THROWS_AS(record::table_from(std::span(bytes).first(7)), record::Error);
    CHECK_THROWS_AS(record::table_from({}), record::Error);
    bytes[0] ^= std::byte{1};
    CHECK_THROWS_AS(record::table_from(bytes), record::Error);
    CHECK_THROWS_AS(record::table_from(record::TableBytes(sizeof(pal_table) + 1)), record::Error);
    CHECK_THROWS_AS(record::table_bytes(pal_table{}), record::Error);
}
