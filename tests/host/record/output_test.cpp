#include <sys/stat.h>

#include <catch2/catch.hpp>

#include "tests/host/record/sample.hpp"

using namespace palpate;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;
namespace fs = std::filesystem;

namespace {

/// One finished run whose summary says `words`.
void run(const fs::path& directory, const std::string& words) {
    record::OutputDirectory out(directory);
    record::write_file(out.path() / "summary.json", words);
    out.commit();
}

std::size_t entries(const fs::path& folder) {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

}  // namespace

TEST_CASE("a result takes its name when it is complete") {
    const fs::path folder = sample::folder("complete");
    {
        record::OutputDirectory out(folder / "deep/bunny/");
        CHECK(out.path() == folder / "deep/bunny.partial");
        record::write_file(out.path() / "summary.json", "1");
        CHECK_FALSE(fs::exists(folder / "deep/bunny"));
        out.commit();
    }
    CHECK(sample::text_in(folder / "deep/bunny/summary.json") == "1");
    CHECK(entries(folder / "deep") == 1);
}

TEST_CASE("earlier results move on, nine are kept") {
    const fs::path folder = sample::folder("rotation");
    for (int i = 1; i <= 12; ++i) run(folder / "bunny", std::to_string(i));
    CHECK(sample::text_in(folder / "bunny/summary.json") == "12");
    for (int n = 1; n <= 9; ++n) {
        CHECK(sample::text_in(folder / ("bunny." + std::to_string(n)) / "summary.json") ==
              std::to_string(12 - n));
    }
    CHECK(entries(folder) == 10);
}

TEST_CASE("the ninth of each kind of result is dropped for the next") {
    const char* const name = GENERATE(as<const char*>{}, "summary.json", "results.json", "latency.json");
    const fs::path folder = sample::folder("kinds");
    for (int i = 1; i <= 11; ++i) {
        record::OutputDirectory out(folder / "result");
        record::write_file(out.path() / name, std::to_string(i));
        out.commit();
    }
    CHECK(sample::text_in(folder / "result" / name) == "11");
    CHECK(sample::text_in(folder / "result.9" / name) == "2");
}

TEST_CASE("a gap among the earlier results is filled before any is dropped") {
    const fs::path folder = sample::folder("gap");
    for (int i = 1; i <= 4; ++i) run(folder / "bunny", std::to_string(i));
    fs::remove_all(folder / "bunny.2");
    run(folder / "bunny", "5");
    CHECK(sample::text_in(folder / "bunny.1/summary.json") == "4");
    CHECK(sample::text_in(folder / "bunny.2/summary.json") == "3");
    CHECK(sample::text_in(folder / "bunny.3/summary.json") == "1");
}

TEST_CASE("a ninth directory that is no result is never removed") {
    const fs::path folder = sample::folder("foreign");
    for (int i = 1; i <= 10; ++i) run(folder / "bunny", std::to_string(i));
    fs::remove(folder / "bunny.9/summary.json");
    record::write_file(folder / "bunny.9/thesis.txt", "mine");
    CHECK_THROWS_WITH(record::OutputDirectory(folder / "bunny"),  // before the work, not after it
                      EndsWith("bunny.9 is not a result and stays); choose another with --out"));
    CHECK_FALSE(fs::exists(folder / "bunny.partial"));
    CHECK(sample::text_in(folder / "bunny.9/thesis.txt") == "mine");
    CHECK(sample::text_in(folder / "bunny/summary.json") == "10");
}

TEST_CASE("without commit nothing remains and the earlier result is untouched") {
    const fs::path folder = sample::folder("abandoned");
    run(folder / "bunny", "1");
    {
        record::OutputDirectory out(folder / "bunny");
        record::write_file(out.path() / "summary.json", "2");
    }
    CHECK(sample::text_in(folder / "bunny/summary.json") == "1");
    CHECK(entries(folder) == 1);
}

TEST_CASE("what a dead run left is replaced, but for its flight records") {
    const fs::path folder = sample::folder("stale");
    const fs::path partial = folder / "bunny.partial";
    fs::create_directories(partial / "more");
    record::write_file(partial / "log.txt", "dead");
    record::write_file(partial / "run.palrec", "dead");
    record::write_file(partial / "flight-1.palrec", "first");
    record::write_file(partial / "orphan-palpate-1-2.palrec", "another's");
    {
        const record::OutputDirectory ends_early(folder / "bunny");
        record::write_file(partial / "flight-1.palrec", "second");
    }
    CHECK(entries(partial) == 3);
    run(folder / "bunny", "1");
    CHECK(entries(folder) == 1);
    CHECK(entries(folder / "bunny") == 4);
    CHECK(sample::text_in(folder / "bunny/earlier-flight-1.palrec") == "first");
    CHECK(sample::text_in(folder / "bunny/earlier-earlier-flight-1.palrec") == "second");
    CHECK(sample::text_in(folder / "bunny/earlier-orphan-palpate-1-2.palrec") == "another's");
}

TEST_CASE("two runs never write into one directory") {
    const fs::path folder = sample::folder("two");
    record::OutputDirectory first(folder / "bunny");
    record::write_file(first.path() / "summary.json", "first");
    CHECK_THROWS_WITH(record::OutputDirectory(folder / "bunny"),
                      (folder / "bunny").string() +
                          ": cannot be written "
                          "(another run is writing there); choose another with --out");
    CHECK(sample::text_in(first.path() / "summary.json") == "first");
    first.commit();
    CHECK(sample::text_in(folder / "bunny/summary.json") == "first");
}

TEST_CASE("an output that cannot be is refused with the reason, before anything is computed") {
    const fs::path folder = sample::folder("refused");
    record::write_file(folder / "file", "x");
    const auto refused = [](const fs::path& directory, const std::string& reason) {
        CHECK_THROWS_WITH(record::OutputDirectory(directory), directory.string() + ": cannot be written (" +
                                                                  reason + "); choose another with --out");
    };
    refused(folder / "file/bunny", "Not a directory");
    refused(folder / "file", "it is a file");
    refused("", "a directory of its own is needed");
    refused("/", "a directory of its own is needed");
    refused(".", "a directory of its own is needed");
    refused("..", "a directory of its own is needed");
    CHECK(sample::text_in(folder / "file") == "x");
    CHECK(entries(folder) == 1);
}

TEST_CASE("a file is replaced as a whole or not at all") {
    const fs::path folder = sample::folder("file");
    record::write_file(folder / "a.txt", "first");
    record::write_file(folder / "a.txt", "second");
    CHECK(sample::text_in(folder / "a.txt") == "second");
    fs::create_directories(folder / "a.txt.partial");  // in the way of the next one
    CHECK_THROWS_WITH(record::write_file(folder / "a.txt", "third"),
                      (folder / "a.txt").string() + ": cannot be written (Is a directory)");
    CHECK(sample::text_in(folder / "a.txt") == "second");
}

TEST_CASE("a full disk leaves no file and says so") {
    const fs::path folder = sample::folder("full");
    fs::create_symlink("/dev/full", folder / "a.txt.partial");
    CHECK_THROWS_WITH(record::write_file(folder / "a.txt", "x"),
                      (folder / "a.txt").string() + ": cannot be written (No space left on device)");
    CHECK(entries(folder) == 0);
}

TEST_CASE("what is no regular file is never replaced by one, and says so") {
    const fs::path folder = sample::folder("irregular");
    fs::create_directory(folder / "directory");
    REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0);
    fs::create_symlink("pipe", folder / "link");  // a device node is the same, but no test's to lose
    const auto refused = [&](const fs::path& file, const std::string& reason) {
        CHECK_THROWS_WITH(record::write_file(file, "x"),
                          file.string() + ": cannot be written (" + reason + ")");
    };
    refused(folder / "directory", "it is a directory");
    refused(folder / "pipe", "it is no regular file");
    refused(folder / "link", "it is no regular file");
    CHECK(fs::is_fifo(folder / "pipe"));
    CHECK(fs::is_symlink(folder / "link"));
    CHECK(entries(folder) == 3);
}

TEST_CASE("through a symbolic link its target is written, and the link stays") {
    const fs::path folder = sample::folder("link");
    fs::create_directory(folder / "far");
    fs::create_symlink("far/second", folder / "first");
    fs::create_symlink("a.txt", folder / "far/second");
    for (const char* words : {"new", "newer"}) {
        record::write_file(folder / "first", words);
        CHECK(fs::is_symlink(folder / "first"));
        CHECK(fs::is_symlink(folder / "far/second"));
        CHECK(sample::text_in(folder / "far/a.txt") == words);
    }
    CHECK(entries(folder) == 2);
    CHECK(entries(folder / "far") == 2);
    fs::create_symlink("round", folder / "round");
    CHECK_THROWS_WITH(record::write_file(folder / "round", "x"), StartsWith((folder / "round").string()));
    CHECK(fs::is_symlink(folder / "round"));
}
