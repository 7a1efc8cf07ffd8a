/// What is read out of many measurements.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace palpate::study {

/// y = factor x^exponent.
struct PowerLaw {
    double factor, exponent;
    double exponent_error;  ///< standard error, from the scatter
};
/// Least squares of log y on log x. nullopt for fewer than three points, which show no scatter, x that are
/// all alike, or a value that is not positive.
[[nodiscard]] std::optional<PowerLaw> power_law(std::span<const double> x, std::span<const double> y);

struct Trade {
    double time_s, error;
};
/// Which of these nothing beats in both time and error, the fastest first; of equals the first. A trade that
/// is not finite never counts.
[[nodiscard]] std::vector<std::size_t> pareto_front(std::span<const Trade> trades);

struct Quartiles {
    double low, median, high;
};
/// Linear between ranks. `values` not empty.
[[nodiscard]] Quartiles quartiles(std::vector<double> values);

}  // namespace palpate::study
