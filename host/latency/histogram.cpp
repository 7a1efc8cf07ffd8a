#include "host/latency/histogram.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <stdexcept>
#include <string>

namespace palpate::latency {
namespace {

constexpr std::uint64_t COVERED_NS = 1000000000;
constexpr std::uint64_t PER_OCTAVE = 80;
constexpr std::uint64_t EVEN_PER_STEP = Histogram::N_EVEN / PER_OCTAVE;  // a bin of the first octave
static_assert(EVEN_PER_STEP * PER_OCTAVE == Histogram::N_EVEN, "bins of an octave have whole ends");
constexpr std::uint64_t LEVEL_ONE = 10000;

/// Octaves from N_EVEN bins on, COVERED_NS inside.
std::uint64_t n_octaves(std::uint64_t bin_ns) {
    std::uint64_t n = 0;
    while ((Histogram::N_EVEN * bin_ns) << n <= COVERED_NS) ++n;
    return n;
}

}  // namespace

Histogram::Histogram(std::uint64_t bin_ns) : bin_ns_(bin_ns) {
    if (bin_ns == 0 || bin_ns > COVERED_NS / N_EVEN) {
        throw std::invalid_argument("a bin of " + std::to_string(bin_ns) + " ns: 1 to 500000 are possible");
    }
    counts_.assign(N_EVEN + PER_OCTAVE * n_octaves(bin_ns) + 1, 0);
}

std::size_t Histogram::bin_of(std::uint64_t value_ns) const noexcept {
    const std::uint64_t even = value_ns / bin_ns_;
    if (even < N_EVEN) return even;
    const auto octave = static_cast<std::uint64_t>(std::bit_width(even / N_EVEN)) - 1;
    const std::uint64_t step = (even - (N_EVEN << octave)) / (EVEN_PER_STEP << octave);
    return std::min(N_EVEN + PER_OCTAVE * octave + step, counts_.size() - 1);
}

std::uint64_t Histogram::from_ns(std::size_t bin) const {
    if (bin < N_EVEN) return bin * bin_ns_;
    const std::uint64_t octave = (bin - N_EVEN) / PER_OCTAVE, step = (bin - N_EVEN) % PER_OCTAVE;
    return ((N_EVEN + step * EVEN_PER_STEP) << octave) * bin_ns_;
}

std::uint64_t Histogram::to_ns(std::size_t bin) const {
    return bin + 1 < counts_.size() ? from_ns(bin + 1) : std::numeric_limits<std::uint64_t>::max();
}

void Histogram::add(std::uint64_t value_ns, std::uint64_t n) noexcept {
    if (n == 0) return;
    counts_[bin_of(value_ns)] += n;
    n_ += n;
    sum_ns_ += value_ns * n;
    min_ns_ = std::min(min_ns_, value_ns);
    max_ns_ = std::max(max_ns_, value_ns);
}

void Histogram::add_start(std::uint64_t late_ns, std::uint64_t period_ns) noexcept {
    add(late_ns);
    while (period_ns > 0 && late_ns > period_ns) add(late_ns -= period_ns);
}

void Histogram::merge(const Histogram& other) {
    if (other.bin_ns_ != bin_ns_) throw std::invalid_argument("histograms with bins of different widths");
    for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
    n_ += other.n_;
    sum_ns_ += other.sum_ns_;
    min_ns_ = std::min(min_ns_, other.min_ns_);
    max_ns_ = std::max(max_ns_, other.max_ns_);
}

double Histogram::mean_ns() const {
    return n_ == 0 ? 0.0 : static_cast<double>(sum_ns_) / static_cast<double>(n_);
}

std::uint64_t Histogram::percentile_ns(Level level) const {
    if (n_ == 0) return 0;
    const auto share = static_cast<std::uint64_t>(level);
    // ceil(share n / 10000) in two parts, which cannot overflow.
    const std::uint64_t rank =
        share * (n_ / LEVEL_ONE) + (share * (n_ % LEVEL_ONE) + LEVEL_ONE - 1) / LEVEL_ONE;
    std::uint64_t n = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
        n += counts_[i];
        if (n >= rank) return std::min(to_ns(i) - 1, max_ns_);
    }
    return max_ns_;
}

std::vector<Histogram::Bin> Histogram::bins() const {
    std::vector<Bin> out;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
        if (counts_[i] > 0) out.push_back({from_ns(i), to_ns(i), counts_[i]});
    }
    return out;
}

}  // namespace palpate::latency
