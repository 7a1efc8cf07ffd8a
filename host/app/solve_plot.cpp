#include "host/app/solve_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <system_error>

#include "host/plate/field.hpp"
#include "host/report/gnuplot.hpp"
#include "host/scene/keys.hpp"

namespace palpate::app {
namespace {

using Eigen::Index;
using scene::number_text;

constexpr Index PIXELS = 480;                                            ///< of the map's longer side
constexpr double WIDTH = 1000.0, SIDES = 230.0, TOP_AND_BOTTOM = 130.0;  ///< of the picture, pixels
constexpr double HEIGHT_LEAST = 360.0, HEIGHT_MOST = 1600.0;

/// A unit in which `size` is a number from 1 to 1000.
struct Unit {
    double times = 1.0;
    const char* name = "m";
    explicit Unit(double size_m) {
        struct Step {
            double times;
            const char* name;
        };
        constexpr std::array STEPS{Step{1e3, "mm"}, Step{1e6, "µm"}, Step{1e9, "nm"}};
        for (const Step& step : STEPS) {
            if (!(size_m * times < 1.0)) break;
            times = step.times;
            name = step.name;
        }
    }
};

/// 1, 2 or 5 times a power of ten, so that about ten steps make `range`.
double even_step(double range) {
    const double about = range / 10.0, power = std::pow(10.0, std::floor(std::log10(about)));
    for (const double digit : {1.0, 2.0, 5.0}) {
        if (digit * power >= 0.999 * about) return digit * power;
    }
    return 10.0 * power;
}

/// Numbers in the units that are shown.
struct Picture {
    Unit length, depth;
    double size_x, size_z, most, least, step;  ///< step: between contours
    std::string load_x, load_z;

    Picture(const scene::PlateFile& file, const Eigen::Ref<const Eigen::ArrayXXd>& deflection_m)
        : length(std::max(file.plate.size_m[0], file.plate.size_m[1])),
          depth(deflection_m.abs().maxCoeff()),
          size_x(length.times * file.plate.size_m[0]),
          size_z(length.times * file.plate.size_m[1]),
          most(depth.times * std::max(deflection_m.maxCoeff(), 0.0)),
          least(depth.times * std::min(deflection_m.minCoeff(), 0.0)),
          step(even_step(std::max(most - least, 1e-300))),
          load_x(number_text(length.times * file.load.at_m[0])),
          load_z(number_text(length.times * file.load.at_m[1])) {}
};

/// Rows along z of numbers along x, as gnuplot's matrix.
std::string block(const char* name, const Eigen::Ref<const Eigen::ArrayXXd>& values) {
    std::string out = std::string(name) + " << EOD\n";
    for (Index j = 0; j < values.cols(); ++j) {
        for (Index i = 0; i < values.rows(); ++i) {
            std::array<char, 32> text{};
            std::snprintf(text.data(), text.size(), "%.6g ", values(i, j));
            out += text.data();
        }
        out += "\n";
    }
    return out + "EOD\n";
}

/// The map's pixels, each the deflection at its middle.
Eigen::ArrayXXd pixels(const scene::PlateFile& file, const Eigen::Ref<const Eigen::ArrayXXd>& values) {
    const Eigen::Vector2d size_m(file.plate.size_m[0], file.plate.size_m[1]);
    const plate::Field field = plate::sampled(values, size_m);
    const double pixel_m = size_m.maxCoeff() / static_cast<double>(PIXELS);
    const auto count = [&](double length_m) { return std::max<Index>(std::lround(length_m / pixel_m), 2); };
    Eigen::ArrayXXd map(count(size_m.x()), count(size_m.y()));
    for (Index j = 0; j < map.cols(); ++j) {
        for (Index i = 0; i < map.rows(); ++i)
            map(i, j) = field(size_m.x() * (static_cast<double>(i) + 0.5) / static_cast<double>(map.rows()),
                              size_m.y() * (static_cast<double>(j) + 0.5) / static_cast<double>(map.cols()));
    }
    return map;
}

/// "matrix using ((column + offset) * step)...": a matrix of n_x x n_z steps over the plate.
std::string onto_plate(const Picture& picture, Index n_x, Index n_z, const char* offset) {
    const auto step = [](double length, Index n) { return number_text(length / static_cast<double>(n)); };
    return std::string(" matrix using (($1+") + offset + ")*" + step(picture.size_x, n_x) + "):(($2+" +
           offset + ")*" + step(picture.size_z, n_z) + "):3";
}

std::string contours(const Picture& picture, Index n_x, Index n_z) {
    // Not at 0, where a plate that hardly lifts would get a ragged one.
    const double first = picture.least <= -picture.step
                             ? std::floor(picture.least / picture.step) * picture.step
                             : picture.step;
    return "set contour base\nunset surface\nset cntrparam levels incremental " + number_text(first) + "," +
           number_text(picture.step) + "," + number_text(picture.most) +
           "\nset table $contours\nsplot $nodes" + onto_plate(picture, n_x - 1, n_z - 1, "0") +
           "\nunset table\nunset contour\nset surface\n";
}

std::string axes(const Picture& picture, const std::string& title) {
    const auto to = [](double low, double high) {
        return number_text(low) + ":" + number_text(high) + "]\n";
    };
    return "set key off\nset size ratio -1\nset tics out nomirror\nset xrange [" + to(0.0, picture.size_x) +
           "set yrange [" + to(0.0, picture.size_z) + "set xlabel 'x (" + picture.length.name +
           ")'\nset ylabel 'z (" + picture.length.name + ")'\nset cblabel 'deflection (" +
           picture.depth.name + "), a contour at each mark'\nset cbtics " + number_text(picture.step) +
           "\nset cbrange [" + to(picture.least, std::max(picture.most, picture.least + picture.step)) +
           report::GNUPLOT_PALETTE + "set title " + report::gnuplot_quoted(title) + "\n";
}

/// A circle for the load's disc.
std::string disc(const Picture& picture, const scene::PlateFile& file) {
    if (file.load.radius_m == 0.0) return "";
    return "set object circle at " + picture.load_x + "," + picture.load_z + " size " +
           number_text(picture.length.times * file.load.radius_m) +
           " front fillstyle empty border lc rgb '#000000' lw 2\n";
}

std::string script(const std::string& png, const scene::PlateFile& file,
                   const Eigen::Ref<const Eigen::ArrayXXd>& deflection_m) {
    const Picture picture(file, deflection_m);
    const Eigen::ArrayXXd map = picture.depth.times * pixels(file, deflection_m);
    const double height = std::clamp((WIDTH - SIDES) * picture.size_z / picture.size_x + TOP_AND_BOTTOM,
                                     HEIGHT_LEAST, HEIGHT_MOST);
    const std::string title = file.path.filename().string() + ": deflection under " +
                              number_text(file.load.force_n) + " N at the cross";
    return block("$map", map) + block("$nodes", picture.depth.times * deflection_m) + "$load << EOD\n" +
           picture.load_x + " " + picture.load_z + "\nEOD\nset term pngcairo size 1000," +
           std::to_string(std::lround(height)) + " noenhanced font 'sans,13'\nset output " +
           report::gnuplot_quoted(png) + "\n" + contours(picture, deflection_m.rows(), deflection_m.cols()) +
           axes(picture, title) + disc(picture, file) + "plot $map" +
           onto_plate(picture, map.rows(), map.cols(), "0.5") +
           " with image, $contours using 1:2 with lines lw 1 lc rgb '#ffffff', "
           "$load using 1:2 with points pt 1 ps 2.6 lw 5 lc rgb '#ffffff', "
           "$load using 1:2 with points pt 1 ps 2.2 lw 2 lc rgb '#000000'\n";
}

}  // namespace

std::string draw_deflection(const std::filesystem::path& png, const scene::PlateFile& file,
                            const Eigen::Ref<const Eigen::ArrayXXd>& deflection_m) {
    const std::filesystem::path aside = png.string() + ".partial";
    std::error_code error;
    std::string words =
        report::run_gnuplot(script(aside.string(), file, deflection_m), png.filename().string());
    if (words.empty() && std::filesystem::file_size(aside, error) == 0) words = "gnuplot drew nothing";
    if (words.empty() && !error) std::filesystem::rename(aside, png, error);
    if (words.empty() && error) words = png.string() + " cannot be written (" + error.message() + ")";
    if (!words.empty()) std::filesystem::remove(aside, error);
    return words;
}

}  // namespace palpate::app
