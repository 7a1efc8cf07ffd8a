#include "host/study/plates.hpp"

#include <array>
#include <cmath>
#include <limits>

namespace palpate::study {
namespace {

/// Knuth's multiplier: the same numbers on every machine, in [0, 1).
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    double next() {
        state_ = state_ * 6364136223846793005U + 1442695040888963407U;
        return static_cast<double>(state_ >> 11U) * 0x1p-53;
    }

private:
    std::uint64_t state_;
};

double r2(double x, double z) {
    return (x - 0.5) * (x - 0.5) + (z - 0.5) * (z - 0.5);
}

/// 1 at the centre, falling off over a tenth of the side.
double bell(double x, double z) {
    return std::exp(-r2(x, z) / (2.0 * 0.1 * 0.1));
}

constexpr std::uint64_t SEED = 20240501;

}  // namespace

plate::Field random_sites(double contrast, std::uint64_t seed) {
    struct Site {
        double x, z, rigidity;
    };
    std::array<Site, 100> sites{};
    Random random(seed);
    for (Site& site : sites) {
        site.x = random.next();
        site.z = random.next();
        site.rigidity = std::exp(random.next() * std::log(contrast));
    }
    return [sites](double x, double z) {
        double nearest = std::numeric_limits<double>::infinity(), rigidity = 1.0;
        for (const Site& site : sites) {
            const double d2 = (site.x - x) * (site.x - x) + (site.z - z) * (site.z - z);
            if (d2 >= nearest) continue;
            nearest = d2;
            rigidity = site.rigidity;
        }
        return rigidity;
    };
}

std::vector<RigidityField> rigidity_fields() {
    return {
        {.name = "uniform",
         .words = "1",
         .rigidity_n_m = [](double, double) { return 1.0; },
         .uniform = true},
        {.name = "linear", .words = "0.5 + x", .rigidity_n_m = [](double x, double) { return 0.5 + x; }},
        {.name = "hyperbolic",
         .words = "10/(1 + 9 x)",
         .rigidity_n_m = [](double x, double) { return 10.0 / (1.0 + 9.0 * x); }},
        {.name = "nodule",
         .words = "1 + 4 exp(-r^2/0.02)",
         .rigidity_n_m = [](double x, double z) { return 1.0 + 4.0 * bell(x, z); }},
        {.name = "soft-spot",
         .words = "1 - 0.9 exp(-r^2/0.02)",
         .rigidity_n_m = [](double x, double z) { return 1.0 - 0.9 * bell(x, z); }},
        {.name = "jump",
         .words = "10 for x > 0.4, else 1: between grid lines",
         .rigidity_n_m = [](double x, double) { return x > 0.4 ? 10.0 : 1.0; },
         .reference_nodes = 241},
        {.name = "jump-on-line",
         .words = "10 for x > 0.375, else 1: on a grid line, laminate rule",
         .rigidity_n_m = [](double x, double) { return x > 0.375 ? 10.0 : 1.0; },
         .on_lines = true},
        {.name = "random",
         .words = "nearest of 100 sites, 1 to 1000, evenly in log D",
         .rigidity_n_m = random_sites(1e3, SEED)},
        {.name = "island",
         .words = "1e6 for r < 0.2, else 1",
         .rigidity_n_m = [](double x, double z) { return r2(x, z) < 0.2 * 0.2 ? 1e6 : 1.0; }},
    };
}

plate::Sheet sheet_of(const RigidityField& field, double side_over_l) {
    plate::Sheet sheet;
    sheet.size_m = {1.0, 1.0};
    sheet.rigidity_n_m = field.rigidity_n_m;
    if (side_over_l > 0.0) {
        const double k = std::pow(side_over_l, 4.0);
        sheet.foundation_n_per_m3 = [k](double, double) { return k; };
    }
    return sheet;
}

}  // namespace palpate::study
