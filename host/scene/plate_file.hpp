/// A plate file: a plate of one's own, a push, and what to tell about it. Every key and its default:
/// docs/PLATE_FILE.md.
#pragma once
#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/plate/field.hpp"
#include "host/plate/solver.hpp"

namespace palpate::scene {

using Vec2 = std::array<double, 2>;

/// Places are (x, z) in m from the plate's corner.
struct PlateFile {
    struct Plate {
        Vec2 size_m{};
        std::array<Eigen::Index, 2> nodes{65, 65};  ///< of the finest grid
        double poisson = 0.0;
        double thickness_m = 0.0;  ///< 0: not given
        std::array<plate::Edge, 4> edges{};
        double foundation_n_per_m3 = 0.0;
        Vec2 curvature_per_m{};  ///< along x, along z
    };
    struct Rigidity {
        double value_n_m = 0.0;  ///< 0: in the file
        std::filesystem::path file;
        plate::Sampling sampling = plate::Sampling::linear;
        Eigen::ArrayXXd values_n_m;  ///< of either, all positive; (i, j) corner to corner, 1 x 1: uniform
    };
    struct Load {
        Vec2 at_m{};
        double force_n = 1.0, radius_m = 0.0;
    };
    struct Solver {
        plate::Method method = plate::Method::automatic;
        double tolerance = 1e-3;
        bool extrapolate = true;
    };
    struct Output {
        std::vector<Vec2> points_m;
        std::filesystem::path field, plot;  ///< empty: none
    };

    std::filesystem::path path;  ///< where it was read from
    Plate plate;
    Rigidity rigidity;
    Load load;
    Solver solver;
    Output output;
    std::map<std::string, std::string> places;  ///< of each value that was given; see where()
};

/// Reads and checks a plate file and its rigidity; `overrides` are `section.key=value` as in scenes. Unknown
/// keys are refused with the nearest known one. Throws Error, worded `file:line: what; what would be right`.
[[nodiscard]] PlateFile load_plate(const std::filesystem::path& file,
                                   std::span<const std::string> overrides = {});

/// The same from text, without looking at the rigidity's file: `values_n_m` is empty when there is one.
[[nodiscard]] PlateFile parse_plate(std::string_view toml, const std::filesystem::path& file,
                                    std::span<const std::string> overrides = {});

/// Throws Error `name: row 3, column 5 is -1; ...` for the first value (row by row, counted from 1) that is
/// no rigidity.
void check_rigidity(const Eigen::Ref<const Eigen::ArrayXXd>& values_n_m, const std::string& name);

/// Where a value was given, to begin an error with: "plate.toml:4" or "--set load.at_m".
[[nodiscard]] std::string where(const PlateFile& file, const std::string& name);

/// docs/PLATE_FILE.md, from the table of keys.
[[nodiscard]] std::string plate_markdown();

}  // namespace palpate::scene
