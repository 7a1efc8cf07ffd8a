#include "host/plate/bounds/quadratic.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::plate::bounds {

std::array<double, N_MODES_MAX> Quadratic::solve(const std::array<double, N_MODES_MAX>& b,
                                                 std::size_t first) const {
    constexpr double PIVOT_MIN = 1e-12;  ///< of the diagonal; a mode that adds less is left out
    std::array<std::array<double, N_MODES_MAX>, N_MODES_MAX> l{};  // A = L diag L', unit diagonal
    std::array<double, N_MODES_MAX> inverse{}, y = b;
    for (std::size_t j = first; j < n; ++j) {
        double pivot = at(j, j);
        for (std::size_t k = first; k < j; ++k) {
            if (inverse[k] > 0.0) pivot -= l[j][k] * l[j][k] / inverse[k];
        }
        inverse[j] = pivot > PIVOT_MIN * at(j, j) ? 1.0 / pivot : 0.0;
        for (std::size_t i = j + 1; i < n; ++i) {
            double sum = at(i, j);
            for (std::size_t k = first; k < j; ++k) {
                if (inverse[k] > 0.0) sum -= l[i][k] * l[j][k] / inverse[k];
            }
            l[i][j] = sum * inverse[j];
        }
    }
    for (std::size_t i = 0; i < first; ++i) y[i] = 0.0;
    for (std::size_t i = first; i < n; ++i) {
        for (std::size_t k = first; k < i; ++k) y[i] -= l[i][k] * y[k];
    }
    for (std::size_t i = n; i-- > first;) {
        y[i] *= inverse[i];
        for (std::size_t k = i + 1; k < n; ++k) y[i] -= l[k][i] * y[k];
        if (inverse[i] == 0.0) y[i] = 0.0;
    }
    return y;
}

double Quadratic::most(const std::array<double, N_MODES_MAX>& y, double margin) const {
    double value = 0.0, magnitude = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = i; j < n; ++j) value += (i == j ? 1.0 : 2.0) * (y[i] * y[j]) * at(i, j);
        magnitude += std::fabs(y[i]) * std::sqrt(at(i, i));
    }
    return std::max(value, 0.0) + margin * (magnitude * magnitude);
}

}  // namespace palpate::plate::bounds
