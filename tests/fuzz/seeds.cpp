// pal_fuzz_seeds FOLDER: writes FOLDER/TARGET/NAME, valid inputs for the targets whose format is binary, from
// the product's own writers, and the scenes of the product. The same bytes every time. Text seeds lie in
// corpus/.
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>

#include "common/link.h"
#include "firmware/falcon/wire.h"
#include "host/record/record.hpp"
#include "host/scene/array_file.hpp"
#include "host/scene/scene.hpp"
#include "sim/falcon/codec.h"
#include "tests/fuzz/good_table.hpp"

namespace {

namespace fs = std::filesystem;
using namespace palpate;

fs::path folder;

void write(const char* target, const std::string& name, const std::string& bytes) {
    fs::create_directories(folder / target);
    std::ofstream out(folder / target / name, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!out.flush()) throw std::runtime_error((folder / target / name).string() + ": cannot be written");
}

std::string contents(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw std::runtime_error(file.string() + ": cannot be read");
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// The bytes of values, one after the other.
template <class... Values>
std::string packed(const Values&... values) {
    std::string out;
    (out.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
    return out;
}

std::string repeated(const std::string& bytes, std::size_t n) {
    std::string out;
    for (std::size_t i = 0; i < n; ++i) out += bytes;
    return out;
}

std::unique_ptr<pal_table> sealed_table(std::uint32_t n_nodes, std::uint64_t id) {
    auto table = std::make_unique<pal_table>();
    fuzz::fill_good(*table, n_nodes, id);
    pal_table_seal(table.get());
    return table;
}

void tables() {
    const std::string at = packed(std::array{0.0F, 0.0F, -0.002F});
    for (const std::uint32_t n_nodes : {5U, 7U}) {
        const auto table = sealed_table(n_nodes, 1);
        const std::string bytes(reinterpret_cast<const char*>(table.get()), table->n_bytes);
        write("table", "raw-" + std::to_string(n_nodes), '\0' + at + bytes);
        write("table", "mended-" + std::to_string(n_nodes), '\1' + at + bytes);
    }
    const auto depth_law = packed(std::uint16_t{offsetof(pal_table, psi) / 4 + 3}, 0.5F);
    const auto normal_law =
        packed(std::uint16_t{offsetof(pal_table, law) / 4}, std::uint32_t{PAL_LAW_NORMAL});
    const auto dip = packed(std::uint16_t{offsetof(pal_table, psi) / 4}, -20.0F,
                            std::uint16_t{offsetof(pal_table, psi) / 4 + 1}, 95.0F);  // between two samples
    write("table", "dip", '\2' + at + dip);
    write("table", "patched", '\2' + at + depth_law + normal_law);
}

/// A binary PLY: three points, one triangle, a list to skip.
std::string binary_ply(bool big_endian) {
    const auto in_order = [&](std::string bytes) {
        return big_endian ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
    };
    std::string out = std::string("ply\nformat binary_") + (big_endian ? "big" : "little") +
                      "_endian 1.0\nelement vertex 3\nproperty float x\nproperty double y\nproperty short z\n"
                      "property list uchar ushort tags\nelement face 1\n"
                      "property list uchar int vertex_indices\nend_header\n";
    for (int i = 0; i < 3; ++i) {
        out += in_order(packed(0.5F * static_cast<float>(i))) + in_order(packed(1.5 * i * i)) +
               in_order(packed(static_cast<std::int16_t>(7 - i)));
        out += packed(std::uint8_t{1}) + in_order(packed(std::uint16_t{9}));
    }
    out += packed(std::uint8_t{3});
    for (const std::int32_t corner : {0, 1, 2}) out += in_order(packed(corner));
    return out;
}

void records() {
    record::Record record;
    record.header = {{"schema", "palpate.record/1"}, {"scene", "scene = 1"}};
    const fs::path file = folder / "seed.palrec";
    const auto add = [&](const std::string& name) {
        record::write(file, record);
        const std::string bytes = contents(file);
        for (char mend = 0; mend < 4; ++mend)
            write("record", name + "-" + std::to_string(int{mend}), mend + bytes);
    };
    add("empty");
    for (std::uint32_t i = 0; i < 3; ++i) {
        pal_tick tick{};
        tick.tick = i;
        tick.path_tick = i;
        tick.faults = 1U << i;
        tick.force_n[2] = 0.25F * static_cast<float>(i);
        record.ticks.push_back(tick);
    }
    add("ticks");
    for (const std::uint64_t id : {1U, 2U}) record.tables[id] = record::table_bytes(*sealed_table(5, id));
    add("tables");
    fs::remove(file);
}

void segments() {
    const auto link = std::make_unique<pal_link>();
    pal_link_init(link.get(), 1);
    const std::string head = packed(link->header);
    write("link", "head", '\0' + head);
    write("link", "rings", '\1' + packed(std::uint16_t{1}, std::uint8_t{0}, std::uint32_t{0x2E4}));
    for (char size = 0; size < 4; ++size) {
        write("link", "attach-" + std::to_string(int{size}), std::string{'\2', size} + head);
    }
}

void sessions() {
    const auto near = [](int n_ticks) {
        return packed(static_cast<std::uint8_t>(8 * n_ticks - 8), '\1', '\2', '\3');
    };
    const auto publish = [](std::uint8_t n_patches) { return packed(std::uint8_t{5}, n_patches); };
    const auto silent = [](int n_ticks) { return packed(static_cast<std::uint8_t>(8 * n_ticks - 4)); };
    const auto host = [](std::uint8_t word, std::uint32_t value) {
        return packed(std::uint8_t{6}, word, value);
    };
    write("session", "press", near(20));
    write("session", "fade", near(20) + publish(0) + near(10) + publish(0) + near(20));
    write("session", "bad-table", near(20) + publish(200) + near(4) + publish(0) + near(30));
    write("session", "late", near(20) + silent(8) + near(4) + silent(24) + near(30));
    write("session", "stop", near(20) + host(1, 1) + near(4) + host(0, 0) + near(4));
    write("session", "pause", near(20) + host(0, 0) + near(4) + host(0, 1) + near(20));
    write("session", "stale", repeated(near(25), 12));
    write("session", "lost-host", repeated(near(31), 17));
    const std::int16_t far_counts[3] = {-32768, 32767, 0};
    write("session", "far", near(20) + packed(std::uint8_t{2}, far_counts, std::uint8_t{0x70}) + near(20));
}

void packets() {
    const pal_drive drive{.motor_counts = {-4095, 4095, 1}, .homing = 1, .leds = 2};
    std::uint8_t request[PAL_WIRE_BYTES];
    pal_wire_encode(&drive, request);
    const std::int16_t counts[3] = {-1, 1234, -32768};
    std::uint8_t reply[PAL_FALCON_PACKET_BYTES];
    pal_falcon_reply_encode(counts, 0x7F, reply);
    write("wire", "request", packed(request));
    write("wire", "reply", packed(reply));
    write("wire", "cut", packed(reply).substr(0, 9) + packed(request, reply));
}

/// The worked examples of docs/MODBUS.md, and one of each function.
void frames() {
    using Frame = std::array<std::uint8_t, 12>;
    write("rig", "read-force", packed(Frame{0, 1, 0, 0, 0, 6, 1, 4, 0, 6, 0, 2}));
    write("rig", "read-map", packed(Frame{0, 1, 0, 0, 0, 6, 1, 4, 0, 0, 0, 26}));
    write("rig", "read-coils", packed(Frame{0, 1, 0, 0, 0, 6, 1, 1, 0, 0, 0, 2}));
    write("rig", "estop", packed(Frame{0, 2, 0, 0, 0, 6, 1, 5, 0, 0, 0xFF, 0}));
    write("rig", "two",
          packed(Frame{0, 2, 0, 0, 0, 6, 1, 5, 0, 1, 0, 0}, Frame{0, 3, 0, 0, 0, 6, 1, 4, 0, 0, 0, 1}));
    write("rig", "coils", packed(std::array<std::uint8_t, 14>{0, 4, 0, 0, 0, 8, 1, 15, 0, 0, 0, 2, 1, 3}));
    write("rig", "unknown", packed(Frame{0, 5, 0, 0, 0, 6, 1, 3, 0, 0, 0, 1}));
    write("rig", "address", "127.0.0.1:1502");
    write("rig", "localhost", "localhost:0");
}

/// The scenes of the product, and what each resolves to: every key.
void scenes() {
    for (const char* name : {"bunny", "ellipsoid"}) {
        const std::string text = contents(fs::path(PAL_SCENES) / (std::string(name) + ".toml"));
        write("scene", name, text);
        write("scene", std::string(name) + "-set",
              "#set skin.young_pa=1e5\n#set hand.path.1.depth_m=0.001\n" + text);
        const scene::Scene scene = scene::parse(text, std::string(name) + ".toml");
        write("scene", std::string(name) + "-resolved", scene::resolved_toml(scene, "out"));
    }
}

/// The plates of the product.
void plates() {
    for (const auto& entry : fs::directory_iterator(fs::path(PAL_SCENES) / "plates")) {
        const char* target = entry.path().extension() == ".toml" ? "plate_file" : "array";
        write(target, entry.path().filename().string(), contents(entry.path()));
    }
}

/// An NPY as the product writes it, and one in each other way that is read.
void arrays() {
    Eigen::ArrayXXd values(2, 3);
    values << 1.5, -2.0, 3.0, 4.0, 5.0, 6.0e9;
    const std::string own = scene::npy_bytes(values);
    write("array", "own.npy", own);
    const auto changed = [&](const std::string& what, const std::string& with) {
        std::string bytes = own;
        return bytes.replace(bytes.find(what), what.size(), with);
    };
    write("array", "fortran.npy", changed("False,", "True ,"));
    write("array", "big.npy", changed("<f8", ">f8"));
    write("array", "integers.npy", changed("<f8", "<i8"));
    const std::string half = own.substr(0, own.size() - 24);
    write("array", "single.npy", std::string(half).replace(half.find("<f8"), 3, "<f4"));
    write("array", "whole.npy", std::string(half).replace(half.find("<f8"), 3, ">i4"));
    const std::string two = changed(std::string("\1\0", 2), std::string("\2\0", 2));
    write("array", "two.npy", two.substr(0, 10) + std::string(2, '\0') + two.substr(10));
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    try {
        folder = argv[1];
        fs::remove_all(folder);
        fs::create_directories(folder);
        tables();
        records();
        segments();
        sessions();
        packets();
        frames();
        scenes();
        plates();
        arrays();
        for (const bool big_endian : {false, true}) {
            write("cloud", big_endian ? "big.ply" : "little.ply", binary_ply(big_endian));
        }
    } catch (const std::exception& error) {
        std::cerr << "pal_fuzz_seeds: " << error.what() << '\n';
        return 1;
    }
    return 0;
}
