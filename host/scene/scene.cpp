#include "host/scene/scene.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <iterator>
#include <system_error>

#include "host/scene/read.hpp"
#include "host/scene/resolve.hpp"

namespace palpate::scene {
namespace {

constexpr std::int64_t FORMAT = 1;
constexpr double WAY_MIN_M = 1e-9;  ///< of a gradient

double distance_m(const Vec3& a, const Vec3& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

void read_format(const Source& source, const toml::table& tree) {
    const toml::node* node = tree.get("scene");
    if (node == nullptr) return;
    const auto* format = node->as_integer();
    if (format == nullptr) {
        source.fail("scene", *node,
                    "scene is " + kind(*node) + "; the format's number is expected: scene = 1");
    }
    if (format->get() > FORMAT) {
        source.fail("scene", *node,
                    "scene = " + std::to_string(format->get()) +
                        " is newer than this program reads; scene = 1 is expected");
    }
    if (format->get() != FORMAT) {
        source.fail("scene", *node, "scene is " + std::to_string(format->get()) + "; scene = 1 is expected");
    }
}

/// Names known inside a section, or at the top for "".
std::vector<std::string> names_in(const std::string& section) {
    std::vector<std::string> out;
    for (const Key<Scene>& key : scene_keys()) {
        const std::vector<std::string> parts = split(key.name, '.');
        if (parts.size() == 1 ? section.empty() : parts[0] == section) out.push_back(parts.back());
    }
    if (!section.empty()) return out;
    for (std::string& name : sections()) out.push_back(std::move(name));
    for (const char* name : {"scene", "change", "expect"}) out.emplace_back(name);
    return out;
}

const toml::table* section_of(const Source& source, const toml::table& tree, const std::string& name) {
    const toml::node* node = tree.get(name);
    if (node == nullptr) return nullptr;
    if (!node->is_table()) {
        source.fail(name, *node, name + " is " + kind(*node) + "; a section [" + name + "] is expected");
    }
    return node->as_table();
}

/// Missing keys last: a misspelt key is better named than the one that it should have been.
void read_sections(Source& source, const toml::table& tree, Scene& scene) {
    for (const std::string& name : sections()) {
        if (const toml::table* section = section_of(source, tree, name)) {
            refuse_unknown(source, *section, name + ".", name + ".", names_in(name));
            const std::uint32_t line = section->source().begin.line;  // 0: a --set made it
            if (line != 0) source.places[name] = source.place(name, line);
        }
    }
    const auto find = [&](const Key<Scene>& key) {
        const std::vector<std::string> parts = split(key.name, '.');
        const toml::table* section = parts.size() == 1 ? &tree : section_of(source, tree, parts[0]);
        return section == nullptr ? nullptr : section->get(parts.back());
    };
    for (const Key<Scene>& key : scene_keys()) {
        if (const toml::node* node = find(key)) read_value(source, key.name, *node, key, scene);
    }
    for (const Key<Scene>& key : scene_keys()) {
        if (!key.required || find(key) != nullptr) continue;
        const toml::table* section = section_of(source, tree, split(key.name, '.')[0]);
        fail_missing(source, key.name, section == nullptr ? 1 : section->source().begin.line, key);
    }
}

void check_change(const Source& source, const std::string& name, const Change& change) {
    if (change.shape == Change::Shape::nodule && change.edge_m > 2.0 * change.radius_m) {
        source.fail(name + ".edge_m", name + ".edge_m is " + number_text(change.edge_m) +
                                          "; at most twice radius_m, " + number_text(2.0 * change.radius_m) +
                                          ", is expected");
    }
    if (change.shape == Change::Shape::gradient && !(distance_m(change.from_m, change.to_m) > WAY_MIN_M)) {
        source.fail(name + ".to_m", name + ".to_m is the same point as from_m; another one is expected");
    }
}

void read_changes(Source& source, const toml::table& tree, Scene& scene) {
    const toml::node* node = tree.get("change");
    if (node == nullptr) return;
    if (!node->is_array()) {
        source.fail("change", *node, "change is " + kind(*node) + "; tables [[change]] are expected");
    }
    for (const toml::node& item : *node->as_array()) {
        const std::string name = "change[" + std::to_string(scene.changes.size()) + "]";
        const toml::table* table = item.as_table();
        if (table == nullptr) {
            source.fail(name, item, name + " is " + kind(item) + "; tables [[change]] are expected");
        }
        const Key<Change>& shape = nodule_keys()[0];
        const toml::node* word = table->get(shape.name);
        if (word == nullptr) fail_missing(source, name + ".shape", table->source().begin.line, shape);
        Change change;
        read_value(source, name + ".shape", *word, shape, change);
        const bool nodule = change.shape == Change::Shape::nodule;
        read_table(source, name, "change", *table, nodule ? nodule_keys() : gradient_keys(), change);
        check_change(source, name, change);
        scene.changes.push_back(change);
    }
}

/// "<= 0.03", ">= 1.5", "== none".
void read_expect_one(Source& source, const std::string& key, const toml::node& node, Scene& scene) {
    const std::string name = "expect." + key;
    const std::string form = "; \"<= X\", \">= X\" or \"== X\" is expected, such as \"<= 0.03\"";
    const auto letter = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    };
    if (key.empty() || !std::all_of(key.begin(), key.end(), letter)) {
        source.fail(name, node,
                    name + " cannot be a name of summary.json; letters, digits and _ are expected");
    }
    const auto* text = node.as_string();
    if (text == nullptr) source.fail(name, node, name + " is " + kind(node) + form);
    Expect expect{.name = key, .op = text->get().substr(0, 2), .number = {}, .word = {}};
    const std::size_t begin =
        text->get().find_first_not_of(' ', std::min<std::size_t>(2, text->get().size()));
    const std::string value = begin == std::string::npos ? "" : text->get().substr(begin);
    const bool known = expect.op == "<=" || expect.op == ">=" || expect.op == "==";
    const auto plain = [](char c) { return c > 0x20 && c < 0x7F && c != '"' && c != '\\'; };
    if (!known || value.empty() || !std::all_of(value.begin(), value.end(), plain)) {
        source.fail(name, node, name + " does not read as a condition" + form);
    }
    expect.number = number_from(value);
    if (!expect.number) expect.word = value;
    if (!expect.number && expect.op != "==") {
        source.fail(name, node,
                    name + " compares with \"" + value + "\"; a number is expected after " + expect.op);
    }
    source.places[name] = source.place(name, node.source().begin.line);
    scene.expect.push_back(expect);
}

void read_expect(Source& source, const toml::table& tree, Scene& scene) {
    const toml::table* table = section_of(source, tree, "expect");
    if (table == nullptr) return;
    for (const auto& [key, node] : *table) read_expect_one(source, std::string(key.str()), node, scene);
}

void check_object(const Source& source, const Object& object) {
    if (object.points.empty()) {
        source.fail("object.points", "object.points is empty; a file is expected, such as \"bunny.obj\"");
    }
    std::string extension = object.points.extension().string();
    for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if (!object.columns.empty() && (extension == ".ply" || extension == ".obj")) {
        source.fail(
            "object.columns",
            "object.columns is for XYZ and CSV; a PLY or OBJ file names its own columns: leave it out");
    }
    if (object.length_unit.empty() && object.size_m == 0.0) {
        source.fail("object", "object.length_unit is missing; m, cm, mm, um or inch is expected, or size_m");
    }
}

void check_path(const Source& source, const std::vector<PathPoint>& path) {
    for (std::size_t i = 1; i < path.size(); ++i) {
        if (path[i].t_s > path[i - 1].t_s) continue;
        const std::string name = "hand.path[" + std::to_string(i) + "].t_s";
        source.fail(name, name + " is " + number_text(path[i].t_s) + "; more than the " +
                              number_text(path[i - 1].t_s) + " before it is expected: times increase");
    }
}

void check_device(const Source& source, const Scene& scene) {
    const Device& device = scene.device;
    if (device.backend == "usb") {
        if (scene.run.clock == "real") return;
        source.fail("device.backend", "device.backend is usb and run.clock is " + scene.run.clock +
                                          "; run.clock = \"real\" is expected: no person moves in lockstep");
    }
    const auto only_usb = [&](const std::string& name, bool given) {
        if (given) source.fail(name, name + " is given; device.backend = \"usb\" is expected with it");
    };
    only_usb("device.model", device.model != Device{}.model);
    only_usb("device.serial", !device.serial.empty());
    only_usb("device.firmware", !device.firmware.empty());
}

void check_whole(const Source& source, const Scene& scene) {
    check_object(source, scene.object);
    check_path(source, scene.hand.path);
    check_device(source, scene);
    const std::uint32_t nodes = scene.solver.table_nodes;
    if (nodes != 0 && (nodes < 5 || nodes > 65 || nodes % 2 == 0)) {
        source.fail("solver.table_nodes", "solver.table_nodes is " + std::to_string(nodes) +
                                              "; 0 or an odd number from 5 to 65 is expected");
    }
}

std::string read_all(const std::filesystem::path& file) {
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) {
        refuse(file.string(), "is a directory; a scene file is expected, such as bunny.toml");
    }
    errno = 0;
    std::ifstream in(file, std::ios::binary);
    if (!in) {
        refuse(file.string(), "cannot be read (" + std::generic_category().message(errno) +
                                  "); a scene file is expected, such as bunny.toml");
    }
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

Scene load(const std::filesystem::path& file, std::span<const std::string> overrides) {
    return parse(read_all(file), file, overrides);
}

Scene parse(std::string_view toml, const std::filesystem::path& file,
            std::span<const std::string> overrides) {
    Source source{.file = file.string(), .overridden = {}, .places = {}};
    const toml::table tree = read_tree(source, toml, overrides);
    read_format(source, tree);
    refuse_unknown(source, tree, "", "", names_in(""));
    Scene scene;
    scene.file = file;
    read_sections(source, tree, scene);
    read_changes(source, tree, scene);
    read_expect(source, tree, scene);
    check_whole(source, scene);
    scene.set.assign(overrides.begin(), overrides.end());
    scene.places = std::move(source.places);
    scene.hash = hash_of(scene);
    return scene;
}

std::string where(const Scene& scene, const std::string& name) {
    return where_among(scene, std::array{name});
}

std::string where_among(const Scene& scene, std::span<const std::string> names) {
    std::string first;
    for (const std::string& name : names) {
        std::string place = nearest_place(scene.places, name);
        if (place.starts_with("--set ")) return place;
        if (first.empty()) first = place;
    }
    return first.empty() ? scene.file.string() + ":1" : first;
}

std::filesystem::path points_file(const Scene& scene) {
    const std::filesystem::path& points = scene.object.points;
    std::filesystem::path here = scene.file.parent_path() / points;  // an absolute one stays itself
    std::filesystem::path there = std::filesystem::path(MODELS_DIRECTORY) / points;
    std::error_code error;
    if (std::filesystem::is_regular_file(here, error)) return here;
    if (points.is_relative() && std::filesystem::is_regular_file(there, error)) return there;
    const std::string places =
        points.is_absolute() ? "not found" : std::string("not found here or in ") + MODELS_DIRECTORY;
    const std::string& package = scene.object.package;
    refuse(where(scene, "object.points"), points.string() + ": " + places +
                                              (package.empty() ? "; another file is expected in object.points"
                                                               : "; install the package " + package));
}

double duration_s(const Scene& scene) {
    if (scene.run.duration_s > 0.0) return scene.run.duration_s;
    return scene.hand.path.empty() ? 0.0 : scene.hand.path.back().t_s;
}

}  // namespace palpate::scene
