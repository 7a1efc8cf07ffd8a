// Geometry and gains of a delta from arbitrary bytes: a usable delta, from a text in which toml++ reads the
// same numbers, or one line that says what is wrong.
#include <toml++/toml.h>
#include <cmath>
#include <string>

#include "firmware/port/linux/delta_file.h"
#include "tests/fuzz/input.hpp"

namespace {

using fuzz::require;

fuzz::Reached accepted("delta accepted"), geometric("geometry refused"), ranged("number out of range");

bool near(const toml::node_view<const toml::node> node, float value) {
    const double read = node.value<double>().value();
    return std::abs(read - static_cast<double>(value)) <= 1e-6 * std::abs(read) + 1e-37;
}

void check(std::string_view text, const pal_delta_file& file) {
    const toml::table table = toml::parse(text);
    const pal_delta& g = file.delta;
    require(table.size() == 15);
    const auto at = [&table](const char* key) { return std::as_const(table)[key]; };
    require(near(at("arm_m"), g.arm_m) && near(at("forearm_m"), g.forearm_m) &&
            near(at("offset_m"), g.offset_m));
    require(near(at("platform_u_m"), g.platform_u_m) && near(at("platform_v_m"), g.platform_v_m));
    require(near(at("base_u_m"), g.base_u_m) && near(at("base_v_m"), g.base_v_m));
    require(near(at("counts_per_rad"), g.counts_per_rad) && near(at("units_per_n_m"), g.units_per_n_m));
    require(near(at("motor_max_units"), static_cast<float>(g.motor_max)) && g.motor_max >= 1);
    require(g.theta_min_rad < g.theta_max_rad);
    float theta_rad[3];
    float found_m[3];
    require(pal_delta_inverse(&g, file.centre_m, theta_rad));
    require(pal_delta_forward(&g, theta_rad, file.centre_m, 12, found_m));
    for (std::size_t i = 0; i < 3; ++i) {
        require(near(at("centre_m")[i], file.centre_m[i]));
        require(std::abs(g.cos_leg[i] * g.cos_leg[i] + g.sin_leg[i] * g.sin_leg[i] - 1.0F) < 1e-6F);
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view text = fuzz::text_of({data, size});
    pal_delta_file file{};
    char why[PAL_DELTA_WORDS_BYTES];
    if (pal_delta_file_parse("fuzz.toml", text.data(), text.size(), &file, why)) {
        accepted.note();
        require(why[0] == '\0');
        check(text, file);
        return 0;
    }
    const std::string_view words = why;
    require(words.starts_with("fuzz.toml:") && words.find('\n') == std::string_view::npos);
    require(words.find("expected") != std::string_view::npos ||
            words.find("nearest") != std::string_view::npos ||
            words.find("at most") != std::string_view::npos);
    if (words.find("centre_m: the ") != std::string_view::npos) geometric.note();
    if (words.find("out of range") != std::string_view::npos) ranged.note();
    return 0;
}
