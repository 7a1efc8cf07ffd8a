#include "host/report/pictures.hpp"

#include <algorithm>

#include "host/report/gnuplot.hpp"

namespace palpate::report {
namespace {

/// force.png, and curve.png where there is a contact to draw.
std::string script(const std::filesystem::path& directory, const std::string& title, bool contact) {
    const std::string csv = gnuplot_quoted((directory / "ticks.csv").string());
    const std::string force = "(sqrt(column('fx_n')**2 + column('fy_n')**2 + column('fz_n')**2))";
    const std::string over_time =
        "set datafile separator ','\n"
        "set term pngcairo size 1200,700 noenhanced font 'sans,12'\n"
        "set key top right\nset grid lc rgb '#dddddd'\nset border lc rgb '#555555'\n"
        "set title " +
        gnuplot_quoted(title) +
        "\n"
        "set output " +
        gnuplot_quoted((directory / "force.png").string()) +
        "\n"
        "set xlabel 'time (s)'\nset ylabel 'force (N)'\nset y2label 'depth (mm)'\n"
        "set ytics nomirror\nset y2tics\nset autoscale xfixmax\nset xrange [0:]\nset yrange [0:]\nset "
        "y2range [0:]\n"
        "plot " +
        csv + " using (column('t_s')):" + force +
        " with lines lw 2 lc rgb '#3b528b' title 'force', '' using "
        "(column('t_s')):(column('depth_m') > 0 ? 1e3*column('depth_m') : 0) axes x1y2 with lines lw 2 lc "
        "rgb '#5ec962' "
        "title 'depth'\n";
    const std::string over_depth =
        "unset y2tics\nunset y2label\nset ytics mirror\nset xrange [0:*]\nset key off\n"
        "set output " +
        gnuplot_quoted((directory / "curve.png").string()) +
        "\n"
        "set xlabel 'depth of the tool below the undeformed skin (mm)'\nset cblabel 'stiffness (N/m)'\n" +
        GNUPLOT_PALETTE + "plot " + csv +
        " using (column('depth_m') > 0 ? 1e3*column('depth_m') : 1/0):" + force +
        ":(column('depth_m') > 0 ? column('k_n_per_m') : 1/0) with points pt 7 ps 0.3 palette\n";
    return over_time + (contact ? over_depth : "");
}

}  // namespace

std::string draw_pictures(const std::filesystem::path& directory, const std::string& title,
                          std::span<const pal_tick> ticks) {
    const auto any = [&](auto&& is) { return std::any_of(ticks.begin(), ticks.end(), is); };
    if (!any([](const pal_tick& tick) { return tick.path_tick > 0; }))
        return "the path did not begin: there is no force.png and no curve.png";
    const bool contact = any([](const pal_tick& tick) { return tick.depth_m > 0.0F; });
    std::string words = run_gnuplot(script(directory, title, contact), "force.png and curve.png");
    if (!words.empty()) return words;
    return contact ? "" : "the loop saw no contact: there is no curve.png";
}

}  // namespace palpate::report
