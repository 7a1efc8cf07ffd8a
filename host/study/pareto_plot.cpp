#include <algorithm>
#include <array>
#include <map>

#include "host/report/gnuplot.hpp"
#include "host/study/plate_results.hpp"
#include "host/study/plate_tables.hpp"
#include "host/study/text.hpp"

namespace palpate::study {
namespace {

constexpr double FLOOR = 1e-12;  ///< errors below it are drawn on it

struct Mark {
    const char* method;
    int point;
    const char* colour;
};
/// Kin have one colour and differ in shape.
constexpr std::array MARKS{
    Mark{"cholesky", 7, "#31688e"},
    Mark{"cholesky-extrapolated", 5, "#31688e"},
    Mark{"multigrid-1e-3", 8, "#35b779"},
    Mark{"multigrid-1e-6", 9, "#35b779"},
    Mark{"eigen", 6, "#777777"},
    Mark{"cholmod-simplicial", 12, "#777777"},
    Mark{"cholmod-supernodal", 13, "#777777"},
    Mark{"damped-jacobi", 11, "#d95f02"},
    Mark{"damped-jacobi-change-1e-3", 10, "#d95f02"},
    Mark{"damped-jacobi-change-1e-6", 4, "#d95f02"},
    Mark{"eq7", 2, "#b5002e"},
    Mark{"closed-form", 3, "#000000"},
    Mark{"bounds-uniform", 12, "#6a3d9a"},
    Mark{"bounds-modes", 6, "#6a3d9a"},
    Mark{"bounds-krylov-3", 4, "#6a3d9a"},
};

std::string point_text(const Trade& trade) {
    return number_text(1e3 * trade.time_s, 8) + " " + number_text(std::max(trade.error, FLOOR), 8);
}

/// Data block and plot of one plate.
std::string panel(std::span<const PlateRow> rows, const std::string& title, int number) {
    const std::vector<Trade> trades = trades_of(rows);
    const auto block = [number](std::size_t k) {
        return "$p" + std::to_string(number) + "_" + std::to_string(k);
    };
    std::string data, plot;
    const auto add = [&](std::size_t k, const std::string& points, const std::string& how) {
        data += block(k) + " << EOD\n" + points + "EOD\n";
        plot += (plot.empty() ? "plot " : ", ") + block(k) + " using 1:2 with " + how;
    };
    std::string front;
    for (const std::size_t i : pareto_front(trades)) front += point_text(trades[i]) + "\n";
    add(0, front, "lines lw 6 lc rgb '#e8d174' title 'Pareto front'");
    const double own = rows.front().truth ? rows.front().truth->relative_error : 0.0;
    if (own > FLOOR) {
        add(MARKS.size() + 1, "1e-4 " + number_text(own) + "\n1e4 " + number_text(own) + "\n",
            "lines lw 2 dt 3 lc rgb '#999999' title 'error of the reference'");
    }
    for (std::size_t k = 0; k < MARKS.size(); ++k) {
        std::string points;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            if (rows[i].method == MARKS[k].method) points += point_text(trades[i]) + "\n";
        }
        if (points.empty()) continue;
        add(k + 1, points,
            "linespoints lw 1 ps 1.4 pt " + std::to_string(MARKS[k].point) + " lc rgb '" + MARKS[k].colour +
                "' title '" + MARKS[k].method + "'");
    }
    return data + "set title " + report::gnuplot_quoted(title) + "\n" + plot + "\n";
}

}  // namespace

std::string pareto_script(std::span<const PlateRow> rows, const std::filesystem::path& picture) {
    struct Panel {
        const char* field;
        double side_over_l;
        const char* title;
    };
    constexpr std::array PANELS{Panel{"hyperbolic", 0.0, "smooth: D = 10/(1 + 9x), bare"},
                                Panel{"random", 0.0, "rough: 100 random sites, 1 to 1000, bare"}};
    std::string panels;
    int count = 0;
    for (const Panel& p : PANELS) {
        const std::vector<PlateRow> of = comparable(rows, p.field, p.side_over_l);
        if (!of.empty()) panels += panel(of, p.title, count++);
    }
    if (count == 0) return "";
    return "set term pngcairo size " + std::to_string(800 * count) +
           ",980 noenhanced font 'sans,12'\nset output " + report::gnuplot_quoted(picture.string()) +
           "\nset logscale xy\nset format x '%g'\nset format y '10^{%L}'\nset termoption enhanced\n"
           "set grid lc rgb '#dddddd'\nset border lc rgb '#555555'\n"
           "set key below maxcols 3 font ',10' noenhanced\n"
           "set xlabel 'time from a new D to the compliance (ms)'\n"
           "set ylabel 'relative error of the continuum compliance'\n"
           "set xrange [1e-4:1e4]\nset yrange [1e-8:2]\nset bmargin 10\n"
           "set arrow from 1, graph 0 to 1, graph 1 nohead dt 2 lc rgb '#333333'\n"
           "set arrow from 160, graph 0 to 160, graph 1 nohead dt 2 lc rgb '#333333'\n"
           "set label '1 ms' at 1, graph 0.02 offset 0.5,0\nset label '160 ms' at 160, graph 0.02 offset "
           "-6,0\n"
           "set multiplot layout 1," +
           std::to_string(count) + "\n" + panels + "unset multiplot\n";
}

}  // namespace palpate::study
