#include "host/plate/bounds/kernels.hpp"

#include <cmath>
#include <cstring>

namespace palpate::plate::bounds {
namespace {

constexpr std::size_t N_LANES = 8;

/// Two doubles in one register: what every x86-64 has, and what g++ does not find by itself in dot_rows.
using Pair = double __attribute__((vector_size(16)));

Pair load(const double* at) {
    Pair pair;
    std::memcpy(&pair, at, sizeof pair);
    return pair;
}

double folded(const double* lane) {
    return ((lane[0] + lane[4]) + (lane[1] + lane[5])) + ((lane[2] + lane[6]) + (lane[3] + lane[7]));
}

/// term(0) + ... + term(n - 1), every eighth in a lane of its own.
template <typename Term>
double summed(std::size_t n, Term term) {
    double lane[N_LANES] = {};
    std::size_t i = 0;
    for (; i + N_LANES <= n; i += N_LANES) {
        for (std::size_t l = 0; l < N_LANES; ++l) lane[l] += term(i + l);
    }
    for (std::size_t l = 0; i < n; ++i, ++l) lane[l] += term(i);
    return folded(lane);
}

}  // namespace

double dot(const double* a, const double* b, std::size_t n) {
    return summed(n, [=](std::size_t i) { return a[i] * b[i]; });
}

double weighted_square(const double* a, const double* weight, std::size_t n) {
    return summed(n, [=](std::size_t i) { return weight[i] * (a[i] * a[i]); });
}

double weighted_magnitude(const double* a, const double* weight, std::size_t n) {
    return summed(n, [=](std::size_t i) { return weight[i] * std::fabs(a[i]); });
}

void dot_rows(const double* rows, std::size_t n_rows, const double* x, std::size_t n, double* sums) {
    constexpr std::size_t N_TOGETHER = 4;  // rows that share the loads of x, as many as registers hold
    std::size_t r = 0;
    for (; r + N_TOGETHER <= n_rows; r += N_TOGETHER) {
        const double* row[N_TOGETHER];
        Pair even[N_TOGETHER], odd[N_TOGETHER];
        for (std::size_t k = 0; k < N_TOGETHER; ++k) {
            row[k] = rows + (r + k) * n;
            even[k] = odd[k] = Pair{0.0, 0.0};
        }
        std::size_t i = 0;
        for (; i + 4 <= n; i += 4) {
            const Pair x_even = load(x + i), x_odd = load(x + i + 2);
            for (std::size_t k = 0; k < N_TOGETHER; ++k) {
                even[k] += load(row[k] + i) * x_even;
                odd[k] += load(row[k] + i + 2) * x_odd;
            }
        }
        for (std::size_t k = 0; k < N_TOGETHER; ++k) {
            const Pair all = even[k] + odd[k];
            double rest = 0.0;
            for (std::size_t j = i; j < n; ++j) rest += row[k][j] * x[j];
            sums[r + k] = (all[0] + all[1]) + rest;
        }
    }
    for (; r < n_rows; ++r) sums[r] = dot(rows + r * n, x, n);
}

Extremes invert(const double* x, std::size_t n, double* reciprocals) {
    double least[N_LANES], most[N_LANES], zero[N_LANES] = {};
    for (std::size_t l = 0; l < N_LANES; ++l) least[l] = most[l] = x[0];
    const auto take = [&](std::size_t i, std::size_t l) {
        least[l] = x[i] < least[l] ? x[i] : least[l];
        most[l] = x[i] > most[l] ? x[i] : most[l];
        zero[l] += 0.0 * x[i];  // NaN and infinity leave no zero
    };
    std::size_t i = 0;
    for (; i + N_LANES <= n; i += N_LANES) {
        for (std::size_t l = 0; l < N_LANES; ++l) {
            reciprocals[i + l] = 1.0 / x[i + l];
            take(i + l, l);
        }
    }
    for (std::size_t l = 0; i < n; ++i, ++l) {
        reciprocals[i] = 1.0 / x[i];
        take(i, l);
    }
    Extremes all{least[0], most[0], folded(zero) == 0.0};
    for (std::size_t l = 1; l < N_LANES; ++l) {
        all.least = least[l] < all.least ? least[l] : all.least;
        all.most = most[l] > all.most ? most[l] : all.most;
    }
    return all;
}

}  // namespace palpate::plate::bounds
