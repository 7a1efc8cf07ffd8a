// docs/PROTOCOL.md against the C structures and both codecs: every offset, type, worked example and vector.
#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "common/link.h"
#include "firmware/core/intake.h"
#include "firmware/falcon/wire.h"
#include "sim/falcon/codec.h"

namespace {

using Row = std::vector<std::string>;
using Bytes = std::vector<std::uint8_t>;

struct Field {
    std::size_t offset, n_bytes;
    bool operator==(const Field&) const = default;
};
using Layout = std::map<std::string, Field>;

#define PAL_FIELD_OF(type, member)                       \
    {                                                    \
#member, Field {                                 \
            offsetof(type, member), sizeof(type::member) \
        }                                                \
    }

Layout layout_of_link() {
    return {PAL_FIELD_OF(pal_link, header), PAL_FIELD_OF(pal_link, host), PAL_FIELD_OF(pal_link, loop),
            PAL_FIELD_OF(pal_link, tables), PAL_FIELD_OF(pal_link, ticks)};
}

Layout layout_of_header() {
    using T = pal_link_header;
    return {PAL_FIELD_OF(T, magic),   PAL_FIELD_OF(T, endian),      PAL_FIELD_OF(T, abi),
            PAL_FIELD_OF(T, n_bytes), PAL_FIELD_OF(T, table_bytes), PAL_FIELD_OF(T, tick_bytes),
            PAL_FIELD_OF(T, n_slots), PAL_FIELD_OF(T, n_ticks),     PAL_FIELD_OF(T, nonce),
            PAL_FIELD_OF(T, reserved)};
}

Layout layout_of_host() {
    using T = pal_link_host;
    return {PAL_FIELD_OF(T, pid),   PAL_FIELD_OF(T, heartbeat), PAL_FIELD_OF(T, enable),
            PAL_FIELD_OF(T, estop), PAL_FIELD_OF(T, stop),      PAL_FIELD_OF(T, reserved)};
}

Layout layout_of_loop() {
    using T = pal_link_loop;
    return {PAL_FIELD_OF(T, pid),
            PAL_FIELD_OF(T, heartbeat),
            PAL_FIELD_OF(T, ended),
            PAL_FIELD_OF(T, end_reason),
            PAL_FIELD_OF(T, n_bad_tables),
            PAL_FIELD_OF(T, realtime),
            PAL_FIELD_OF(T, realtime_refused),
            PAL_FIELD_OF(T, n_minor_faults),
            PAL_FIELD_OF(T, n_major_faults),
            PAL_FIELD_OF(T, n_preempted),
            PAL_FIELD_OF(T, reserved)};
}

Layout layout_of_table() {
    using T = pal_table;
    return {PAL_FIELD_OF(T, magic),
            PAL_FIELD_OF(T, abi),
            PAL_FIELD_OF(T, n_bytes),
            PAL_FIELD_OF(T, crc32c),
            PAL_FIELD_OF(T, id),
            PAL_FIELD_OF(T, source_hash),
            PAL_FIELD_OF(T, tick),
            PAL_FIELD_OF(T, law),
            PAL_FIELD_OF(T, n_nodes),
            PAL_FIELD_OF(T, spacing_m),
            PAL_FIELD_OF(T, valid_radius_m),
            PAL_FIELD_OF(T, kappa_per_m),
            PAL_FIELD_OF(T, error_k_relative),
            PAL_FIELD_OF(T, depth_scale_m),
            PAL_FIELD_OF(T, psi),
            PAL_FIELD_OF(T, p0_m),
            PAL_FIELD_OF(T, made_for_m),
            PAL_FIELD_OF(T, axes),
            PAL_FIELD_OF(T, reserved),
            PAL_FIELD_OF(T, coef)};
}

Layout layout_of_tick() {
    using T = pal_tick;
    return {PAL_FIELD_OF(T, t_ns),
            PAL_FIELD_OF(T, tick),
            PAL_FIELD_OF(T, faults),
            PAL_FIELD_OF(T, state),
            PAL_FIELD_OF(T, stop),
            PAL_FIELD_OF(T, table_id),
            PAL_FIELD_OF(T, before_id),
            PAL_FIELD_OF(T, table_age_ticks),
            PAL_FIELD_OF(T, fade_weight),
            PAL_FIELD_OF(T, gain),
            PAL_FIELD_OF(T, n_missed),
            PAL_FIELD_OF(T, buttons),
            PAL_FIELD_OF(T, homed),
            PAL_FIELD_OF(T, truth_valid),
            PAL_FIELD_OF(T, reserved_byte),
            PAL_FIELD_OF(T, encoder_counts),
            PAL_FIELD_OF(T, motor_counts),
            PAL_FIELD_OF(T, position_m),
            PAL_FIELD_OF(T, velocity_m_per_s),
            PAL_FIELD_OF(T, force_n),
            PAL_FIELD_OF(T, table_force_n),
            PAL_FIELD_OF(T, depth_m),
            PAL_FIELD_OF(T, k_n_per_m),
            PAL_FIELD_OF(T, potential_j),
            PAL_FIELD_OF(T, fade_work_j),
            PAL_FIELD_OF(T, hand_work_j),
            PAL_FIELD_OF(T, reserved_j),
            PAL_FIELD_OF(T, stamp_ns),
            PAL_FIELD_OF(T, truth_position_m),
            PAL_FIELD_OF(T, truth_force_n),
            PAL_FIELD_OF(T, hand_target_m),
            PAL_FIELD_OF(T, path_tick),
            PAL_FIELD_OF(T, wake_late_ns),
            PAL_FIELD_OF(T, reserved)};
}

std::vector<std::string> page() {
    std::ifstream in(PAL_PROTOCOL_MD);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    REQUIRE(lines.size() > 100);
    return lines;
}

Row cells(const std::string& line) {
    Row out;
    std::istringstream in(line);
    std::string cell;
    std::getline(in, cell, '|');
    while (std::getline(in, cell, '|')) {
        const std::size_t first = cell.find_first_not_of(' ');
        out.push_back(
            first == std::string::npos ? "" : cell.substr(first, cell.find_last_not_of(' ') - first + 1));
    }
    return out;
}

/// The rows of the first table after the line that begins with `before`, without its head.
std::vector<Row> table_after(const std::string& before) {
    std::vector<Row> rows;
    bool found = false;
    for (const std::string& line : page()) {
        if (line.starts_with(before)) found = true;
        if (found && line.starts_with("|")) rows.push_back(cells(line));
        if (found && !line.starts_with("|") && !rows.empty()) break;
    }
    INFO(before);
    REQUIRE(rows.size() > 2);
    rows.erase(rows.begin(), rows.begin() + 2);
    return rows;
}

/// Bytes of "u32", "f32[3]", "64 bytes".
std::size_t size_of(const std::string& type) {
    if (type.ends_with(" bytes")) return std::stoul(type);
    static const std::map<std::string, std::size_t> ONE = {{"u8", 1},  {"u16", 2}, {"i16", 2},
                                                           {"u32", 4}, {"f32", 4}, {"u64", 8}};
    const std::size_t open = type.find('[');
    INFO(type);
    REQUIRE(ONE.contains(type.substr(0, open)));
    return ONE.at(type.substr(0, open)) * (open == std::string::npos ? 1 : std::stoul(type.substr(open + 1)));
}

Layout layout_on_page(const std::string& structure) {
    Layout layout;
    for (const Row& row : table_after("`" + structure + "`")) {
        REQUIRE(row.size() >= 3);
        layout[row[1].substr(1, row[1].size() - 2)] = {std::stoul(row[0]), size_of(row[2])};
    }
    return layout;
}

Bytes hex(const std::string& text) {
    Bytes bytes;
    std::istringstream in(text);
    for (std::string byte; in >> byte;)
        bytes.push_back(static_cast<std::uint8_t>(std::stoul(byte, nullptr, 16)));
    return bytes;
}

/// The bytes of a fenced block.
Bytes block(const std::string& name) {
    Bytes bytes;
    bool inside = false;
    for (const std::string& line : page()) {
        if (line.starts_with("```")) {
            inside = line == "```" + name;
            continue;
        }
        if (!inside) continue;
        for (const std::uint8_t byte : hex(line)) bytes.push_back(byte);
    }
    return bytes;
}

template <typename T>
std::array<T, 3> three(const std::string& cell) {
    std::istringstream in(cell);
    std::array<T, 3> v{};
    in >> v[0] >> v[1] >> v[2];
    INFO(cell);
    REQUIRE(!in.fail());
    return v;
}

}  // namespace

TEST_CASE("every member of every structure stands in docs/PROTOCOL.md with its offset and size") {
    CHECK(layout_on_page("pal_link") == layout_of_link());
    CHECK(layout_on_page("pal_link_header") == layout_of_header());
    CHECK(layout_on_page("pal_link_host") == layout_of_host());
    CHECK(layout_on_page("pal_link_loop") == layout_of_loop());
    CHECK(layout_on_page("pal_table") == layout_of_table());
    CHECK(layout_on_page("pal_tick") == layout_of_tick());
}

TEST_CASE("the sizes in docs/PROTOCOL.md are those of a fresh segment") {
    const auto link = std::make_unique<pal_link>();
    pal_link_init(link.get(), 0);
    std::map<std::string, std::uint32_t> said;
    for (const Row& row : table_after("`pal_link_header`")) {
        if (row[3].find_first_of("0123456789") != 0) continue;
        said[row[1]] = static_cast<std::uint32_t>(std::stoul(row[3], nullptr, 0));
    }
    const pal_link_header& header = link->header;
    CHECK(said == std::map<std::string, std::uint32_t>{{"`magic`", header.magic},
                                                       {"`endian`", header.endian},
                                                       {"`abi`", header.abi},
                                                       {"`n_bytes`", header.n_bytes},
                                                       {"`table_bytes`", header.table_bytes},
                                                       {"`tick_bytes`", header.tick_bytes},
                                                       {"`n_slots`", header.n_slots},
                                                       {"`n_ticks`", header.n_ticks},
                                                       {"`reserved`", 0}});
    CHECK(sizeof(pal_table_ring::slot[0]) == 54080);
    CHECK(offsetof(pal_table_ring, slot) == 64);
    CHECK(offsetof(pal_state_ring, done) == 64);
    CHECK(offsetof(pal_state_ring, word) == 128);
}

TEST_CASE("the worked hand-over of docs/PROTOCOL.md is what the ring does") {
    const auto ring = std::make_unique<pal_table_ring>();
    for (const Row& row : table_after("Worked example:")) {
        CAPTURE(row[0]);
        if (row[0] == "empty ring") pal_table_ring_init(ring.get());
        if (row[0] == "publish") pal_table_ring_publish(ring.get());
        if (row[0] == "take") REQUIRE(pal_table_ring_take(ring.get()));
        if (row[0] == "replace") REQUIRE(pal_table_ring_replace(ring.get()));
        CHECK(ring->state == std::stoul(row[1], nullptr, 16));
    }
}

TEST_CASE("the worked table of docs/PROTOCOL.md has these bytes and passes its check") {
    const auto table = std::make_unique<pal_table>();
    table->id = 7;
    table->source_hash = 0x1122334455667788U;
    table->tick = 1234;
    table->n_nodes = 5;
    table->spacing_m = 0.0005F;
    table->valid_radius_m = 0.001F;
    table->kappa_per_m = 25.0F;
    table->depth_scale_m = 0.0015F;
    for (const int i : {0, 4, 8}) table->axes[i] = 1.0F;
    for (int i = 0; i < 49; ++i) {
        table->coef[49 + i] = 500.0F;
        table->coef[98 + i] = 1.0F / 0.0015F;
    }
    pal_table_seal(table.get());
    const pal_table_limits limits = pal_table_limits_default();
    CHECK(pal_table_check(table.get(), &limits) == PAL_OK);
    Bytes head(64);
    std::memcpy(head.data(), table.get(), head.size());
    CHECK(head == block("table"));
    CHECK(table->n_bytes == 744);
}

TEST_CASE("the worked tick of docs/PROTOCOL.md has these bytes") {
    pal_tick tick{};
    tick.t_ns = 1234000000;
    tick.tick = 1234;
    tick.faults = PAL_FAULT_FORCE_CLAMP;
    tick.state = PAL_STATE_ENABLED;
    tick.table_id = 7;
    tick.before_id = 6;
    tick.table_age_ticks = 9;
    tick.fade_weight = 0.5F;
    tick.gain = 1.0F;
    tick.homed = 7;
    tick.truth_valid = 1;
    for (int i = 0; i < 3; ++i) {
        tick.encoder_counts[i] = -516;
        tick.motor_counts[i] = 900;
    }
    Bytes head(80);
    std::memcpy(head.data(), &tick, head.size());
    CHECK(head == block("tick"));
}

TEST_CASE("the limits of a table in docs/PROTOCOL.md are the loop's") {
    const pal_table_limits limits = pal_table_limits_default();
    CHECK(limits.stiffness_max_n_per_m == 6000.0F);
    CHECK(limits.stiffness_slope_max_n_per_m2 == 3.0e6F);
    CHECK(limits.surface_slope_max == 4.0F);
}

TEST_CASE("every fault bit of docs/PROTOCOL.md is that of the code") {
    const std::map<std::string, int> code = {
        {"`NOT_FINITE`", PAL_FAULT_NOT_FINITE},       {"`WORKSPACE`", PAL_FAULT_WORKSPACE},
        {"`TABLE_MISSING`", PAL_FAULT_TABLE_MISSING}, {"`TABLE_LEFT`", PAL_FAULT_TABLE_LEFT},
        {"`TABLE_STALE`", PAL_FAULT_TABLE_STALE},     {"`TABLE_DROPPED`", PAL_FAULT_TABLE_DROPPED},
        {"`TABLE_BAD`", PAL_FAULT_TABLE_BAD},         {"`FORCE_CLAMP`", PAL_FAULT_FORCE_CLAMP},
        {"`MOTOR_CLAMP`", PAL_FAULT_MOTOR_CLAMP},     {"`LATE`", PAL_FAULT_LATE},
        {"`DEVICE_LOST`", PAL_FAULT_DEVICE_LOST},     {"`ESTOP`", PAL_FAULT_ESTOP},
        {"`HOST_LOST`", PAL_FAULT_HOST_LOST}};
    std::map<std::string, int> said;
    for (const Row& row : table_after("Faults, bits")) said[row[1]] = 1 << std::stoi(row[0]);
    CHECK(said == code);
}

TEST_CASE("every packet of docs/PROTOCOL.md is made and read alike by the loop and the simulator") {
    int n_replies = 0;
    for (const Row& row : table_after("| direction")) {
        const auto words = three<std::int16_t>(row[1]);
        const auto flags = static_cast<std::uint8_t>(std::stoul(row[2]));
        const Bytes bytes = hex(row[3]);
        CAPTURE(row[0], row[1], row[2]);
        REQUIRE(bytes.size() == PAL_WIRE_BYTES);
        Bytes made(PAL_WIRE_BYTES);
        if (row[0] == "request") {
            const pal_drive drive = {{words[0], words[1], words[2]},
                                     static_cast<std::uint8_t>(flags & 1U),
                                     static_cast<std::uint8_t>(flags & 0xEU)};
            pal_wire_encode(&drive, made.data());
            const pal_falcon_request read = pal_falcon_request_decode(bytes.data());
            CHECK(std::equal(words.begin(), words.end(), read.motor_counts));
            CHECK(read.flags == flags);
        } else {
            ++n_replies;
            pal_falcon_reply_encode(words.data(), flags, made.data());
            pal_sense sense{};
            REQUIRE(pal_wire_decode(bytes.data(), &sense));
            CHECK(std::equal(words.begin(), words.end(), sense.encoder_counts));
            CHECK(sense.buttons == (flags & 15U));
            CHECK(sense.homed == flags >> 4U);
        }
        CHECK(made == bytes);
    }
    CHECK(n_replies == 2);
}

TEST_CASE("every place of docs/PROTOCOL.md has its encoder counts and torques") {
    const std::vector<Row> rows = table_after("| place in the device frame");
    CHECK(rows.size() == 8);
    for (const Row& row : rows) {
        const auto at_m = three<float>(row[0]);
        const auto counts = three<std::int16_t>(row[1]);
        const auto torque = three<double>(row[2]);
        CAPTURE(row[0]);
        float theta_rad[3];
        REQUIRE(pal_delta_inverse(&PAL_DELTA_NF1, at_m.data(), theta_rad));
        float torque_n_m[3];
        const float force_n[3] = {1.0F, 2.0F, 3.0F};
        REQUIRE(pal_delta_torque(&PAL_DELTA_NF1, at_m.data(), force_n, torque_n_m));
        for (std::size_t i = 0; i < 3; ++i) {
            std::int16_t reading = 0;
            REQUIRE(pal_delta_counts(&PAL_DELTA_NF1, theta_rad[i], &reading));
            CHECK(reading == counts[i]);
            CHECK(static_cast<double>(torque_n_m[i]) ==
                  Approx(torque[i]).margin(2e-6));  // float, six digits on the page
        }
    }
}
