#include "tests/host/record/sample.hpp"

#include <fstream>
#include <iterator>

namespace sample {

std::vector<pal_tick> ticks(std::size_t n) {
    std::vector<pal_tick> out(n);
    for (std::size_t i = 0; i < n; ++i) {
        pal_tick& tick = out[i];
        const auto at = static_cast<std::uint32_t>(i);
        tick.tick = at;
        tick.t_ns = i * 1000000;
        tick.state = at < 3 ? PAL_STATE_HOMING : PAL_STATE_ENABLED;
        tick.path_tick = at < 3 ? 0 : at - 2;
        tick.homed = at < 3 ? 0 : 1;
        tick.depth_m = at > n / 4 && at < n / 2 ? 0.001F : -0.01F;
        tick.position_m[0] = 0.1F + static_cast<float>(i) * 1e-4F;
        tick.encoder_counts[1] = static_cast<std::int16_t>(-100 + static_cast<int>(i % 200));
        tick.motor_counts[2] = 4095;
    }
    return out;
}

std::unique_ptr<pal_table> table(std::uint64_t id) {
    auto out = std::make_unique<pal_table>();
    out->id = id;
    out->n_nodes = 5;
    out->spacing_m = 0.001F;
    for (int i = 0; i < 3 * 7 * 7; ++i) out->coef[i] = static_cast<float>(i);
    pal_table_seal(out.get());
    return out;
}

palpate::record::Record record() {
    palpate::record::Record out;
    out.header = {{"schema", "palpate.record/1"}, {"scene", "scene = 1\ntitle = \"é\"\n"}};
    out.ticks = ticks(20);
    for (const std::uint64_t id : {1U, 2U, 7U}) out.tables[id] = palpate::record::table_bytes(*table(id));
    return out;
}

std::string text_in(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::filesystem::path folder(const std::string& name) {
    const std::filesystem::path out = std::filesystem::path(PAL_TEST_FOLDER) / name;
    std::filesystem::remove_all(out);
    std::filesystem::create_directories(out);
    return out;
}

}  // namespace sample
