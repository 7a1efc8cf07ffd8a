/// A scene file: what is touched, how, by whom, and what is expected of it. Every key and its default:
/// docs/SCENE.md.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::scene {

using Vec3 = std::array<double, 3>;

/// Bad input, worded `file:line: what, and what would be right`.
struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Throws Error `place: words` as one line, whatever is in the words.
[[noreturn]] void refuse(const std::string& place, std::string words);

struct Object {
    std::filesystem::path points;  ///< as written in the file; see points_file()
    std::string length_unit;       ///< m cm mm um inch; empty only when size_m is given
    double size_m = 0.0;           ///< 0: keep; else the longest side after scaling
    std::string axes = "file";     ///< file | LPS | RAS
    std::string sides = "both";    ///< both | outer
    std::string package;           ///< what to install when points is missing
    std::vector<std::string> columns;
};

enum class Model { shell, plate };

struct Skin {
    Model model = Model::shell;
    double young_pa = 0.0;     ///< required
    double thickness_m = 0.0;  ///< required
    double poisson = 0.45;
    std::string depth_law = "linear";  ///< `auto` is refused by name until the plate's reference brings it
    double foundation_n_per_m3 = 0.0;
};

/// Procedural change of Young's modulus at the points, in order, each times what is there. Object metres
/// after scaling.
struct Change {
    enum class Shape { nodule, gradient } shape = Shape::nodule;
    Vec3 at_m{};  ///< nodule: projected onto the scan
    double radius_m = 0.006,
           edge_m = 0.002;  ///< nodule: full factor inside radius - edge/2, none outside radius + edge/2
    Vec3 from_m{}, to_m{};  ///< gradient
    std::array<double, 2> factor{1.0, 1.0};  ///< gradient: at from and at to; nodule: [0]
};

struct Placement {
    Vec3 focus_m{};               ///< this object point goes to ...
    Vec3 at_m{};                  ///< ... this workspace point (0 = its middle)
    std::string facing = "keep";  ///< keep | operator
    Vec3 turn_deg{};
    double position_scale = 1.0;  ///< object metres per hand metre
    double force_scale = 1.0;     ///< newtons on the hand per newton on the object
};

enum class Law { potential, normal };

struct Touch {
    double tool_radius_m = 0.003;
    Law law = Law::potential;
    double force_max_n = 8.0;
    double ramp_s = 1.0;
};

struct Patch {
    double size_m = 0.016;
    std::string projection = "azimuthal";  ///< azimuthal | gall-peters
    std::string edges = "clamped";
};

struct Solver {
    double tolerance = 1e-3;        ///< of k
    std::uint32_t table_nodes = 0;  ///< 0: from the tolerance
    std::uint32_t delay_ticks = 8;  ///< virtual clock: request to publication
};

struct Device {
    std::string backend = "sim";          ///< sim or usb
    std::string model = "novint-falcon";  ///< or a file with another delta's geometry and gains
    std::string serial;                   ///< usb: which one; empty: the first
    std::string firmware;                 ///< usb: the boot image; empty: where palpate-loop looks itself
};

struct PathPoint {
    double t_s = 0.0;
    Vec3 at_m{};           ///< object metres, projected onto the scan
    double depth_m = 0.0;  ///< of the tool's lowest point below the undeformed skin
};

struct Hand {
    double mass_kg = 0.05, stiffness_n_per_m = 150.0, damping_n_s_per_m = 2.0;
    std::string grip = "light";  ///< none | light | firm | custom
    std::vector<PathPoint> path;
};

struct Run {
    std::string clock = "virtual";  ///< virtual | real
    double duration_s = 0.0;        ///< 0: the path's length
    std::uint64_t seed = 1;
};

/// One line of [expect]: a name of summary.json, an operator, and a number or a word.
struct Expect {
    std::string name;
    std::string op;  ///< "<=" ">=" "=="
    std::optional<double> number;
    std::string word;
};

struct Scene {
    std::filesystem::path file;  ///< where it was read from
    std::string title;
    Object object;
    Skin skin;
    std::vector<Change> changes;
    Placement placement;
    Touch touch;
    Patch patch;
    Solver solver;
    Device device;
    Hand hand;
    Run run;
    std::vector<Expect> expect;
    std::vector<std::string> set;  ///< the --set that were applied, in order
    std::uint64_t hash = 0;        ///< XXH64 of the resolved text; object.points without its folders
    std::map<std::string, std::string> places;  ///< of each value that was given; see where()
};

/// Reads and checks a scene; `overrides` are `section.key=value` as TOML values (a bare word counts as a
/// string). Unknown keys are refused with the nearest known one. Throws Error.
[[nodiscard]] Scene load(const std::filesystem::path& file, std::span<const std::string> overrides = {});

/// The same from text, such as a record's resolved scene; `file` is where object.points is looked for, and
/// for errors.
[[nodiscard]] Scene parse(std::string_view toml, const std::filesystem::path& file,
                          std::span<const std::string> overrides = {});

/// Where a value was given, to begin an error with: "bunny.toml:41" or "--set hand.path". `name` as in
/// "skin.young_pa", "hand.path[3]", "change[1].at_m". When it was not given: the place of what it is in, such
/// as its section's line; line 1 when there is none either.
[[nodiscard]] std::string where(const Scene& scene, const std::string& name);

/// The same when several values are at fault together: the first that a --set gave, as the last thing that
/// was changed; else the first that has a place.
[[nodiscard]] std::string where_among(const Scene& scene, std::span<const std::string> names);

/// Every key, every default, every override: reads back to the same scene and runs by itself (object.points
/// absolute or relative to `directory`).
[[nodiscard]] std::string resolved_toml(const Scene& scene, const std::filesystem::path& directory);

/// Where Debian's packages put scans.
inline constexpr const char* MODELS_DIRECTORY = "/usr/share/glmark2/models";

/// The object's file: relative to the scene, then in MODELS_DIRECTORY. Throws Error, naming
/// `package`.
[[nodiscard]] std::filesystem::path points_file(const Scene& scene);

/// Length of the path or run.duration_s, s.
[[nodiscard]] double duration_s(const Scene& scene);

/// docs/SCENE.md, from the table of keys.
[[nodiscard]] std::string scene_markdown();

}  // namespace palpate::scene
