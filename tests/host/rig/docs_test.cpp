#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "host/rig/rig.hpp"
#include "tests/host/rig/client.hpp"

using namespace palpate::rig;
using namespace palpate::rig::test;

TEST_CASE("docs/MODBUS.md is what the register table says") {
    std::ifstream file(MODBUS_MD);
    std::ostringstream text;
    text << file.rdbuf();
    INFO("write it anew with: test_rig '[.write-docs]'");
    CHECK(text.str() == modbus_markdown());
}

TEST_CASE("docs/MODBUS.md is written from the register table", "[.write-docs]") {
    std::ofstream file(MODBUS_MD);
    file << modbus_markdown();
    CHECK(file.flush().good());
}

TEST_CASE("the worked examples of docs/MODBUS.md are answered as written there") {
    Rig rig;
    rig.shown.force_n = 3.25F;
    Client client(rig.server);
    std::istringstream text(modbus_markdown());
    Bytes answer;
    int n_examples = 0;
    for (std::string line; std::getline(text, line);) {
        const std::string key = line.substr(0, 12);
        if (key == "    request ") answer = client.ask(hex(line.substr(12)));
        if (key != "    answer  ") continue;
        INFO(line);
        CHECK(answer == hex(line.substr(12)));
        ++n_examples;
    }
    CHECK(n_examples == 3);
}
