// palpate device is palpate-falcon: the same arguments, output and exit code.
#include <catch2/catch.hpp>

#include "tests/host/app/processes.hpp"

using namespace palpate::test;
using Catch::Matchers::Contains;

namespace {

Outcome device(const Folder& folder, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(),
                     {"run", "--timing", "immediate", "--", PAL_PALPATE_PROGRAM, "device"});
    return call(PAL_FALCON_SIM_PROGRAM, arguments, folder);
}

}  // namespace

TEST_CASE("palpate device passes arguments, output and exit code through", "[device]") {
    const Folder folder;
    const Outcome list = device(folder, {"list", "--json"});
    CHECK(list.code == 0);
    CHECK(nlohmann::json::parse(list.out)["devices"][0]["serial"] == "PALSIM01");
    CHECK(device(folder, {"fly"}).code == 2);
    CHECK(device(folder, {"boot", "--firmware", "/nowhere.bin"}).code == 2);
    CHECK(device(folder, {"boot", "--no-reload"}).code == 3);
    CHECK_THAT(device(folder, {"--help"}).out, Contains("palpate-falcon: a Novint Falcon on the USB"));
    CHECK_THAT(device(folder, {"rate", "--help"}).out,
               Contains("force-check") && !Contains("palpate device latency"));
    CHECK_THAT(device(folder, {"--help"}).out, Contains("palpate device latency --help"));
    const Outcome bare = device(folder, {});
    CHECK(bare.code == 2);
    CHECK(bare.out.empty());
    CHECK_THAT(bare.err, Contains("palpate device latency --help") && Contains("palpate-falcon: "));
    CHECK_THAT(device(folder, {"force-check"}).out, Contains("virtual work"));
}

TEST_CASE("latency refuses what its loop would refuse, before anything starts", "[device]") {
    const Folder folder;
    const auto refused = [&](std::vector<std::string> more, const std::string& words) {
        more.insert(more.begin(),
                    {"device", "latency", "--device", "sim", "--out", (folder / "out").string()});
        const Outcome outcome = call(PAL_PALPATE_PROGRAM, more, folder);
        CHECK(outcome.code == 2);
        CHECK(outcome.out.empty());
        CHECK_THAT(outcome.err, Contains(words));
        CHECK_FALSE(std::filesystem::exists(folder / "out"));
    };
    refused({"--cpu", "1000"}, "--cpu 1000: this machine has processors 0 to ");
    refused({"--policy", "deadline", "--priority", "5"}, "--priority belongs to --policy fifo");
    refused({"--policy", "deadline", "--cpu", "0"}, "--cpu 0: the kernel keeps no thread with a deadline");
    refused({"--seconds", "nan"}, "--seconds");
}

TEST_CASE("a latency report that nobody got is a failure", "[real]") {
    const Folder folder;
    const Outcome outcome =
        call("sh",
             {"-c", "exec \"$0\" device latency --device sim --seconds 1 --json --quiet >/dev/full",
              PAL_PALPATE_PROGRAM},
             folder);
    CHECK(outcome.code == 1);
    CHECK_THAT(outcome.err, Contains("stdout cannot be written"));
}
