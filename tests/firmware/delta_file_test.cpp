// Geometry and gains from a file: the built-in Falcon's to the bit, larger and smaller deltas as such, and
// each mistake named with its line.
#include "firmware/port/linux/delta_file.h"

#include <toml++/toml.h>
#include <catch2/catch.hpp>
#include <clocale>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/firmware/delta_text.hpp"

using Catch::Matchers::Contains;
using deltatext::nf1;
using deltatext::scaled;
using deltatext::with;

namespace {

struct Answer {
    bool ok;
    pal_delta_file file;
    std::string why;
};

Answer parse(const std::string& text) {
    Answer answer{};
    std::vector<char> why(PAL_DELTA_WORDS_BYTES);
    answer.ok = pal_delta_file_parse("my.toml", text.data(), text.size(), &answer.file, why.data());
    answer.why = why.data();
    return answer;
}

/// The one line that must be said of `text`.
std::string refusal(const std::string& text) {
    const Answer answer = parse(text);
    CHECK_FALSE(answer.ok);
    CHECK(answer.why.find('\n') == std::string::npos);
    return answer.why;
}

bool same_bits(float a, float b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

void check_same(const pal_delta& a, const pal_delta& b) {
    CHECK(same_bits(a.arm_m, b.arm_m));
    CHECK(same_bits(a.forearm_m, b.forearm_m));
    CHECK(same_bits(a.offset_m, b.offset_m));
    CHECK(same_bits(a.platform_u_m, b.platform_u_m));
    CHECK(same_bits(a.platform_v_m, b.platform_v_m));
    CHECK(same_bits(a.base_u_m, b.base_u_m));
    CHECK(same_bits(a.base_v_m, b.base_v_m));
    for (int i = 0; i < 3; ++i) {
        CHECK(same_bits(a.cos_leg[i], b.cos_leg[i]));
        CHECK(same_bits(a.sin_leg[i], b.sin_leg[i]));
    }
    CHECK(same_bits(a.counts_per_rad, b.counts_per_rad));
    CHECK(same_bits(a.theta_zero_rad, b.theta_zero_rad));
    CHECK(same_bits(a.theta_min_rad, b.theta_min_rad));
    CHECK(same_bits(a.theta_max_rad, b.theta_max_rad));
    CHECK(same_bits(a.units_per_n_m, b.units_per_n_m));
    CHECK(a.motor_max == b.motor_max);
}

}  // namespace

TEST_CASE("nf1.toml is the built-in Falcon, bit for bit") {
    pal_delta_file file{};
    pal_delta_file built_in{};
    std::vector<char> why(PAL_DELTA_WORDS_BYTES);
    const bool ok = pal_delta_file_read(PAL_NF1_TOML, &file, why.data());
    INFO(why.data());
    REQUIRE(ok);
    check_same(file.delta, PAL_DELTA_NF1);
    REQUIRE(pal_delta_file_read(nullptr, &built_in, why.data()));
    check_same(built_in.delta, PAL_DELTA_NF1);
    for (int i = 0; i < 3; ++i) CHECK(same_bits(file.centre_m[i], built_in.centre_m[i]));
}

TEST_CASE("toml++ reads the same numbers from nf1.toml") {
    const toml::table table = toml::parse_file(PAL_NF1_TOML);
    CHECK(table.size() == 15);
    const auto number = [&table](const char* key) {
        return static_cast<float>(table[key].value<double>().value());
    };
    const pal_delta& g = PAL_DELTA_NF1;
    CHECK(number("arm_m") == g.arm_m);
    CHECK(number("forearm_m") == g.forearm_m);
    CHECK(number("offset_m") == g.offset_m);
    CHECK(number("platform_u_m") == g.platform_u_m);
    CHECK(number("platform_v_m") == g.platform_v_m);
    CHECK(number("base_u_m") == g.base_u_m);
    CHECK(number("base_v_m") == g.base_v_m);
    CHECK(number("counts_per_rad") == g.counts_per_rad);
    CHECK(number("theta_zero_deg") == 35.0F);
    CHECK(number("theta_min_deg") == -25.0F);
    CHECK(number("theta_max_deg") == 90.0F);
    CHECK(number("units_per_n_m") == g.units_per_n_m);
    CHECK(number("motor_max_units") == g.motor_max);
    for (std::size_t i = 0; i < 3; ++i) {
        const double leg_rad = table["leg_deg"][i].value<double>().value() * std::acos(-1.0) / 180.0;
        CHECK(g.cos_leg[i] == Approx(std::cos(leg_rad)).epsilon(1e-7));
        CHECK(g.sin_leg[i] == Approx(std::sin(leg_rad)).epsilon(1e-7));
        CHECK(table["centre_m"][i].value<double>().value() == (i == 2 ? 0.12 : 0.0));
    }
}

TEST_CASE("a scaled delta has scaled positions at the same arm angles, and torques that are as much larger") {
    const double scale = GENERATE(0.5, 1.0, 2.0, 4.0);
    CAPTURE(scale);
    const Answer answer = parse(scaled(scale));
    INFO(answer.why);
    REQUIRE(answer.ok);
    const pal_delta& g = answer.file.delta;
    const auto larger = static_cast<float>(scale);
    const float force_n[3] = {1.0F, 2.0F, 3.0F};
    for (const auto& [x, y, z] : {std::array{0.0F, 0.0F, 0.08F}, std::array{0.0F, 0.0F, 0.15F},
                                  std::array{0.03F, -0.03F, 0.14F}, std::array{-0.03F, 0.02F, 0.10F}}) {
        const float small_m[3] = {x, y, z};
        const float large_m[3] = {larger * x, larger * y, larger * z};
        float theta_rad[3], large_rad[3], found_m[3], torque_n_m[3], large_n_m[3];
        REQUIRE(pal_delta_inverse(&PAL_DELTA_NF1, small_m, theta_rad));
        REQUIRE(pal_delta_inverse(&g, large_m, large_rad));
        REQUIRE(pal_delta_forward(&g, theta_rad, answer.file.centre_m, 12, found_m));
        REQUIRE(pal_delta_torque(&PAL_DELTA_NF1, small_m, force_n, torque_n_m));
        REQUIRE(pal_delta_torque(&g, large_m, force_n, large_n_m));
        for (int i = 0; i < 3; ++i) {
            CHECK(large_rad[i] == Approx(theta_rad[i]).margin(2e-6));
            CHECK(found_m[i] == Approx(large_m[i]).margin(2e-6 * scale));
            CHECK(large_n_m[i] == Approx(larger * torque_n_m[i]).margin(2e-5 * scale));
        }
    }
}

TEST_CASE("order, blank lines, comments, CR LF and TOML's ways to write a number do not matter") {
    const Answer plain = parse(nf1());
    REQUIRE(plain.ok);
    std::istringstream lines(nf1());
    std::string backwards;
    for (std::string line; std::getline(lines, line);)
        backwards = " \t" + line + "  # caf\xC3\xA9\r\n\r\n" + backwards;
    const std::vector<std::string> texts{backwards,
                                         nf1().substr(0, nf1().size() - 1),
                                         with("arm_m", "+6e-2"),
                                         with("arm_m", "6.0E-0_2"),
                                         with("arm_m", "0.06_0#x"),
                                         with("motor_max_units", "4_095"),
                                         with("motor_max_units", "4.095e+3"),
                                         with("counts_per_rad", "1_572.562_5"),
                                         with("leg_deg", "[1.05e2,-15 ,\t-135]")};
    for (const std::string& text : texts) {
        CAPTURE(text);
        const Answer answer = parse(text);
        INFO(answer.why);
        REQUIRE(answer.ok);
        check_same(answer.file.delta, plain.file.delta);
        CHECK_NOTHROW(toml::parse(text));
    }
}

TEST_CASE("a locale with a decimal comma changes nothing") {
    for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8"}) {
        if (std::setlocale(LC_ALL, name) != nullptr) break;
    }
    if (*std::localeconv()->decimal_point != ',') WARN("no locale with a decimal comma is installed");
    const Answer answer = parse(nf1());
    (void)std::setlocale(LC_ALL, "C");
    REQUIRE(answer.ok);
    check_same(answer.file.delta, PAL_DELTA_NF1);
}

TEST_CASE("each mistake in a line is told with file, line and what would be right") {
    struct Mistake {
        std::string key, value, words;
    };
    const auto& [key, value, words] = GENERATE(values<Mistake>({
        {"arm_m", "", "my.toml:1: arm_m: nothing is no number; expected a decimal one such as 0.06"},
        {"arm_m", "\"0.06\"", "my.toml:1: arm_m: \"0.06\" is no number"},
        {"arm_m", "0,06", "my.toml:1: arm_m: 0,06 is no number; expected a decimal one such as 0.06"},
        {"arm_m", "0.06 m", "my.toml:1: m after the value; expected the end of the line or a # comment"},
        {"arm_m", ".06", ".06 is no number"},
        {"arm_m", "6.", "6. is no number"},
        {"arm_m", "00.06", "00.06 is no number"},
        {"arm_m", "0._06", "is no number"},
        {"arm_m", "0.0__6", "is no number"},
        {"arm_m", "0.06_", "is no number"},
        {"arm_m", "0x1", "is no number"},
        {"arm_m", "1e", "is no number"},
        {"arm_m", "nan", "my.toml:1: arm_m: nan is not finite; expected 0.005 to 1"},
        {"arm_m", "-inf", "my.toml:1: arm_m: -inf is not finite"},
        {"arm_m", "1e39", "my.toml:1: arm_m: 1e39 is not finite"},
        {"arm_m", "60", "my.toml:1: arm_m: 60 is out of range; expected 0.005 to 1"},
        {"arm_m", "-0.06", "my.toml:1: arm_m: -0.06 is out of range"},
        {"arm_m", "[0.06, 0.06, 0.06]", "my.toml:1: arm_m: [0.06, is no number"},
        {"arm_m", "0." + std::string(62, '0'), "my.toml:1: arm_m: a number of 64 characters; at most 63"},
        {"platform_u_m", "1e-60", "my.toml:4: platform_u_m: 1e-60 is too small for 32 bits; expected 0 or"},
        {"leg_deg", "105", "my.toml:8: leg_deg: no [ before number 1; expected [number, number, number]"},
        {"leg_deg", "[105, -15]", "my.toml:8: leg_deg: no , before number 3"},
        {"leg_deg", "[105, -15, -135, 0]", "my.toml:8: leg_deg: no ] after three numbers"},
        {"leg_deg", "[105, -15,\n-135]", "my.toml:8: leg_deg: nothing is no number"},
        {"leg_deg", "[105, -15, 400]", "my.toml:8: leg_deg: 400 is out of range; expected -360 to 360"},
        {"motor_max_units", "4095.5",
         "my.toml:14: motor_max_units: 4095.5 is no whole number; expected 1 to 32767"},
        {"motor_max_units", "32768", "my.toml:14: motor_max_units: 32768 is out of range"},
        {"units_per_n_m", "-4200", "my.toml:13: units_per_n_m: -4200 is out of range; expected 1 to 1e+06"},
    }));
    CAPTURE(key, value);
    CHECK_THAT(refusal(with(key, value)), Contains(words));
}

TEST_CASE("each mistake with keys is told with file, line and what would be right") {
    CHECK(refusal(nf1() + "arm_mm = 1\n") ==
          "my.toml:16: unknown key arm_mm; the nearest known one is arm_m");
    CHECK_THAT(refusal("theta_zero_rad = 1\n"), Contains("my.toml:1: ") && Contains("is theta_zero_deg"));
    CHECK_THAT(refusal(std::string(500, 'x') + " = 1\n"), Contains("my.toml:1: unknown key xxx"));
    CHECK(refusal(nf1() + "\narm_m = 0.06\n") ==
          "my.toml:17: arm_m again, first in line 1; expected it once");
    CHECK(refusal("[geometry]\n" + nf1()) == "my.toml:1: [geometry]; expected keys without sections");
    CHECK(refusal("arm_m\n") == "my.toml:1: arm_m; expected key = value");
    CHECK(refusal("\"arm_m\" = 1\n") == "my.toml:1: \"arm_m\" = 1; expected key = value");
    CHECK(refusal("a.b = 1\n") == "my.toml:1: a.b = 1; expected key = value");
    CHECK_THAT(refusal(""), Contains("my.toml:1: arm_m is missing; expected arm_m = number, 0.005 to 1"));
    for (const std::string& key : deltatext::keys()) {
        CAPTURE(key);
        CHECK_THAT(refusal(deltatext::without(key)),
                   Contains("my.toml:15: " + key + " is missing; expected " + key));
    }
}

TEST_CASE("what is no text for TOML is refused at its line") {
    CHECK_THAT(refusal(nf1() + "# \xFF\n"), Contains("my.toml:16: byte FF is no UTF-8"));
    CHECK_THAT(refusal(nf1() + "# \xC0\x80\n"), Contains("my.toml:16: byte C0"));
    CHECK_THAT(refusal(nf1() + "# \xED\xA0\x80\n"), Contains("my.toml:16: byte ED"));
    CHECK_THAT(refusal(nf1() + "# \xE2\x82"), Contains("my.toml:16: byte E2"));
    CHECK_THAT(refusal(nf1() + std::string("#\0\n", 3)), Contains("my.toml:16: control character 00"));
    CHECK_THAT(refusal(nf1() + "# a\rb\n"), Contains("my.toml:16: control character 0D"));
    CHECK_THAT(refusal(nf1() + std::string(70000, '\n')), Contains("longer than 65536 bytes"));
    CHECK(parse(nf1() + std::string(PAL_DELTA_FILE_BYTES_MAX - nf1().size(), '\n')).ok);
}

TEST_CASE("numbers that are each in range but make no device are refused") {
    CHECK_THAT(refusal(with("theta_min_deg", "90")),
               Contains("my.toml:11: theta_min_deg is not below theta_max_deg of line 12"));
    const auto travel =
        Contains("my.toml:9: counts_per_rad: the arms' travel from theta_zero_deg does not fit 16 bits");
    CHECK_THAT(refusal(with("counts_per_rad", "32000")), travel);  // -25 degrees
    std::string upper = with("counts_per_rad", "20000");
    upper.replace(upper.find("zero_deg = 35"), 13, "zero_deg = -20");
    CHECK_THAT(refusal(upper), travel);  // 90 degrees
    CHECK_THAT(refusal(with("centre_m", "[0, 0, 0.3]")),
               Contains("my.toml:15: centre_m: the arms do not reach it (no inverse kinematics)"));
    CHECK_THAT(refusal(with("centre_m", "[0, 0, 0]")), Contains("my.toml:15: centre_m: "));
    CHECK_THAT(refusal(with("theta_max_deg", "0")),
               Contains("my.toml:15: centre_m: arm 1 would stand at ") &&
                   Contains("degrees; expected theta_min_deg to theta_max_deg"));
    CHECK_THAT(
        refusal(with("leg_deg", "[105, 105, -135]")),
        Contains("my.toml:15: centre_m: the mechanism is singular there") && Contains("leg_deg, line 8"));
}

TEST_CASE("a refused file leaves the delta as it was") {
    pal_delta_file file{};
    std::vector<char> why(PAL_DELTA_WORDS_BYTES);
    const std::string text = with("leg_deg", "[0, 0, 0]");
    CHECK_FALSE(pal_delta_file_parse("x", text.data(), text.size(), &file, why.data()));
    CHECK(file.delta.arm_m == 0.0F);
}

TEST_CASE("a file that cannot be read is told in one line") {
    pal_delta_file file{};
    std::vector<char> why(PAL_DELTA_WORDS_BYTES);
    CHECK_FALSE(pal_delta_file_read("/nowhere/x.toml", &file, why.data()));
    CHECK(std::string(why.data()) ==
          "/nowhere/x.toml: No such file or directory; expected a file such as nf1.toml");
    CHECK_FALSE(pal_delta_file_read("/", &file, why.data()));
    CHECK_THAT(std::string(why.data()), Contains("/: not a file"));
    CHECK_FALSE(pal_delta_file_read("/dev/zero", &file, why.data()));
    CHECK_FALSE(pal_delta_file_read("no\nfile", &file, why.data()));
    CHECK_THAT(std::string(why.data()), Contains("no?file: "));
}
