#include "firmware/app/options.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
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

TEST_CASE("the loop may be asked for all that a Falcon is rated for") {
    const Answer answer = read({"--link", "/x", "--device", "link:/y", "--force-max-n", "8.9"});
    REQUIRE(answer.ok);
    CHECK(answer.options.force_max_n == 8.9F);
}

TEST_CASE("bad options are refused in one line that names them") {
    const std::vector<std::vector<std::string>> bad = {
        {},
        {"--link", "/x"},
        {"--link"},
        {"--speed", "3"},
        {"--link", "/x", "--device", "usb"},
        {"--link", "/x", "--device", "link:"},
        {"--link", "/x", "--device", "link:/y", "--force-max-n", "9"},
        {"--link", "/x", "--device", "link:/y", "--force-max-n", "8.9000006"},
        {"--link", "/x", "--device", "link:/y", "--force-max-n", "0"},
        {"--link", "/x", "--device", "link:/y", "--force-max-n", "nan"},
        {"--link", "/x", "--device", "link:/y", "--force-max-n", "4x"},
        {"--link", "/x", "--device", "link:/y", "--ramp-ticks", "-1"},
        {"--link", "/x", "--device", "link:/y", "--ramp-ticks", ""},
    };
    for (const auto& words : bad) {
        const Answer answer = read(words);
        CHECK_FALSE(answer.ok);
        CHECK(std::count(answer.complaint.begin(), answer.complaint.end(), '\n') == 1);
    }
}
