#include "firmware/app/options.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

namespace {

struct Answer {
    bool ok;
    pal_loop_options options;
    std::string complaint;
};

Answer read(std::vector<std::string> words) {
    words.insert(words.begin(), "palpate-loop");
    static std::vector<std::string> kept;  // the options borrow argv
    kept = words;
    std::vector<char*> argv;
    for (std::string& word : kept) argv.push_back(word.data());
    char* text = nullptr;
    std::size_t n_text = 0;
    FILE* complaint = open_memstream(&text, &n_text);
    Answer answer{};
    answer.ok = pal_loop_options_read(static_cast<int>(argv.size()), argv.data(), &answer.options, complaint);
    std::fclose(complaint);
    answer.complaint.assign(text, n_text);
    std::free(text);
    return answer;
}

}  // namespace

TEST_CASE("the loop's options are read") {
    const Answer answer = read(
        {"--link", "/palpate-1", "--device", "link:/tmp/f", "--force-max-n", "4.5", "--ramp-ticks", "0"});
    REQUIRE(answer.ok);
    CHECK(std::string(answer.options.link_name) == "/palpate-1");
    CHECK(std::string(answer.options.device_path) == "/tmp/f");
    CHECK(answer.options.force_max_n == 4.5F);
    CHECK(answer.options.ramp_ticks == 0);
    CHECK(read({"--help"}).options.help);
}

TEST_CASE("the loop takes a Falcon on the USB, by its serial number or the first") {
    const Answer first = read({"--link", "/x", "--device", "usb"});
    REQUIRE(first.ok);
    CHECK(first.options.usb);
    CHECK(first.options.serial == nullptr);
    CHECK(first.options.device_path == nullptr);
    const Answer named = read({"--link", "/x", "--device", "usb:12PZ657E", "--firmware", "f.bin"});
    REQUIRE(named.ok);
    CHECK(std::string(named.options.serial) == "12PZ657E");
    CHECK(std::string(named.options.firmware) == "f.bin");
    const Answer last = read({"--link", "/x", "--device", "usb:1", "--device", "link:/y"});
    REQUIRE(last.ok);
    CHECK_FALSE(last.options.usb);
    CHECK(last.options.serial == nullptr);
}

TEST_CASE("the loop may be asked for all that a Falcon is rated for") {
    const Answer answer = read({"--link", "/x", "--device", "link:/y", "--force-max-n", "8.9"});
    REQUIRE(answer.ok);
    CHECK(answer.options.force_max_n == 8.9F);
}

TEST_CASE("any force limit above zero is taken, as a scene takes it") {
    const std::string least = GENERATE(as<std::string>{}, "1e-3", "9.9e-4", "1e-9");
    const Answer answer = read({"--link", "/x", "--device", "link:/y", "--force-max-n", least});
    REQUIRE(answer.ok);
    CHECK(answer.options.force_max_n == std::stof(least));
    // Too small for a float: the smallest normal one, for 0 is not a limit.
    CHECK(read({"--link", "/x", "--device", "link:/y", "--force-max-n", "1e-300"}).options.force_max_n ==
          std::numeric_limits<float>::min());
}

TEST_CASE("the soft start takes one second, here and in the help, as in a scene") {
    CHECK(read({"--link", "/x", "--device", "link:/y"}).options.ramp_ticks == 1000);
    char* text = nullptr;
    std::size_t n_text = 0;
    FILE* out = open_memstream(&text, &n_text);
    pal_loop_options_help(out);
    std::fclose(out);
    CHECK(std::string(text, n_text).find("0 to 60000 (1000)") != std::string::npos);
    std::free(text);
}

TEST_CASE("without a word the loop asks for locked memory and priority 80") {
    const pal_realtime_choice choice = read({"--link", "/x", "--device", "link:/y"}).options.realtime;
    CHECK(choice.policy == PAL_POLICY_FIFO);
    CHECK(choice.priority == 80);
    CHECK(choice.cpu == PAL_REALTIME_ANY_CPU);
    CHECK(choice.lock_memory);
}

TEST_CASE("how the loop is scheduled may be chosen") {
    const Answer fifo = read({"--no-lock", "--link", "/x", "--device", "link:/y", "--policy", "fifo",
                              "--priority", "99", "--cpu", "0"});
    REQUIRE(fifo.ok);
    CHECK(fifo.options.realtime.policy == PAL_POLICY_FIFO);
    CHECK(fifo.options.realtime.priority == 99);
    CHECK(fifo.options.realtime.cpu == 0);
    CHECK_FALSE(fifo.options.realtime.lock_memory);
    CHECK(read({"--link", "/x", "--device", "usb", "--policy", "deadline"}).options.realtime.policy ==
          PAL_POLICY_DEADLINE);
    const Answer other = read({"--link", "/x", "--device", "usb", "--policy", "other", "--cpu", "1"});
    REQUIRE(other.ok);
    CHECK(other.options.realtime.policy == PAL_POLICY_OTHER);
    CHECK(other.options.realtime.cpu == 1);
}

TEST_CASE("--zero needs a device and nothing else") {
    const Answer answer = read({"--zero", "--device", "link:/y"});
    REQUIRE(answer.ok);
    CHECK(answer.options.zero);
    CHECK(read({"--device", "usb:1", "--zero", "--firmware", "f"}).ok);
    CHECK_FALSE(read({"--link", "/x", "--device", "link:/y"}).options.zero);
}

TEST_CASE("bad options are refused in one line that names them") {
    const std::vector<std::vector<std::string>> bad = {
        {},
        {"--link", "/x"},
        {"--link"},
        {"--speed", "3"},
        {"--link", "/x", "--device", "usb:"},
        {"--link", "/x", "--device", "usb2"},
        {"--link", "/x", "--device", "link"},
        {"--link", "/x", "--firmware", "f.bin"},
        {"--link", "/x", "--device", "link:"},
        {"--link", "/x", "--device", "link:/y", "--force-max-n", "9"},
        {"--link", "/x", "--device", "link:/y", "--force-max-n", "8.9000006"},
        {"--link", "/x", "--device", "link:/y", "--force-max-n", "0"},
        {"--link", "/x", "--device", "link:/y", "--force-max-n", "-0.0"},
        {"--link", "/x", "--device", "link:/y", "--force-max-n", "-1e-9"},
        {"--link", "/x", "--device", "link:/y", "--force-max-n", "nan"},
        {"--link", "/x", "--device", "link:/y", "--force-max-n", "-nan"},
        {"--link", "/x", "--device", "link:/y", "--force-max-n", "inf"},
        {"--link", "/x", "--device", "link:/y", "--force-max-n", "4x"},
        {"--link", "/x", "--device", "link:/y", "--ramp-ticks", "-1"},
        {"--link", "/x", "--device", "link:/y", "--ramp-ticks", ""},
        {"--link", "/x", "--device", "link:/y", "--policy", "rr"},
        {"--link", "/x", "--device", "link:/y", "--policy"},
        {"--link", "/x", "--device", "link:/y", "--priority", "0"},
        {"--link", "/x", "--device", "link:/y", "--priority", "100"},
        {"--link", "/x", "--device", "link:/y", "--priority", "1.5"},
        {"--link", "/x", "--device", "link:/y", "--priority", "80", "--policy", "other"},
        {"--link", "/x", "--device", "link:/y", "--cpu", "-1"},
        {"--link", "/x", "--device", "link:/y", "--cpu", "0.5"},
        {"--link", "/x", "--device", "link:/y", "--cpu", "nan"},
        {"--link", "/x", "--device", "link:/y", "--cpu", "0", "--policy", "deadline"},
        {"--zero"},
        {"--zero", "--link", "/x"},
        {"--zero", "--link", "/x", "--device", "link:/y"},
    };
    for (const auto& words : bad) {
        const Answer answer = read(words);
        CHECK_FALSE(answer.ok);
        CHECK(std::count(answer.complaint.begin(), answer.complaint.end(), '\n') == 1);
    }
}
