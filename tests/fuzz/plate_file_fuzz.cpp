// A plate file's text and its --set on arbitrary bytes: a plate that can be asked about, or Error on one
// line, and nothing else. Lines `#set KEY=VALUE` at the top are the --set; to TOML they are comments.
#include <cmath>

#include "host/scene/plate_file.hpp"
#include "host/scene/scene.hpp"
#include "tests/fuzz/input.hpp"

namespace {

using fuzz::require;
using palpate::scene::PlateFile;
using palpate::scene::Vec2;

fuzz::Reached accepted("plate accepted"), overridden("with a --set"), rich("with a file, points and a disc");

constexpr std::size_t SETS_MAX = 4;

std::vector<std::string> sets_at_top_of(std::string_view text) {
    constexpr std::string_view MARK = "#set ";
    std::vector<std::string> sets;
    while (text.starts_with(MARK) && sets.size() < SETS_MAX) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        sets.emplace_back(text.substr(MARK.size(), end - MARK.size()));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return sets;
}

bool inside(const PlateFile& file, const Vec2& at_m, double margin_m) {
    bool inside = true;
    for (std::size_t i = 0; i < 2; ++i) {
        inside = inside && at_m[i] >= margin_m && at_m[i] + margin_m <= file.plate.size_m[i];
    }
    return inside;
}

void check(const PlateFile& file) {
    require(file.plate.poisson > -1.0 && file.plate.poisson < 0.5);
    for (std::size_t i = 0; i < 2; ++i) {
        require(file.plate.size_m[i] > 0.0 && std::isfinite(file.plate.size_m[i]));
        require(file.plate.nodes[i] >= 5 && file.plate.nodes[i] <= 4097);
        require(!file.solver.extrapolate || file.plate.nodes[i] % 4 == 1);
    }
    require((file.rigidity.value_n_m > 0.0) == file.rigidity.file.empty());
    require((file.rigidity.values_n_m.size() == 1) == file.rigidity.file.empty());
    require(file.load.force_n > 0.0 && file.load.radius_m >= 0.0 && file.solver.tolerance > 0.0);
    require(inside(file, file.load.at_m, file.load.radius_m));
    for (const Vec2& at_m : file.output.points_m) require(inside(file, at_m, 0.0));
    const Vec2& kappa = file.plate.curvature_per_m;
    require((kappa[0] == 0.0 && kappa[1] == 0.0) || file.plate.thickness_m > 0.0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view text = fuzz::text_of({data, size});
    const std::vector<std::string> sets = sets_at_top_of(text);
    try {
        const PlateFile file = palpate::scene::parse_plate(text, "fuzz.toml", sets);
        check(file);
        accepted.note();
        if (!sets.empty()) overridden.note();
        if (!file.rigidity.file.empty() && !file.output.points_m.empty() && file.load.radius_m > 0.0)
            rich.note();
    } catch (const palpate::scene::Error& error) {
        require(std::string_view(error.what()).find('\n') == std::string_view::npos);
    }
    return 0;
}
