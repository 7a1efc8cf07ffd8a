#include "host/scene/plate_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <iterator>
#include <system_error>

#include "host/scene/array_file.hpp"
#include "host/scene/plate_read.hpp"

namespace palpate::scene {
namespace {

using Eigen::Index;

constexpr Index FEWEST_EXTRAPOLATED = 9;
constexpr Range RIGIDITY_N_M = {.above = 0, .at_most = 1e15};
constexpr std::uintmax_t FILE_BYTES_MAX = 1U << 20U;

void check_nodes(const Source& source, const PlateFile& file) {
    if (!file.solver.extrapolate) return;
    for (std::size_t i = 0; i < 2; ++i) {
        const Index n = file.plate.nodes[i];
        if (n >= FEWEST_EXTRAPOLATED && n % 4 == 1) continue;
        const std::string name = "plate.nodes[" + std::to_string(i) + "]";
        const Index below = std::max((n - 1) / 4 * 4 + 1, FEWEST_EXTRAPOLATED);
        const Index above = std::min(n < FEWEST_EXTRAPOLATED ? 13 : below + 4, PLATE_NODES_MAX);
        source.fail("plate.nodes", name + " is " + std::to_string(n) +
                                       "; 4 m + 1 from 9 is expected, such as " + std::to_string(below) +
                                       " or " + std::to_string(above) + ", or solver.extrapolate = false");
    }
}

void check_rigidity_source(const Source& source, const PlateFile& file) {
    const bool value = file.rigidity.value_n_m > 0.0, array = !file.rigidity.file.empty();
    if (!value && !array)
        source.fail("rigidity",
                    "rigidity.value_n_m or rigidity.file is missing; a number in N m, such as 0.03, or a "
                    ".csv or .npy file is expected");
    if (value && array)
        source.fail("rigidity.file", "rigidity.file and rigidity.value_n_m are both given; one is expected");
    if (array && !is_array_name(file.rigidity.file))
        source.fail("rigidity.file", "rigidity.file is \"" + file.rigidity.file.string() +
                                         "\"; a .csv or .npy file is expected");
}

void check_place(const Source& source, const PlateFile& file, const std::string& name, const Vec2& at_m) {
    for (std::size_t i = 0; i < 2; ++i) {
        if (at_m[i] <= file.plate.size_m[i]) continue;
        source.fail(name, name + "[" + std::to_string(i) + "] is " + number_text(at_m[i]) +
                              ", off the plate; at most " + number_text(file.plate.size_m[i]) +
                              " is expected");
    }
}

/// The disc lies inside the plate; on its edge nothing gives way, or nothing holds.
void check_load(const Source& source, const PlateFile& file) {
    const double r_m = file.load.radius_m,
                 half_m = 0.5 * std::min(file.plate.size_m[0], file.plate.size_m[1]);
    if (r_m >= half_m)
        source.fail("load.radius_m", "load.radius_m is " + number_text(r_m) +
                                         ", a disc larger than the plate; below " + number_text(half_m) +
                                         " is expected");
    for (std::size_t i = 0; i < 2; ++i) {
        const double at_m = file.load.at_m[i], length_m = file.plate.size_m[i];
        if (at_m - r_m > 0.0 && at_m + r_m < length_m) continue;
        const std::string disc = r_m > 0.0 ? " with load.radius_m " + number_text(r_m) : "";
        source.fail(source.places.contains("load.at_m") ? "load.at_m" : "load.radius_m",
                    "load.at_m[" + std::to_string(i) + "] is " + number_text(at_m) + disc +
                        ", not inside the plate; between " + number_text(r_m) + " and " +
                        number_text(length_m - r_m) + " is expected");
    }
}

void check_output(const Source& source, const PlateFile& file) {
    const std::filesystem::path& field = file.output.field;
    const std::filesystem::path& plot = file.output.plot;
    if (!field.empty() && !is_array_name(field))
        source.fail("output.field",
                    "output.field is \"" + field.string() + "\"; a .csv or .npy file is expected");
    if (!plot.empty() && plot.extension() != ".png")
        source.fail("output.plot", "output.plot is \"" + plot.string() + "\"; a .png file is expected");
}

void check_whole(const Source& source, const PlateFile& file) {
    check_rigidity_source(source, file);
    check_nodes(source, file);
    const bool curved = file.plate.curvature_per_m[0] != 0.0 || file.plate.curvature_per_m[1] != 0.0;
    if (curved && file.plate.thickness_m == 0.0)
        source.fail(
            "plate.curvature_per_m",
            "plate.curvature_per_m needs plate.thickness_m; a number in m is expected, such as 0.001");
    check_load(source, file);
    for (std::size_t i = 0; i < file.output.points_m.size(); ++i)
        check_place(source, file, "output.points_m[" + std::to_string(i) + "]", file.output.points_m[i]);
    check_output(source, file);
}

std::string read_all(const std::filesystem::path& file) {
    const auto fail = [&](const std::string& why) {
        refuse(file.string(), "cannot be read (" + why + "); a plate file is expected, such as plate.toml");
    };
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) fail("it is a directory");
    errno = 0;
    std::ifstream in(file, std::ios::binary);
    if (!in) fail(std::generic_category().message(errno));
    std::string text(FILE_BYTES_MAX + 1, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(in.gcount()));
    if (text.size() > FILE_BYTES_MAX) fail("it has more than 1 MiB");
    return text;
}

}  // namespace

PlateFile parse_plate(std::string_view toml, const std::filesystem::path& file,
                      std::span<const std::string> overrides) {
    for (const std::string& text : overrides) {
        if (text.find('=') == std::string::npos)
            refuse("--set " + text, "KEY=VALUE is expected, such as rigidity.value_n_m=0.03");
    }
    Source source{.file = file.string(), .overridden = {}, .places = {}};
    const toml::table tree = read_tree(source, toml, overrides);
    PlateFile plate;
    plate.path = file;
    read_plate_tree(source, tree, plate);
    check_whole(source, plate);
    plate.places = std::move(source.places);
    if (plate.rigidity.file.empty())
        plate.rigidity.values_n_m = Eigen::ArrayXXd::Constant(1, 1, plate.rigidity.value_n_m);
    return plate;
}

void check_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& values_n_m, const std::string& name) {
    for (Index i = 0; i < values_n_m.rows(); ++i) {
        for (Index j = 0; j < values_n_m.cols(); ++j) {
            if (RIGIDITY_N_M.holds(values_n_m(i, j))) continue;
            refuse(name, "row " + std::to_string(i + 1) + ", column " + std::to_string(j + 1) + " is " +
                             number_text(values_n_m(i, j)) + "; a rigidity in N m " + RIGIDITY_N_M.words() +
                             " is expected");
        }
    }
}

PlateFile load_plate(const std::filesystem::path& file, std::span<const std::string> overrides) {
    PlateFile plate = parse_plate(read_all(file), file, overrides);
    if (!plate.rigidity.file.empty()) {
        const std::filesystem::path array = file.parent_path() / plate.rigidity.file;
        plate.rigidity.values_n_m = read_array(array, where(plate, "rigidity.file"));
        check_rigidity(plate.rigidity.values_n_m, array.string());
    }
    return plate;
}

std::string where(const PlateFile& file, const std::string& name) {
    std::string place = nearest_place(file.places, name);
    return place.empty() ? file.path.string() + ":1" : place;
}

}  // namespace palpate::scene
