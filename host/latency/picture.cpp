#include <algorithm>

#include "host/latency/report.hpp"
#include "host/latency/words.hpp"
#include "host/report/gnuplot.hpp"

namespace palpate::latency {
namespace {

constexpr std::uint64_t US_NS = 1000;

struct Curve {
    const char* words;
    const char* colour;
    const Histogram* histogram;
};

std::vector<Curve> curves(const Measured& measured) {
    std::vector<Curve> out;
    const auto add = [&](const char* words, const char* colour, const Quantity& quantity) {
        if (quantity.known()) out.push_back({words, colour, &quantity.histogram});
    };
    add("wake-up", "#3b528b", measured.wake_up);
    add("tick cost", "#21918c", measured.tick_cost);
    add("sensor to force", "#e07b00", measured.sensor_to_force);
    return out;
}

/// Where the left picture ends, us: with nearly all of every curve inside.
std::uint64_t shown_us(const std::vector<Curve>& all) {
    std::uint64_t us = 50;
    for (const Curve& curve : all) {
        us = std::max(us, curve.histogram->percentile_ns(Level::P99_9) / US_NS * 5 / 4);
    }
    return std::min(us, Histogram::N_EVEN);
}

/// "us count" of each us below `end_us`; an empty one lies below the axis.
std::string counts_of(const Histogram& histogram, std::uint64_t end_us) {
    std::vector<std::uint64_t> counts(end_us, 0);
    for (const Histogram::Bin& bin : histogram.bins()) {
        if (bin.from_ns / US_NS < end_us) counts[bin.from_ns / US_NS] += bin.n;
    }
    std::string out;
    for (std::size_t us = 0; us < counts.size(); ++us) {
        out += std::to_string(us) + (counts[us] == 0 ? " 0.1" : ' ' + std::to_string(counts[us])) + '\n';
    }
    return out;
}

/// "us share" of the samples at or above the beginning of each bin.
std::string shares_of(const Histogram& histogram) {
    std::string out;
    std::uint64_t n_below = 0;
    for (const Histogram::Bin& bin : histogram.bins()) {
        const double us = static_cast<double>(std::max(bin.from_ns, std::uint64_t{10})) / 1000.0;
        const double share =
            static_cast<double>(histogram.n() - n_below) / static_cast<double>(histogram.n());
        out += number_text(us, 3) + ' ' + number_text(share, 9) + '\n';
        n_below += bin.n;
    }
    return out;
}

/// The data of a plot, by name.
std::string block(const std::string& name, const std::string& data) {
    return "$" + name + " << EOD\n" + data + "EOD\n";
}

std::string plot(const std::vector<Curve>& all, const std::string& prefix, const std::string& style) {
    std::string out = "plot ";
    for (std::size_t i = 0; i < all.size(); ++i) {
        out += (i > 0 ? ", $" : "$") + prefix + std::to_string(i) + " using 1:2 with " + style + " lc rgb '" +
               all[i].colour + "' title '" + all[i].words + "'";
    }
    return out + '\n';
}

std::string script(const std::filesystem::path& png, const std::vector<Curve>& all,
                   const std::string& title) {
    const std::uint64_t end_us = shown_us(all);
    std::string out;
    for (std::size_t i = 0; i < all.size(); ++i) {
        out += block("count" + std::to_string(i), counts_of(*all[i].histogram, end_us));
        out += block("share" + std::to_string(i), shares_of(*all[i].histogram));
    }
    out += "set term pngcairo size 1400,620 noenhanced font 'sans,12'\nset output " +
           report::gnuplot_quoted(png.string()) +
           "\nset grid lc rgb '#dddddd'\nset border lc rgb '#555555'\nset key top right\n"
           "set multiplot layout 1,2 title " +
           report::gnuplot_quoted(title) +
           "\nset logscale y\nset format y '%.0f'\nset xrange [0:" + std::to_string(end_us) +
           "]\nset yrange [0.7:]\n"
           "set xlabel 'us'\nset ylabel 'samples in each us'\n" +
           plot(all, "count", "steps lw 2") +
           "set logscale x\nset format x '%g'\nset format y '%g'\nset autoscale\nset xrange [*:*]\n"
           "set yrange [*:1.2]\nset ylabel 'share of the samples at or above'\nunset key\n"
           "set arrow from 300, graph 0 to 300, graph 1 nohead dt 2 lc rgb '#888888'\n"
           "set arrow from 1000, graph 0 to 1000, graph 1 nohead lc rgb '#bb3333'\n" +
           plot(all, "share", "steps lw 2") + "unset multiplot\n";
    return out;
}

}  // namespace

std::string draw_histograms(const std::filesystem::path& png, const Report& report,
                            const std::string& title) {
    const std::vector<Curve> all = curves(report.measured);
    if (all.empty()) return "there is no " + png.string() + ": neither wake-up nor tick cost is known";
    return report::run_gnuplot(script(png, all, title), png.string());
}

}  // namespace palpate::latency
