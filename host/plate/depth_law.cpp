#include "host/plate/depth_law.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace palpate::plate {
namespace {

using Constants = Eigen::Matrix<double, 5, 1>;
constexpr std::array<int, 5> POWERS = {1, 2, 4, 1, 2};  ///< of n1 n2 n4 m1 m2
constexpr int LAWSON_ROUNDS = 40;
constexpr double CONSTANT_MAX =
    4.0;  ///< some fits creep along a valley to infinity and gain nothing on the way

/// psi and its derivatives.
struct Psi {
    double under;
    double under_slope;
    double value;
    double first;
    double second;
};

Psi psi_at(const DepthLaw& law, double x) {
    const double x2 = x * x;
    const double over = 1.0 + law.n1 * x + law.n2 * x2 + law.n4 * x2 * x2;
    const double over_slope = law.n1 + 2.0 * law.n2 * x + 4.0 * law.n4 * x2 * x;
    const double over_second = 2.0 * law.n2 + 12.0 * law.n4 * x2;
    Psi psi{};
    psi.under = 1.0 + law.m1 * x + law.m2 * x2;
    psi.under_slope = law.m1 + 2.0 * law.m2 * x;
    psi.value = over / psi.under;
    psi.first = (over_slope - psi.value * psi.under_slope) / psi.under;
    psi.second = (over_second - 2.0 * psi.first * psi.under_slope - psi.value * 2.0 * law.m2) / psi.under;
    return psi;
}

bool denominator_positive(const DepthLaw& law) {
    return law.m2 >= 0.0 && (law.m1 >= 0.0 || law.m1 * law.m1 < 4.0 * law.m2);
}

}  // namespace

double psi(const DepthLaw& law, double x) {
    return psi_at(law, x).value;
}

double phi(const DepthLaw& law, double x) {
    const Psi psi = psi_at(law, x);
    return psi.value + 0.5 * x * psi.first;
}

double tangent(const DepthLaw& law, double x) {
    const Psi psi = psi_at(law, x);
    return psi.value + 2.0 * x * psi.first + 0.5 * x * x * psi.second;
}

// ---- rises

namespace {

constexpr std::size_t DEGREE = 8;
using Polynomial = std::array<double, DEGREE + 1>;  ///< coefficients, lowest power first

/// Powers above DEGREE must not come up.
Polynomial times(const Polynomial& a, const Polynomial& b) {
    Polynomial out{};
    for (std::size_t i = 0; i <= DEGREE; ++i) {
        for (std::size_t j = 0; i + j <= DEGREE; ++j) out[i + j] += a[i] * b[j];
    }
    return out;
}

Polynomial sum(const Polynomial& a, double f, const Polynomial& b) {
    Polynomial out = a;
    for (std::size_t i = 0; i <= DEGREE; ++i) out[i] += f * b[i];
    return out;
}

/// x p'.
Polynomial risen(const Polynomial& p) {
    Polynomial out{};
    for (std::size_t i = 0; i <= DEGREE; ++i) out[i] = static_cast<double>(i) * p[i];
    return out;
}

/// tangent * M^3, where psi = N/M: with R = x N' M - N x M' = M^2 x psi', and x d(x psi')/dx = x psi' +
/// x^2 psi'', tangent = psi + 3/2 x psi' + 1/2 x d(x psi')/dx.
Polynomial tangent_numerator(const Polynomial& n, const Polynomial& m) {
    const Polynomial slope = sum(times(risen(n), m), -1.0, times(n, risen(m)));
    const Polynomial twice = sum(times(risen(slope), m), -2.0, times(slope, risen(m)));
    return sum(sum(times(n, times(m, m)), 1.5, times(slope, m)), 0.5, twice);
}

/// The polynomial's Bernstein coefficients over [x0, x0 + step], which hold it in their hull.
Polynomial bernstein(Polynomial p, double x0, double step) {
    for (std::size_t i = 0; i < DEGREE; ++i) {  // Taylor at x0
        for (std::size_t j = DEGREE; j-- > i;) p[j] += x0 * p[j + 1];
    }
    double power = 1.0;
    double binomial = 1.0;
    for (std::size_t i = 0; i <= DEGREE; ++i) {
        p[i] *= power / binomial;
        power *= step;
        binomial *= static_cast<double>(DEGREE - i) / static_cast<double>(i + 1);
    }
    for (std::size_t i = 0; i < DEGREE; ++i) {  // sums along the triangle
        for (std::size_t j = DEGREE; j > i; --j) p[j] += p[j - 1];
    }
    return p;
}

}  // namespace

bool rises(const DepthLaw& law, double x_max) {
    constexpr double STEP = 0.125;
    if (!denominator_positive(law)) return false;
    const Polynomial numerator = tangent_numerator({1.0, law.n1, law.n2, 0.0, law.n4}, {1.0, law.m1, law.m2});
    for (int cell = 0; cell * STEP < x_max; ++cell) {
        const double x0 = cell * STEP;
        const Polynomial hull = bernstein(numerator, x0, std::min(STEP, x_max - x0));
        if (!std::all_of(hull.begin(), hull.end(), [](double c) { return c > 0.0; })) return false;
    }
    return true;
}

// ---- the fit

namespace {

DepthLaw law_of(const Constants& c) {
    return {.n1 = c[0], .n2 = c[1], .n4 = c[2], .m1 = c[3], .m2 = c[4]};
}

/// Relative errors of phi, and their derivatives by the constants.
class Errors {
public:
    Errors(std::span<const double> x, std::span<const double> phi, Free free)
        : x_(x), phi_(phi), free_{free.n1, free.n2, free.n4, free.m1, free.m2} {}

    [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(x_.size()); }

    [[nodiscard]] Eigen::VectorXd at(const Constants& constants) const {
        const DepthLaw law = law_of(constants);
        Eigen::VectorXd errors(size());
        for (Eigen::Index i = 0; i < size(); ++i) errors[i] = plate::phi(law, x(i)) / target(i) - 1.0;
        return errors;
    }

    [[nodiscard]] Eigen::Matrix<double, Eigen::Dynamic, 5> slopes(const Constants& constants) const {
        Eigen::Matrix<double, Eigen::Dynamic, 5> slopes(size(), 5);
        slopes.setZero();
        for (Eigen::Index i = 0; i < size(); ++i) {
            const Psi psi = psi_at(law_of(constants), x(i));
            for (std::size_t k = 0; k < 5; ++k) {
                if (free_[k]) slopes(i, static_cast<Eigen::Index>(k)) = slope(psi, x(i), k) / target(i);
            }
        }
        return slopes;
    }

private:
    [[nodiscard]] double x(Eigen::Index i) const { return x_[static_cast<std::size_t>(i)]; }
    [[nodiscard]] double target(Eigen::Index i) const { return phi_[static_cast<std::size_t>(i)]; }

    /// d phi/d constant, from d psi/dn = x^p/M and d psi/dm = -psi x^p/M.
    static double slope(const Psi& psi, double x, std::size_t k) {
        const double g = std::pow(x, POWERS[k]) / psi.under;
        const double x_g_slope = g * (POWERS[k] - x * psi.under_slope / psi.under);
        const double by_n = g + 0.5 * x_g_slope;
        return k < 3 ? by_n : -psi.value * by_n - 0.5 * x * psi.first * g;
    }

    std::span<const double> x_;
    std::span<const double> phi_;
    std::array<bool, 5> free_;
};

/// Levenberg-Marquardt from `start` on the weighted errors.
Constants least_squares(const Errors& errors, const Eigen::VectorXd& weights, Constants start) {
    const auto cost = [&](const Constants& c) {
        const bool good = denominator_positive(law_of(c)) && c.lpNorm<Eigen::Infinity>() <= CONSTANT_MAX;
        return good ? (weights.array() * errors.at(c).array().square()).sum()
                    : std::numeric_limits<double>::infinity();
    };
    double damping = 1e-3;
    double best = cost(start);
    for (int step = 0; step < 500 && damping < 1e12; ++step) {
        const Eigen::Matrix<double, Eigen::Dynamic, 5> slopes = errors.slopes(start);
        Eigen::Matrix<double, 5, 5> normal = slopes.transpose() * weights.asDiagonal() * slopes;
        const Constants gradient = slopes.transpose() * weights.cwiseProduct(errors.at(start));
        for (int k = 0; k < 5; ++k) normal(k, k) += normal(k, k) == 0.0 ? 1.0 : damping * normal(k, k);
        const Constants next = start - normal.ldlt().solve(gradient);
        const double there = cost(next);
        if (there < best) {
            start = next;
            best = there;
            damping = std::max(1e-15, damping / 10.0);
        } else {
            damping *= 10.0;
        }
    }
    return start;
}

}  // namespace

DepthLawFit fit_depth_law(std::span<const double> x, std::span<const double> phi, Free free) {
    const auto positive = [](double value) { return value > 0.0 && std::isfinite(value); };
    const int constants = free.n1 + free.n2 + free.n4 + free.m1 + free.m2;
    if (x.size() != phi.size() || x.size() < static_cast<std::size_t>(constants) ||
        !std::all_of(x.begin(), x.end(), positive) || !std::all_of(phi.begin(), phi.end(), positive)) {
        throw std::invalid_argument("a depth law needs positive depths and forces, one for each constant");
    }
    const Errors errors(x, phi, free);
    Eigen::VectorXd weights =
        Eigen::VectorXd::Constant(errors.size(), 1.0 / static_cast<double>(errors.size()));
    // psi = 1, with the denominator off its limits.
    const Constants linear(0.3 * free.n1, 0.1 * free.n2, 0.0, 0.3 * free.m1, 0.1 * free.m2);
    Constants now = least_squares(errors, weights, linear);
    Constants best = now;
    double largest = errors.at(now).lpNorm<Eigen::Infinity>();
    for (int round = 0; round < LAWSON_ROUNDS; ++round) {
        weights.array() *= errors.at(now).array().abs();
        weights /= weights.sum();
        now = least_squares(errors, weights, now);
        const double there = errors.at(now).lpNorm<Eigen::Infinity>();
        if (there < largest) {
            largest = there;
            best = now;
        }
    }
    return {law_of(best), largest};
}

std::span<const DepthLawRow> depth_law_table() {
    static constexpr DepthLawRow ROWS[] = {
#include "host/plate/depth_law_table.inc"
    };
    return ROWS;
}

}  // namespace palpate::plate
