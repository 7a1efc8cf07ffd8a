#include <algorithm>
#include <array>

#include "tests/firmware/falcon_script.hpp"

using namespace script;

TEST_CASE("the sentence for a person has the byte, the attempt and the rate") {
    const Bytes image = container(49);
    Session s;
    s.device.image = image;
    s.device.tamper = [&](std::size_t, const Bytes& sent, Bytes& said) {
        if (sent.size() == 62) said[40] = 0xEE;
    };
    pal_falcon_config config = Session::config_for(image);
    config.boot.n_attempts = 3;
    REQUIRE(s.start(config) == PAL_FALCON_OK);
    REQUIRE(s.boot());
    std::array<char, 400> text{};
    const std::size_t n = pal_falcon_describe(&s.falcon, text.data(), text.size());
    CHECK(std::string(text.data()) ==
          "The firmware arrived damaged. Use a shorter USB cable or another port without a hub and start "
          "again. "
          "(wrong echo at byte 40 of 128, attempt 3 of 3 at 115385 baud)");
    CHECK(std::string(text.data()).size() == n);
    for (std::size_t room = 1; room < n; ++room) {  // cut where the room ends, never beyond
        std::array<char, 400> cut;
        cut.fill('x');
        REQUIRE(pal_falcon_describe(&s.falcon, cut.data(), room) == room - 1);
        REQUIRE(cut[room - 1] == '\0');
        REQUIRE(cut[room] == 'x');
    }
    CHECK(pal_falcon_describe(&s.falcon, nullptr, 0) == 0);
}

TEST_CASE("a device that was only asked has no attempts and no rate to tell") {
    Session s;
    pal_falcon_config config = pal_falcon_config_default();
    config.boot.reload = PAL_RELOAD_NEVER;
    REQUIRE(s.start(config) == PAL_FALCON_OK);
    REQUIRE(s.boot());
    std::array<char, 400> text{};
    (void)pal_falcon_describe(&s.falcon, text.data(), text.size());
    const std::string words = text.data();
    CHECK(words.find("(no firmware running)") != std::string::npos);
    CHECK(words.find("attempt") == std::string::npos);
}

TEST_CASE("every failure and stage has a name and words of its own") {
    std::vector<std::string> seen;
    for (int i = PAL_FAIL_NO_PIC; i <= PAL_FAIL_UNPLUGGED; ++i) {
        const auto failure = static_cast<pal_falcon_failure>(i);
        seen.emplace_back(pal_failure_name(failure));
        seen.emplace_back(pal_failure_words(failure));
        CHECK(std::string(pal_failure_words(failure)).size() > 40);
    }
    for (int i = PAL_STAGE_NONE; i <= PAL_STAGE_FAILED; ++i) {
        const auto stage = static_cast<pal_falcon_stage>(i);
        seen.emplace_back(pal_stage_name(stage));
        seen.emplace_back(pal_stage_words(stage));
    }
    std::sort(seen.begin(), seen.end());
    CHECK(std::adjacent_find(seen.begin(), seen.end()) == seen.end());
    CHECK(seen.front().size() > 1);
}

TEST_CASE("the trace holds every request, write, reply and stage, and overwrites the oldest") {
    Session s;
    std::array<pal_falcon_trace_record, 64> records{};
    pal_falcon_trace trace{records.data(), 64, 0};
    pal_falcon_config config = Session::config_for(s.device.image);
    config.trace = &trace;
    REQUIRE(s.start(config) == PAL_FALCON_OK);
    REQUIRE(s.run_to(PAL_FALCON_HOMING));
    REQUIRE(trace.n_written <= 64);
    std::vector<std::string> traced;
    std::vector<int> stages;
    for (std::size_t k = 0; k < trace.n_written; ++k) {
        const pal_falcon_trace_record& r = records[k];
        char line[32];
        std::snprintf(line, sizeof line, "C %02X %04X %04X", r.request, r.value, r.index);
        if (r.kind == PAL_TRACE_CONTROL) traced.emplace_back(line);
        if (r.kind == PAL_TRACE_WRITE) traced.push_back("W " + hex(r.bytes, r.n_bytes));
        if (r.kind == PAL_TRACE_STAGE) stages.push_back(r.request);
    }
    CHECK(traced == s.device.log);
    CHECK(stages == std::vector<int>{PAL_STAGE_CHIP, PAL_STAGE_RESTART, PAL_STAGE_ASK, PAL_STAGE_AUTOBAUD,
                                     PAL_STAGE_UPLOAD, PAL_STAGE_RUN, PAL_STAGE_FIRST_REPLY,
                                     PAL_STAGE_HOMING});
    REQUIRE(s.run([&] { return trace.n_written > 200; }));
    CHECK(records[trace.n_written % 64].time_us <= records[(trace.n_written + 63) % 64].time_us);
}
