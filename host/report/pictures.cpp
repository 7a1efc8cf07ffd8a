#include "host/report/pictures.hpp"

#include <sys/wait.h>

#include <algorithm>
#include <cstdio>

namespace palpate::report {
namespace {

/// gnuplot's own quoting: a quote inside single quotes is doubled.
std::string quoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
    return out + "'";
}

/// force.png, and curve.png where there is a contact to draw.
std::string script(const std::filesystem::path& directory, const std::string& title, bool contact) {
    const std::string csv = quoted((directory / "ticks.csv").string());
    const std::string force = "(sqrt(column('fx_n')**2 + column('fy_n')**2 + column('fz_n')**2))";
    const std::string over_time =
        "set datafile separator ','\n"
        "set term pngcairo size 1200,700 noenhanced font 'sans,12'\n"
        "set key top right\nset grid lc rgb '#dddddd'\nset border lc rgb '#555555'\n"
        "set title " +
        quoted(title) +
        "\n"
        "set output " +
        quoted((directory / "force.png").string()) +
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
        quoted((directory / "curve.png").string()) +
        "\n"
        "set xlabel 'depth of the tool below the undeformed skin (mm)'\nset cblabel 'stiffness (N/m)'\n"
        "set palette defined (0 '#440154', 0.25 '#3b528b', 0.5 '#21918c', 0.75 '#5ec962', 1 '#fde725')\n"
        "plot " +
        csv + " using (column('depth_m') > 0 ? 1e3*column('depth_m') : 1/0):" + force +
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
    FILE* gnuplot = popen("gnuplot 2>/dev/null", "w");
    if (gnuplot == nullptr)
        return "gnuplot could not be started; install gnuplot-nox for force.png and curve.png";
    const std::string text = script(directory, title, contact);
    std::fwrite(text.data(), 1, text.size(), gnuplot);
    const int status = pclose(gnuplot);
    if (status == 0) return contact ? "" : "the loop saw no contact: there is no curve.png";
    return WIFEXITED(status) && WEXITSTATUS(status) == 127
               ? "gnuplot is not installed; install gnuplot-nox for force.png and curve.png"
               : "gnuplot failed; force.png and curve.png are missing";
}

}  // namespace palpate::report
