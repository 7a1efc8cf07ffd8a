#include "host/scene/resolve.hpp"

#include <xxhash.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace palpate::scene {
namespace {

std::string word(const char* choices, std::size_t index) {
    return toml_string(split(choices, '|')[index]);
}

std::string toml_of(double value) {
    std::string text = number_text(value);
    return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

template <std::size_t N>
std::string toml_of(const std::array<double, N>& values) {
    std::string out;
    for (const double value : values) out += (out.empty() ? "[" : ", ") + toml_of(value);
    return out + "]";
}

/// The value of a key as TOML; empty when there is nothing to write.
template <class Owner>
struct Written {
    const Key<Owner>& key;
    std::string operator()(const double& value) const { return toml_of(value); }
    std::string operator()(const std::uint32_t& value) const { return std::to_string(value); }
    std::string operator()(const std::uint64_t& value) const { return std::to_string(value); }
    std::string operator()(const std::string& value) const {
        return value.empty() && *key.choices != '\0' ? "" : toml_string(value);
    }
    std::string operator()(const std::filesystem::path& value) const { return toml_string(value.string()); }
    std::string operator()(const Vec3& value) const { return toml_of(value); }
    std::string operator()(const std::array<double, 2>& value) const { return toml_of(value); }
    std::string operator()(const Model& value) const {
        return word(key.choices, static_cast<std::size_t>(value));
    }
    std::string operator()(const Law& value) const {
        return word(key.choices, static_cast<std::size_t>(value));
    }
    std::string operator()(const Change::Shape& value) const {
        return word(key.choices, static_cast<std::size_t>(value));
    }
    std::string operator()(const std::vector<std::string>& value) const {
        std::string out = "[";
        for (const std::string& item : value) out += (out.size() == 1 ? "" : ", ") + toml_string(item);
        return out + "]";
    }
    std::string operator()(const std::vector<PathPoint>& value) const;
    std::string operator()(const Hand& value) const;
};

template <class Owner>
std::string inline_table(std::span<const Key<Owner>> keys, const Owner& owner) {
    std::string out;
    for (const Key<Owner>& key : keys) {
        out += (out.empty() ? "{ " : ", ") + std::string(key.name) + " = " + value_text(key, owner);
    }
    return out + " }";
}

template <class Owner>
std::string Written<Owner>::operator()(const std::vector<PathPoint>& value) const {
    std::string out = "[";
    for (const PathPoint& point : value) out += "\n  " + inline_table(path_keys(), point) + ",";
    return out + (value.empty() ? "]" : "\n]");
}

template <class Owner>
std::string Written<Owner>::operator()(const Hand& value) const {
    return value.grip == "custom" ? inline_table(grip_keys(), value) : toml_string(value.grip);
}

std::string changes_text(const Scene& scene) {
    std::string out;
    for (const Change& change : scene.changes) {
        out += "\n[[change]]\n";
        for (const Key<Change>& key :
             change.shape == Change::Shape::nodule ? nodule_keys() : gradient_keys()) {
            out += std::string(key.name) + " = " + value_text(key, change) + "\n";
        }
    }
    return out;
}

std::string expect_text(const Scene& scene) {
    std::string out = "\n[expect]\n";
    for (const Expect& expect : scene.expect) {
        const std::string value = expect.number ? number_text(*expect.number) : expect.word;
        out += expect.name + " = " + toml_string(expect.op + " " + value) + "\n";
    }
    return out;
}

/// As a comment's line: whatever is in it, it stays a comment.
std::string comment(std::string text) {
    for (char& c : text) c = (c >= 0 && c < 0x20) || c == 0x7F ? ' ' : c;
    return "# " + text + "\n";
}

}  // namespace

template <class Owner>
std::string value_text(const Key<Owner>& key, const Owner& owner) {
    Owner copy = owner;  // fields are reached through functions that could write
    return std::visit([&](auto field) { return Written<Owner>{key}(field(copy)); }, key.field);
}

template std::string value_text(const Key<Scene>&, const Scene&);
template std::string value_text(const Key<Change>&, const Change&);
template std::string value_text(const Key<PathPoint>&, const PathPoint&);
template std::string value_text(const Key<Hand>&, const Hand&);

std::string toml_string(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return out + "\"";
}

std::optional<double> number_from(std::string_view text) {
    double value = 0.0;
    const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
    if (end.ec != std::errc{} || end.ptr != text.data() + text.size() || !std::isfinite(value)) return {};
    return value;
}

std::string text_of(const Scene& scene, const std::string& points) {
    Scene copy = scene;
    copy.object.points = points;
    std::string out = "scene = 1\n";
    std::string section;
    for (const Key<Scene>& key : scene_keys()) {
        const std::vector<std::string> parts = split(key.name, '.');
        if (parts.size() == 2 && parts[0] != section) {
            if (section == "skin") out += changes_text(copy);
            section = parts[0];
            out += "\n[" + section + "]\n";
        }
        const std::string value = value_text(key, copy);
        if (!value.empty()) out += parts.back() + " = " + value + "\n";
    }
    return out + expect_text(copy);
}

std::uint64_t hash_of(const Scene& scene) {
    const std::string text = text_of(scene, scene.object.points.filename().string());
    return XXH64(text.data(), text.size(), 0);
}

std::string resolved_toml(const Scene& scene, const std::filesystem::path& directory) {
    std::string points = scene.object.points.string();
    std::error_code error;
    const std::filesystem::path beside = scene.file.parent_path() / scene.object.points;
    if (std::filesystem::is_regular_file(beside, error)) {
        points = std::filesystem::absolute(beside).lexically_normal().string();
    } else if (std::filesystem::exists(directory / scene.object.points, error)) {
        points = std::filesystem::absolute(points_file(scene)).string();  // not the namesake in `directory`
    }
    std::string out =
        comment(scene.file.filename().string() + " with every key and default; runs again by itself.");
    for (const std::string& set : scene.set) out += comment("--set " + set);
    return out + text_of(scene, points);
}

}  // namespace palpate::scene
