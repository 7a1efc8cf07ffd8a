#include "host/plate/uniform/green.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace palpate::plate {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

constexpr double ZETA_3 = 1.2020569031595942854;
constexpr std::size_t N_ZETA = 32;

/// zeta(2 n) from zeta(2) by (n + 1/2) zeta(2 n) = sum of zeta(2 k) zeta(2 n - 2 k): all terms positive.
std::array<double, N_ZETA> even_zetas() {
    std::array<double, N_ZETA> zeta{};
    zeta[1] = pi * pi / 6.0;
    for (std::size_t n = 2; n < N_ZETA; ++n) {
        double sum = 0.0;
        for (std::size_t k = 1; k < n; ++k) sum += zeta[k] * zeta[n - k];
        zeta[n] = sum / (static_cast<double>(n) + 0.5);
    }
    return zeta;
}

/// Around q = 1: powers of u = ln q, |u| < 2 pi.
Polylog near_one(Complex u) {
    static const std::array<double, N_ZETA> zeta = even_zetas();
    if (u == 0.0) return {zeta[1], ZETA_3};
    Complex sum2 = 0.0, sum3 = 0.0;
    const Complex step = -u * u / (4.0 * pi * pi);
    Complex power = 2.0 * step;
    for (std::size_t n = 1; n < N_ZETA; ++n) {
        const double n2 = 2.0 * static_cast<double>(n);
        const Complex term = power * (zeta[n] / (n2 * (n2 + 1.0)));
        sum2 += term;
        sum3 += term / (n2 + 2.0);
        power *= step;
    }
    const Complex log = std::log(-u);
    return {zeta[1] + u * (1.0 - log - 0.25 * u + sum2),
            ZETA_3 + u * (zeta[1] + u * (0.75 - 0.5 * log - u / 12.0 + sum3))};
}

/// What one image at `x` along and `d` across the rectangle of width `width` adds to the sum over all waves:
/// Levy's terms to first order in epsilon over their wave number squared.
Complex image(double width, double epsilon, double x, double d, bool without_log) {
    const double scale = pi / width;
    const Complex u(-scale * d, scale * (x > width ? x - 2.0 * width : x));
    const Polylog li = polylog(u);
    const double sine = std::sin(0.5 * u.imag());
    const double grown = std::expm1(u.real());
    double gap2 = grown * grown + 4.0 * std::exp(u.real()) * sine * sine;  // |1 - q|^2
    if (without_log) {
        const double distance2 = d * d + x * x;
        gap2 = distance2 > 0.0 ? gap2 / distance2 : scale * scale;
    }
    const double bent = li.li3.real() - u.real() * li.li2.real();
    return {-std::log(gap2) / (4.0 * pi), -epsilon * bent / (4.0 * width * scale * scale * scale)};
}

/// One wave number's factor exactly, less what image() sums: exp(-mu d)/(2 mu), mu^2 = wave^2 + i epsilon.
struct Wave {
    double wave;
    double epsilon;
    Complex mu = std::sqrt(Complex(wave * wave, epsilon));

    [[nodiscard]] Complex exactly(double d) const { return std::exp(-mu * d); }
    [[nodiscard]] Complex summed(double d) const {
        const double fading = std::exp(-wave * d) / (2.0 * wave);
        return {fading, -epsilon * fading * (1.0 + wave * d) / (2.0 * wave * wave)};
    }
    [[nodiscard]] Complex rest(double height, double apart, double together) const {
        const double across = 2.0 * height - together;
        const Complex sum =
            exactly(apart) - exactly(together) - exactly(across) + exactly(2.0 * height - apart);
        return sum / (2.0 * mu * (1.0 - exactly(2.0 * height))) -
               (summed(apart) - summed(together) - summed(across));
    }
};

}  // namespace

Polylog polylog(Complex u) {
    constexpr double NEAR = -1.5;
    if (u.real() > NEAR) return near_one(u);
    const Complex q = std::exp(u);
    Complex li2 = 0.0, li3 = 0.0;
    for (int k = 24; k >= 1; --k) {
        li2 = q * (li2 + 1.0 / (k * k));
        li3 = q * (li3 + 1.0 / (k * k * k));
    }
    return {li2, li3};
}

Complex green_without_log(const Eigen::Vector2d& size, double epsilon, const Eigen::Vector2d& a,
                          const Eigen::Vector2d& b) {
    const Eigen::Index along = size.x() <= size.y() ? 0 : 1;
    const double width = size[along], height = size[1 - along];
    const double x_apart = std::fabs(a[along] - b[along]), x_together = a[along] + b[along];
    const double apart = std::fabs(a[1 - along] - b[1 - along]), together = a[1 - along] + b[1 - along];

    Complex sum = 0.0;
    // Terms left out: Re -(3/16) epsilon^2/wave^5, Im far less. 400 sqrt(epsilon) gives GREEN_REAL_ERROR.
    const int last = 40 + static_cast<int>(400.0 / pi * std::sqrt(epsilon) * width);
    for (int m = last; m >= 1; --m) {
        const double wave = m * pi / width;
        const double product = std::cos(wave * x_apart) - std::cos(wave * x_together);
        sum += Wave{wave, epsilon}.rest(height, apart, together) * (product / width);
    }
    const auto pair = [&](double d, bool without_log) {
        return image(width, epsilon, x_apart, d, without_log) - image(width, epsilon, x_together, d, false);
    };
    return sum + pair(apart, true) - pair(together, false) - pair(2.0 * height - together, false);
}

}  // namespace palpate::plate
