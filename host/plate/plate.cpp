#include "host/plate/plate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "host/plate/factor.hpp"

namespace palpate::plate {
namespace {

using Eigen::Index;

// Against extended precision the compliance is wrong by less than 2e-14 / pivot ratio (stiff islands up to
// 1e9), so this leaves 2e-6 at worst. An island 1e6 times stiffer, the contrast of a free edge, has 2e-7 and
// more.
constexpr double PIVOT_RATIO_MIN = 1e-8;
constexpr double RESIDUAL_MAX = 1e-7;  ///< of the unit load
constexpr double ENERGY_ERROR_MAX = 1e-6;
constexpr double RIGIDITY_SPAN_MAX = 1e15;  ///< largest over smallest; beyond it double cannot hold both

std::string node_text(Index ix, Index iz) {
    return "node (" + std::to_string(ix) + ", " + std::to_string(iz) + ")";
}

/// Grid spacings as fractions of size_m.x, stiffness in units of D_max/size_x^2.
struct Scaling {
    double rigidity_n_m;  ///< D_max
    double side_m;
    double hx;
    double hz;

    explicit Scaling(const Problem& problem)
        : rigidity_n_m(problem.rigidity_n_m.maxCoeff()),
          side_m(problem.size_m.x()),
          hx(1.0 / static_cast<double>(problem.rigidity_n_m.rows() - 1)),
          hz(problem.size_m.y() / problem.size_m.x() / static_cast<double>(problem.rigidity_n_m.cols() - 1)) {
    }

    [[nodiscard]] double compliance_m_per_n() const { return side_m * side_m / rigidity_n_m; }
    /// One unit of dimensionless foundation, k_f side^4/D.
    [[nodiscard]] double foundation_n_per_m3() const {
        return rigidity_n_m / side_m / side_m / side_m / side_m;
    }
};

/// Lower triangle, row by row, of B'CB of one node with D = 1 (MATH.md eq. 2): centre, -x, +x, -z, +z.
std::array<double, 15> node_energy(const Scaling& s, double poisson) {
    const double x2 = 1.0 / (s.hx * s.hx);
    const double z2 = 1.0 / (s.hz * s.hz);
    const std::array<double, 5> wxx{-2.0 * x2, x2, x2, 0.0, 0.0};
    const std::array<double, 5> wzz{-2.0 * z2, 0.0, 0.0, z2, z2};
    std::array<double, 15> lower{};
    std::size_t next = 0;
    for (std::size_t a = 0; a < 5; ++a) {
        for (std::size_t b = 0; b <= a; ++b) {
            const double direct = wxx[a] * wxx[b] + wzz[a] * wzz[b];
            const double mixed = wxx[a] * wzz[b] + wzz[a] * wxx[b];
            lower[next++] = s.hx * s.hz * (direct + poisson * mixed);
        }
    }
    return lower;
}

/// The same of one cell (MATH.md eq. 3): corners (0,0), (1,0), (0,1), (1,1).
std::array<double, 10> cell_energy(const Scaling& s, double poisson) {
    constexpr std::array<double, 4> SIGN{1.0, -1.0, -1.0, 1.0};
    std::array<double, 10> lower{};
    std::size_t next = 0;
    for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t b = 0; b <= a; ++b) {
            lower[next++] = 2.0 * (1.0 - poisson) / (s.hx * s.hz) * SIGN[a] * SIGN[b];
        }
    }
    return lower;
}

template <std::size_t N>
void add(std::vector<double>& values, const std::array<std::size_t, N>& entries, double rigidity,
         const std::array<double, N>& energy) {
    for (std::size_t k = 0; k < N; ++k) values[entries[k]] += rigidity * energy[k];
}

/// Entries of K in the units of Scaling, with one more at the end that collects what the clamped nodes would
/// get.
std::vector<double> assemble(const Analysis& analysis, const Problem& problem, const Scaling& scaling) {
    const std::array<double, 15> node_lower = node_energy(scaling, problem.poisson);
    const std::array<double, 10> cell_lower = cell_energy(scaling, problem.poisson);
    const Eigen::ArrayXXd rigidity = problem.rigidity_n_m / scaling.rigidity_n_m;
    std::vector<double> values(analysis.row.size() + 1, 0.0);
    std::size_t cell = 0;
    for (Index ix = 0; ix < analysis.nx; ++ix) {
        for (Index iz = 0; iz < analysis.nz; ++iz) {
            const std::size_t node = analysis.node(ix, iz);
            // On the edge the mirrored ghost doubles the curvature and the node owns half a cell: 2^2/2.
            const double weight = analysis.number[node] == Analysis::EDGE ? 2.0 : 1.0;
            add(values, analysis.node_entries[node], weight * rigidity(ix, iz), node_lower);
            if (ix + 1 == analysis.nx || iz + 1 == analysis.nz) continue;
            const double mean = 0.25 * ((rigidity(ix, iz) + rigidity(ix + 1, iz)) +
                                        (rigidity(ix, iz + 1) + rigidity(ix + 1, iz + 1)));
            add(values, analysis.cell_entries[cell++], mean, cell_lower);
        }
    }
    if (problem.foundation_n_per_m3.size() == 0) return values;
    const double area = scaling.hx * scaling.hz;
    for (Index ix = 1; ix < analysis.nx - 1; ++ix) {
        for (Index iz = 1; iz < analysis.nz - 1; ++iz) {
            const std::size_t diagonal = analysis.column[analysis.number[analysis.node(ix, iz)]];
            values[diagonal] += area * (problem.foundation_n_per_m3(ix, iz) / scaling.foundation_n_per_m3());
        }
    }
    return values;
}

std::vector<double> multiply(const Analysis& analysis, const std::vector<double>& values,
                             const std::vector<double>& x) {
    std::vector<double> product(x.size(), 0.0);
    for (std::size_t c = 0; c < analysis.n_unknowns; ++c) {
        product[c] += values[analysis.column[c]] * x[c];
        for (std::size_t e = analysis.column[c] + 1; e < analysis.column[c + 1]; ++e) {
            product[analysis.row[e]] += values[e] * x[c];
            product[c] += values[e] * x[analysis.row[e]];
        }
    }
    return product;
}

/// The first value of `field` that is below `least` or not finite; nullopt when there is none.
std::optional<std::string> bad_node(const Eigen::ArrayXXd& field, double least, const std::string& name,
                                    const std::string& wanted) {
    for (Index ix = 0; ix < field.rows(); ++ix) {
        for (Index iz = 0; iz < field.cols(); ++iz) {
            if (field(ix, iz) >= least && field(ix, iz) <= std::numeric_limits<double>::max()) continue;
            return name + " " + std::to_string(field(ix, iz)) + " at " + node_text(ix, iz) + "; " + wanted;
        }
    }
    return std::nullopt;
}

}  // namespace

std::optional<std::string> problem_with(const Problem& problem) {
    const Eigen::ArrayXXd& rigidity = problem.rigidity_n_m;
    const Eigen::ArrayXXd& foundation = problem.foundation_n_per_m3;
    const auto is_length = [](double m) { return m >= 1e-9 && m <= 1e9; };
    if (!is_length(problem.size_m.x()) || !is_length(problem.size_m.y())) {
        return "plate sides " + std::to_string(problem.size_m.x()) + " x " +
               std::to_string(problem.size_m.y()) + " m; each must be a positive length";
    }
    if (!(problem.poisson > -1.0 && problem.poisson < 0.5)) {
        return "Poisson's ratio " + std::to_string(problem.poisson) + "; must lie between -1 and 0.5";
    }
    if (rigidity.rows() < 5 || rigidity.cols() < 5) {
        return "grid of " + std::to_string(rigidity.rows()) + " x " + std::to_string(rigidity.cols()) +
               " nodes; needs at least 5 x 5";
    }
    if (foundation.size() != 0 &&
        (foundation.rows() != rigidity.rows() || foundation.cols() != rigidity.cols())) {
        return "foundation of " + std::to_string(foundation.rows()) + " x " +
               std::to_string(foundation.cols()) + " nodes; must be empty or match the rigidity's " +
               std::to_string(rigidity.rows()) + " x " + std::to_string(rigidity.cols());
    }
    constexpr double LEAST = std::numeric_limits<double>::min();
    if (auto bad = bad_node(rigidity, LEAST, "rigidity", "must be positive and finite")) return bad;
    if (auto bad = bad_node(foundation, 0.0, "foundation", "must be finite and not negative")) return bad;
    if (rigidity.maxCoeff() / rigidity.minCoeff() > RIGIDITY_SPAN_MAX) {
        return std::string("rigidity spans more than 15 decades; clamp the softest nodes");
    }
    return std::nullopt;
}

struct Plate::Impl {
    Scaling scaling;
    std::shared_ptr<const Analysis> analysis;
    std::vector<double> values;
    Factor factor;

    explicit Impl(const Problem& problem)
        : scaling(problem),
          analysis(analysis_for(problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols())),
          values(assemble(*analysis, problem, scaling)),
          factor(analysis, values) {}

    /// Dimensionless deflection under a unit load, by elimination number.
    [[nodiscard]] std::vector<double> solve(std::size_t loaded) const {
        std::vector<double> x(analysis->n_unknowns, 0.0);
        x[loaded] = 1.0;
        factor.solve(x);
        return x;
    }

    /// Throws Guard unless the factor, and the solution under a load at the centre, can be trusted.
    void check() const {
        if (!(factor.smallest_pivot_ratio() > PIVOT_RATIO_MIN)) {
            throw Guard("plate too badly conditioned: smallest pivot ratio " +
                        std::to_string(factor.smallest_pivot_ratio() / PIVOT_RATIO_MIN) +
                        "e-8, needs 1e-8 (a stiff island in soft surroundings, or "
                        "a region with nothing to hold it)");
        }
        const std::size_t centre = analysis->n_unknowns - 1;
        const std::vector<double> x = solve(centre);
        const std::vector<double> force = multiply(*analysis, values, x);
        double energy = 0.0;
        for (std::size_t k = 0; k < force.size(); ++k) {
            const double load = k == centre ? 1.0 : 0.0;
            if (!(std::fabs(force[k] - load) <= RESIDUAL_MAX))
                throw Guard("plate solution leaves a residual above 1e-7");
            energy += x[k] * force[k];
        }
        if (!(x[centre] > 0.0)) throw Guard("plate compliance is not positive");
        if (!(std::fabs(energy / x[centre] - 1.0) <= ENERGY_ERROR_MAX) ||
            !(std::fabs(factor.last_compliance() / x[centre] - 1.0) <= ENERGY_ERROR_MAX)) {
            throw Guard("plate energy differs from the work of its load by more than 1e-6");
        }
    }
};

Plate::Plate(const Problem& problem) {
    if (const auto problem_text = problem_with(problem)) throw std::invalid_argument(*problem_text);
    impl_ = std::make_unique<Impl>(problem);
    impl_->check();
}

Plate::~Plate() = default;
Plate::Plate(Plate&&) noexcept = default;

double Plate::centre_compliance_m_per_n() const {
    if (impl_->analysis->nx % 2 == 0 || impl_->analysis->nz % 2 == 0) {
        throw std::invalid_argument("the centre of the plate is no node; the node counts must be odd");
    }
    return impl_->factor.last_compliance() * impl_->scaling.compliance_m_per_n();
}

Eigen::ArrayXXd Plate::deflection_m(Index ix, Index iz) const {
    const Analysis& analysis = *impl_->analysis;
    if (ix < 0 || ix >= analysis.nx || iz < 0 || iz >= analysis.nz) {
        throw std::invalid_argument("load at " + node_text(ix, iz) + ", outside the grid");
    }
    Eigen::ArrayXXd deflection = Eigen::ArrayXXd::Zero(analysis.nx, analysis.nz);
    const std::size_t loaded = analysis.number[analysis.node(ix, iz)];
    if (loaded == Analysis::EDGE) return deflection;
    const std::vector<double> x = impl_->solve(loaded);
    for (Index i = 1; i < analysis.nx - 1; ++i) {
        for (Index j = 1; j < analysis.nz - 1; ++j) {
            deflection(i, j) = x[analysis.number[analysis.node(i, j)]] * impl_->scaling.compliance_m_per_n();
        }
    }
    return deflection;
}

Eigen::MatrixXd Plate::dense_stiffness_n_per_m() const {
    const Analysis& analysis = *impl_->analysis;
    const auto n = static_cast<Index>(analysis.n_unknowns);
    std::vector<Index> place(analysis.n_unknowns);
    for (Index i = 1; i < analysis.nx - 1; ++i) {
        for (Index j = 1; j < analysis.nz - 1; ++j) {
            place[analysis.number[analysis.node(i, j)]] = (i - 1) * (analysis.nz - 2) + (j - 1);
        }
    }
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
    for (std::size_t c = 0; c < analysis.n_unknowns; ++c) {
        for (std::size_t e = analysis.column[c]; e < analysis.column[c + 1]; ++e) {
            const double value = impl_->values[e] / impl_->scaling.compliance_m_per_n();
            dense(place[analysis.row[e]], place[c]) = value;
            dense(place[c], place[analysis.row[e]]) = value;
        }
    }
    return dense;
}

}  // namespace palpate::plate
