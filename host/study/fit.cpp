#include "host/study/fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace palpate::study {

std::optional<PowerLaw> power_law(std::span<const double> x, std::span<const double> y) {
    if (x.size() != y.size() || x.size() < 3) return std::nullopt;
    const auto positive = [](double v) { return v > 0.0 && std::isfinite(v); };
    if (!std::all_of(x.begin(), x.end(), positive) || !std::all_of(y.begin(), y.end(), positive))
        return std::nullopt;
    const auto n = static_cast<double>(x.size());
    double mean_x = 0.0, mean_y = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        mean_x += std::log(x[i]) / n;
        mean_y += std::log(y[i]) / n;
    }
    double xx = 0.0, xy = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double dx = std::log(x[i]) - mean_x;
        xx += dx * dx;
        xy += dx * (std::log(y[i]) - mean_y);
    }
    if (!(xx > 1e-20)) return std::nullopt;
    const double exponent = xy / xx;
    double scatter = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double off = std::log(y[i]) - mean_y - exponent * (std::log(x[i]) - mean_x);
        scatter += off * off;
    }
    const double error = x.size() > 2 ? std::sqrt(scatter / (n - 2.0) / xx) : 0.0;
    return PowerLaw{std::exp(mean_y - exponent * mean_x), exponent, error};
}

std::vector<std::size_t> pareto_front(std::span<const Trade> trades) {
    std::vector<std::size_t> order(trades.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::erase_if(order, [&](std::size_t i) {
        return !std::isfinite(trades[i].time_s) || !std::isfinite(trades[i].error);
    });
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        if (trades[a].time_s != trades[b].time_s) return trades[a].time_s < trades[b].time_s;
        return trades[a].error < trades[b].error;
    });
    std::vector<std::size_t> front;
    double least = std::numeric_limits<double>::infinity();
    for (const std::size_t i : order) {
        if (!(trades[i].error < least)) continue;
        least = trades[i].error;
        front.push_back(i);
    }
    return front;
}

Quartiles quartiles(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
        const double rank = share * static_cast<double>(values.size() - 1);
        const auto below = static_cast<std::size_t>(rank);
        const std::size_t above = std::min(below + 1, values.size() - 1);
        return values[below] + (rank - static_cast<double>(below)) * (values[above] - values[below]);
    };
    return {at(0.25), at(0.5), at(0.75)};
}

}  // namespace palpate::study
