// palpate trace as a person at a terminal has it.
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <fstream>
#include <iterator>

#include "host/record/record.hpp"
#include "tests/host/app/processes.hpp"

using namespace palpate;
using namespace palpate::test;

TEST_CASE("Ctrl-C in the middle of a trace leaves no file", "[trace]") {
    constexpr std::uint32_t N_TICKS = 3000;  // much more text than a pipe holds
    const Folder folder;
    record::Record record{.header = {{"schema", "palpate.record/1"}}, .ticks = {}, .tables = {}};
    for (std::uint32_t i = 0; i < N_TICKS; ++i) {
        pal_tick& tick = record.ticks.emplace_back();
        tick.tick = i;
        tick.t_ns = 1000000ULL * i;
        tick.state = PAL_STATE_ENABLED;
    }
    record::write(folder / "run.palrec", record);
    const std::filesystem::path aside = folder / "t.json.partial";
    REQUIRE(mkfifo(aside.c_str(), 0600) == 0);  // it is in the middle for as long as nobody reads on
    Program palpate(PAL_PALPATE_PROGRAM,
                    {"trace", (folder / "run.palrec").string(), "--out", (folder / "t.json").string()},
                    folder);
    std::ifstream pipe(aside);
    REQUIRE(pipe.get() == '{');
    palpate.send(SIGINT);
    const std::string rest{std::istreambuf_iterator<char>(pipe), std::istreambuf_iterator<char>()};
    CHECK(palpate.wait() == 130);
    CHECK_FALSE(rest.empty());
    CHECK_FALSE(std::filesystem::exists(aside));
    CHECK_FALSE(std::filesystem::exists(folder / "t.json"));
}
