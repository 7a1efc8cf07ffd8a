#include <catch2/catch.hpp>
#include <limits>
#include <sstream>

#include "host/record/csv.hpp"
#include "tests/host/record/sample.hpp"

using namespace palpate;
using Catch::Matchers::StartsWith;

namespace {

std::vector<std::string> lines_of(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> out;
    for (std::string line; std::getline(in, line);) out.push_back(line);
    return out;
}

std::vector<std::string> cells_of(const std::string& line) {
    std::istringstream in(line);
    std::vector<std::string> out;
    for (std::string cell; std::getline(in, cell, ',');) out.push_back(cell);
    return out;
}

/// The cell under `name`.
std::string cell(const std::vector<std::string>& lines, std::size_t row, const std::string& name) {
    const auto names = cells_of(lines[0]), cells = cells_of(lines[row + 1]);
    REQUIRE(names.size() == cells.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == name) return cells[i];
    }
    return "no column " + name;
}

std::string text_of(double value) {
    std::string out;
    record::append_number(out, value);
    return out;
}

}  // namespace

TEST_CASE("ticks.csv begins with the columns that everybody relies on") {
    const auto folder = sample::folder("header");
    record::write_ticks_csv(folder / "ticks.csv", {});
    CHECK_THAT(
        sample::text_in(folder / "ticks.csv"),
        StartsWith("t_s,tick,x_m,y_m,z_m,vx_m_per_s,vy_m_per_s,vz_m_per_s,fx_n,fy_n,fz_n,depth_m,k_n_per_m,"
                   "table_id,table_age_ticks,faults,"));
    CHECK(lines_of(sample::text_in(folder / "ticks.csv")).size() == 1);
}

TEST_CASE("every column of ticks.csv shows its own member") {
    std::vector<pal_tick> ticks(1);
    pal_tick& t = ticks[0];
    t = {};
    t.tick = 12, t.path_tick = 5, t.faults = 8, t.state = 3, t.stop = 2048, t.table_id = 77, t.before_id = 76;
    t.table_age_ticks = 4, t.fade_weight = 0.25F, t.gain = 0.5F, t.n_missed = 2, t.buttons = 3, t.homed = 1;
    t.truth_valid = 1, t.t_ns = 12000000, t.depth_m = 0.0015F, t.k_n_per_m = 512.5F, t.potential_j = 1e-9F;
    t.fade_work_j = -2e-5F, t.hand_work_j = 0.1F, t.wake_late_ns = 34567;
    for (int i = 0; i < 3; ++i) {
        const auto f = static_cast<float>(i);
        t.encoder_counts[i] = static_cast<std::int16_t>(-100 - i);
        t.motor_counts[i] = static_cast<std::int16_t>(200 + i);
        t.position_m[i] = 1.5F + f, t.velocity_m_per_s[i] = 11.5F + f, t.force_n[i] = 21.5F + f;
        t.table_force_n[i] = 31.5F + f, t.truth_position_m[i] = 41.5F + f, t.truth_force_n[i] = 51.5F + f;
        t.hand_target_m[i] = 61.5F + f;
    }
    const auto folder = sample::folder("values");
    record::write_ticks_csv(folder / "ticks.csv", ticks);
    const auto lines = lines_of(sample::text_in(folder / "ticks.csv"));
    REQUIRE(lines.size() == 2);
    const std::map<std::string, std::string> truth = {{"t_s", "0.005"},
                                                      {"tick", "12"},
                                                      {"x_m", "1.5"},
                                                      {"y_m", "2.5"},
                                                      {"z_m", "3.5"},
                                                      {"vx_m_per_s", "11.5"},
                                                      {"vy_m_per_s", "12.5"},
                                                      {"vz_m_per_s", "13.5"},
                                                      {"fx_n", "21.5"},
                                                      {"fy_n", "22.5"},
                                                      {"fz_n", "23.5"},
                                                      {"depth_m", "0.0015"},
                                                      {"k_n_per_m", "512.5"},
                                                      {"table_id", "77"},
                                                      {"table_age_ticks", "4"},
                                                      {"faults", "8"},
                                                      {"state", "3"},
                                                      {"stop", "2048"},
                                                      {"gain", "0.5"},
                                                      {"before_id", "76"},
                                                      {"fade_weight", "0.25"},
                                                      {"table_fx_n", "31.5"},
                                                      {"table_fy_n", "32.5"},
                                                      {"table_fz_n", "33.5"},
                                                      {"encoder_0_counts", "-100"},
                                                      {"encoder_1_counts", "-101"},
                                                      {"encoder_2_counts", "-102"},
                                                      {"motor_0_counts", "200"},
                                                      {"motor_1_counts", "201"},
                                                      {"motor_2_counts", "202"},
                                                      {"buttons", "3"},
                                                      {"homed", "1"},
                                                      {"potential_j", "1e-09"},
                                                      {"fade_work_j", "-2e-05"},
                                                      {"hand_work_j", "0.1"},
                                                      {"truth_valid", "1"},
                                                      {"true_x_m", "41.5"},
                                                      {"true_y_m", "42.5"},
                                                      {"true_z_m", "43.5"},
                                                      {"true_fx_n", "51.5"},
                                                      {"true_fy_n", "52.5"},
                                                      {"true_fz_n", "53.5"},
                                                      {"target_x_m", "61.5"},
                                                      {"target_y_m", "62.5"},
                                                      {"target_z_m", "63.5"},
                                                      {"path_ticks", "5"},
                                                      {"missed_ticks", "2"},
                                                      {"wake_late_ns", "34567"},
                                                      {"t_ns", "12000000"}};
    CHECK(cells_of(lines[0]).size() == truth.size());
    for (const auto& [name, value] : truth) {
        INFO(name);
        CHECK(cell(lines, 0, name) == value);
    }
}

TEST_CASE("scene time is zero where the path begins and negative before") {
    const std::vector<double> times = record::scene_times_s(sample::ticks(6));
    CHECK(times == std::vector<double>{-0.002, -0.001, 0.0, 0.001, 0.002, 0.003});
}

TEST_CASE("scene time counts on after a path and from the first tick without one") {
    auto ticks = sample::ticks(6);
    ticks[5].path_tick = 0;
    CHECK(record::scene_times_s(ticks)[5] == 0.003);
    for (pal_tick& tick : ticks) tick.path_tick = 0, tick.tick += 1000;
    CHECK(record::scene_times_s(ticks)[5] == 0.005);
    CHECK(record::scene_times_s({}).empty());
}

TEST_CASE("numbers are the shortest that read back") {
    CHECK(text_of(0.1) == "0.1");
    CHECK(text_of(static_cast<double>(0.1F)) == "0.1");  // as float32
    CHECK(text_of(1e6) == "1000000");
    CHECK(text_of(123456789012345.0) == "123456789012345");
    CHECK(text_of(-0.002) == "-0.002");
    CHECK(text_of(1e300) == "1e+300");
    CHECK(text_of(0.1 + 0.2) == "0.30000000000000004");
    CHECK(text_of(std::numeric_limits<double>::quiet_NaN()) == "nan");
    CHECK(text_of(-std::numeric_limits<double>::infinity()) == "-inf");
}

TEST_CASE("ticks.json describes every column of ticks.csv in its order") {
    const auto folder = sample::folder("json");
    record::write_ticks_json(folder / "ticks.json");
    record::write_ticks_csv(folder / "ticks.csv", sample::ticks(1));
    const auto document = nlohmann::json::parse(sample::text_in(folder / "ticks.json"));
    const auto names = cells_of(lines_of(sample::text_in(folder / "ticks.csv"))[0]);
    CHECK(document["schema"] == "palpate.ticks/1");
    REQUIRE(document["columns"].size() == names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
        CHECK(document["columns"][i]["name"] == names[i]);
        CHECK_FALSE(document["columns"][i]["unit"].get<std::string>().empty());
        CHECK_FALSE(document["columns"][i]["description"].get<std::string>().empty());
    }
}
