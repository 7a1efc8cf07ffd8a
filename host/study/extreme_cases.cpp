#include "host/study/extreme_cases.hpp"

#include <cmath>
#include <limits>

#include "host/study/plates.hpp"
#include "host/study/text.hpp"

namespace palpate::study {
namespace {

using Eigen::Index;

constexpr std::uint64_t SEED = 7;

double r2(double x, double z) {
    return (x - 0.5) * (x - 0.5) + (z - 0.5) * (z - 0.5);
}

plate::Sheet unit_sheet(plate::Field rigidity) {
    plate::Sheet sheet;
    sheet.size_m = {1.0, 1.0};
    sheet.rigidity_n_m = std::move(rigidity);
    return sheet;
}

/// Cases of one grid size, collected.
class Cases {
public:
    explicit Cases(Index nodes) : n_(nodes) {}

    void contrast() {
        for (int decade = 0; decade <= 15; decade += 3) {
            const double ratio = std::pow(10.0, decade);
            const std::string text = "1e" + std::to_string(decade);
            discrete("contrast", "half planes " + text,
                     [ratio](double x, double) { return x > 0.4 ? ratio : 1.0; });
            discrete("contrast", "half planes, soft under the load " + text,
                     [ratio](double x, double) { return x > 0.55 ? ratio : 1.0; });
            discrete("contrast", "random sites " + text, random_sites(ratio, SEED));
            discrete("contrast", "stiff island " + text,
                     [ratio](double x, double z) { return r2(x, z) < 0.0225 ? ratio : 1.0; });
            discrete("contrast", "soft lake " + text,
                     [ratio](double x, double z) { return r2(x, z) < 0.0225 ? 1.0 / ratio : 1.0; });
        }
        for (const int decade : {7, 8, 10}) {
            const double ratio = std::pow(10.0, decade);
            discrete("contrast", "stiff island 1e" + std::to_string(decade),
                     [ratio](double x, double z) { return r2(x, z) < 0.0225 ? ratio : 1.0; });
        }
        discrete(
            "contrast", "half planes 1e16", [](double x, double) { return x > 0.4 ? 1e16 : 1.0; },
            Judge::refusal);
    }

    void holes() {
        for (const double radius : {0.1, 0.2}) {
            plate::Sheet sheet = unit_sheet([](double, double) { return 1.0; });
            sheet.solid = [radius](double x, double z) {
                return (x - 0.25) * (x - 0.25) + (z - 0.5) * (z - 0.5) - radius * radius;
            };
            add("hole", "mask, r = " + number_text(radius) + " beside the load",
                plate::on_grid(sheet, n_, n_));
        }
        with_zero("D = 0 at one node", 1);
        with_zero("D = 0 on 3 x 3 nodes", 3);
        with_zero("D = 0 on half a plate", n_);
        plate::Problem none = uniform();
        none.solid = plate::Mask::Constant(n_, n_, false);
        add("hole", "no plate at all", none, Judge::refusal);
    }

    void poisson() {
        for (const double nu : {-0.99, -0.5, 0.0, 0.3, 0.45, 0.4999}) {
            plate::Sheet sheet = unit_sheet([](double, double) { return 1.0; });
            sheet.poisson = nu;
            continuum("poisson", "nu = " + number_text(nu) + ", uniform", sheet, n_, n_);
            sheet.rigidity_n_m = [](double x, double) { return x > 0.4 ? 10.0 : 1.0; };
            add("poisson", "nu = " + number_text(nu) + ", jump 10", plate::on_grid(sheet, n_, n_));
        }
        for (const double nu : {-1.0, 0.5, std::numeric_limits<double>::quiet_NaN()}) {
            plate::Problem bad = uniform();
            bad.poisson = nu;
            add("poisson", "nu = " + number_text(nu, 3, "NaN"), bad, Judge::refusal);
        }
    }

    void aspect() {
        for (const double ratio : {2.0, 4.0, 10.0}) {
            plate::Sheet sheet = unit_sheet([](double, double) { return 1.0; });
            sheet.size_m = {1.0, ratio};
            const std::string name = "1 : " + number_text(ratio);
            continuum("aspect", name + ", as many nodes along both sides", sheet, n_, n_);
            const Index long_nodes = static_cast<Index>(std::lround(ratio)) * (n_ - 1) + 1;
            continuum("aspect", name + ", square cells", sheet, n_, long_nodes);
        }
    }

    void units() {
        for (const double scale : {1e-12, 1e-6, 1e6, 1e12}) {
            plate::Sheet sheet = unit_sheet([scale](double, double) { return scale; });
            continuum("units", "D = " + number_text(scale) + " N m", sheet, n_, n_);
            sheet = unit_sheet([](double, double) { return 1.0; });
            sheet.size_m = {scale, scale};
            continuum("units", "side " + number_text(scale) + " m", sheet, n_, n_);
            sheet = unit_sheet([scale](double x, double) { return scale / (1.0 + 9.0 * x / scale); });
            sheet.size_m = {scale, scale};
            sheet.foundation_n_per_m3 = [scale](double, double) { return 1e3 / (scale * scale * scale); };
            add("units", "both " + number_text(scale) + ", hyperbolic, on a foundation",
                plate::on_grid(sheet, n_, n_));
        }
        for (const double scale : {1e-300, 1e300}) {
            discrete("units", "D = " + number_text(scale) + " N m",
                     [scale](double, double) { return scale; });
        }
    }

    void one_node() {
        for (const double factor : {0.2, 0.5, 2.0, 5.0}) {
            plate::Problem problem = uniform();
            problem.rigidity_n_m(n_ / 2, n_ / 2) = factor;
            add("one-node", "D = " + number_text(factor) + " at the load, else 1", problem);
        }
    }

    void bad_input() {
        constexpr double INF = std::numeric_limits<double>::infinity();
        for (const double value : {-0.5, std::numeric_limits<double>::quiet_NaN(), INF}) {
            const std::string words = std::isfinite(value) ? number_text(value) : value > 0.0 ? "inf" : "NaN";
            plate::Problem problem = uniform();
            problem.rigidity_n_m(3, 5) = value;
            add("bad-input", "D = " + words + " at one node", problem, Judge::refusal);
            problem = uniform();
            problem.foundation_n_per_m3 = Eigen::ArrayXXd::Zero(n_, n_);
            problem.foundation_n_per_m3(3, 5) = value;
            add("bad-input", "k_f = " + words + " at one node", problem, Judge::refusal);
        }
        plate::Problem flat = uniform();
        flat.size_m.y() = 0.0;
        add("bad-input", "a side of 0 m", flat, Judge::refusal);
    }

    std::vector<ExtremeCase> all;

private:
    [[nodiscard]] plate::Problem uniform() const {
        return plate::on_grid(unit_sheet([](double, double) { return 1.0; }), n_, n_);
    }
    void add(const std::string& group, const std::string& name, const plate::Problem& problem,
             Judge judge = Judge::discrete) {
        all.push_back({group, name, problem, judge, std::nullopt});
    }
    void discrete(const std::string& group, const std::string& name, const plate::Field& rigidity,
                  Judge judge = Judge::discrete) {
        add(group, name, plate::on_grid(unit_sheet(rigidity), n_, n_), judge);
    }
    void continuum(const std::string& group, const std::string& name, const plate::Sheet& sheet, Index nx,
                   Index nz) {
        all.push_back({group, name, plate::on_grid(sheet, nx, nz), Judge::continuum, sheet});
    }
    void with_zero(const std::string& name, Index width) {
        plate::Problem problem = uniform();
        const Index first = width == 1 ? n_ / 4 : 0;
        problem.rigidity_n_m.block(first, first, std::min(width, n_ / 2), width).setZero();
        add("hole", name, problem, Judge::refusal);
    }

    Index n_;
};

}  // namespace

std::vector<ExtremeCase> extreme_cases(Index nodes) {
    Cases cases(nodes);
    cases.contrast();
    cases.holes();
    cases.poisson();
    cases.aspect();
    cases.units();
    cases.one_node();
    cases.bad_input();
    return cases.all;
}

std::vector<std::string> extreme_groups() {
    return {"contrast", "hole", "poisson", "aspect", "units", "one-node", "bad-input"};
}

}  // namespace palpate::study
