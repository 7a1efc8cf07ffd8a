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
    CHECK_THAT(device(folder, {"rate", "--help"}).out, Contains("force-check"));
    CHECK_THAT(device(folder, {"force-check"}).out, Contains("virtual work"));
}
