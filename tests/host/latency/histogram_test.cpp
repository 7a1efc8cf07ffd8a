#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "host/latency/histogram.hpp"

using namespace palpate::latency;

namespace {

constexpr Level LEVELS[] = {Level::P50, Level::P90, Level::P99, Level::P99_9, Level::P99_99};

/// The sample of rank ceil(level n), by sorting.
std::uint64_t nearest_rank(std::vector<std::uint64_t> samples, Level level) {
    std::sort(samples.begin(), samples.end());
    const std::uint64_t share = static_cast<std::uint64_t>(level), n = samples.size();
    return samples[(share * n + 9999) / 10000 - 1];
}

/// From 100 ns to 3 s: every part of the histogram.
std::vector<std::uint64_t> samples_over_all_scales(std::size_t n) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> power(2.0, 9.5);
    std::vector<std::uint64_t> out(n);
    for (std::uint64_t& sample : out) sample = static_cast<std::uint64_t>(std::pow(10.0, power(random)));
    return out;
}

std::vector<std::uint64_t> contents(const Histogram& histogram) {
    std::vector<std::uint64_t> out;
    for (const auto& bin : histogram.bins()) out.insert(out.end(), {bin.from_ns, bin.to_ns, bin.n});
    return out;
}

}  // namespace

TEST_CASE("a percentile is the end of the bin that holds the sorted sample of that rank") {
    const std::size_t n = GENERATE(as<std::size_t>{}, 1, 2, 9, 10, 1000, 10001);
    const std::uint64_t bin_ns = GENERATE(as<std::uint64_t>{}, WAKE_BIN_NS, COST_BIN_NS);
    const std::vector<std::uint64_t> samples = samples_over_all_scales(n);
    Histogram histogram(bin_ns);
    for (const std::uint64_t sample : samples) histogram.add(sample);
    for (const Level level : LEVELS) {
        CAPTURE(n, bin_ns, static_cast<std::uint64_t>(level));
        const std::uint64_t truth = nearest_rank(samples, level), said = histogram.percentile_ns(level);
        CHECK(said >= truth);
        // A bin is bin_ns wide, or 1/80 of the octave's beginning; 1 s and more is one bin.
        const std::uint64_t width = std::max(bin_ns, truth / 80);
        if (truth < 1000000000) CHECK(said - truth < width);
    }
    CHECK(histogram.max_ns() == *std::max_element(samples.begin(), samples.end()));
    CHECK(histogram.min_ns() == *std::min_element(samples.begin(), samples.end()));
    double sum = 0.0;
    for (const std::uint64_t sample : samples) sum += static_cast<double>(sample);
    CHECK(histogram.mean_ns() == Approx(sum / static_cast<double>(n)).epsilon(1e-12));
}

TEST_CASE("the percentiles of 0 to 1999 us once each are those of the uniform distribution") {
    Histogram histogram;
    for (std::uint64_t us = 0; us < 2000; ++us) histogram.add(us * 1000);
    CHECK(histogram.percentile_ns(Level::P50) == 999999);  // the 1000th is 999 us, its bin ends at 1000
    CHECK(histogram.percentile_ns(Level::P90) == 1799999);
    CHECK(histogram.percentile_ns(Level::P99) == 1979999);
    CHECK(histogram.percentile_ns(Level::P99_9) == 1997999);
    CHECK(histogram.percentile_ns(Level::P99_99) == 1999000);  // the largest itself
    CHECK(histogram.mean_ns() == 999500.0);
}

TEST_CASE("the percentiles of a geometric distribution are its closed form") {
    // 2^(20 - j) samples of j us for j < 20, and one of 20 us: P(> j us) = 2^-(j + 1).
    Histogram histogram;
    for (std::uint64_t j = 0; j < 20; ++j) histogram.add(j * 1000, std::uint64_t{1} << (19 - j));
    histogram.add(20000);
    REQUIRE(histogram.n() == std::uint64_t{1} << 20);
    CHECK(histogram.percentile_ns(Level::P50) / 1000 == 0);
    CHECK(histogram.percentile_ns(Level::P90) / 1000 == 3);      // 1 - 2^-4 = 0.9375
    CHECK(histogram.percentile_ns(Level::P99) / 1000 == 6);      // 1 - 2^-7 = 0.9922
    CHECK(histogram.percentile_ns(Level::P99_9) / 1000 == 9);    // 1 - 2^-10 = 0.99902
    CHECK(histogram.percentile_ns(Level::P99_99) / 1000 == 13);  // 1 - 2^-14 = 0.99994
}

TEST_CASE("every time has a bin that holds it, bins follow each other, and 1 s is not the last") {
    const std::uint64_t bin_ns = GENERATE(as<std::uint64_t>{}, 1, COST_BIN_NS, WAKE_BIN_NS, 7, 500000);
    Histogram histogram(bin_ns);
    std::uint64_t end = 0;
    for (std::uint64_t value : {std::uint64_t{0}, bin_ns * 1999, bin_ns * 2000, bin_ns * 2024, bin_ns * 2025,
                                bin_ns * 3999, bin_ns * 4000, std::uint64_t{1000000000}}) {
        Histogram one(bin_ns);
        one.add(value);
        const auto bins = one.bins();
        REQUIRE(bins.size() == 1);
        CAPTURE(bin_ns, value, bins[0].from_ns, bins[0].to_ns);
        CHECK(bins[0].from_ns <= value);
        CHECK(value < bins[0].to_ns);
        if (value <= 1000000000) CHECK(bins[0].to_ns != ~std::uint64_t{0});
    }
    // All bins up to 1 s, found by stepping from end to end.
    while (end < 1000000000) {
        Histogram one(bin_ns);
        one.add(end);
        REQUIRE(one.bins()[0].from_ns == end);
        end = one.bins()[0].to_ns;
        if (bin_ns == 1 && end > 4000) break;  // enough of these
    }
    Histogram over(bin_ns);
    over.add(~std::uint64_t{0} >> 1);
    CHECK(over.bins()[0].to_ns == ~std::uint64_t{0});
    CHECK(over.percentile_ns(Level::P50) == over.max_ns());
}

TEST_CASE("a stall counts as every start that waited") {
    Histogram histogram;
    histogram.add_start(30000000, 1000000);  // 30 ms late in a loop of 1 ms: 30, 29, ... 1 ms
    CHECK(histogram.n() == 30);
    CHECK(histogram.mean_ns() == 15500000.0);
    CHECK(histogram.min_ns() == 1000000);
    CHECK(histogram.max_ns() == 30000000);
    histogram.add_start(0, 1000000);
    histogram.add_start(1000000, 1000000);  // just one period: the next start is on time
    histogram.add_start(1000001, 1000000);  // and here it is 1 ns late
    CHECK(histogram.n() == 34);
    CHECK(histogram.min_ns() == 0);
}

TEST_CASE("without the starts that waited a stall hides: the mutant") {
    // 970 good starts, then a stall of 30 periods: 3 % of the time.
    Histogram corrected, raw;
    for (int i = 0; i < 970; ++i) corrected.add_start(20000, 1000000), raw.add(20000);
    corrected.add_start(30000000, 1000000), raw.add(30000000);
    CHECK(corrected.n() == 1000);
    CHECK(corrected.percentile_ns(Level::P99) >= 20000000);
    CHECK(raw.percentile_ns(Level::P99) < 21000);
}

TEST_CASE("merged histograms are the histogram of all samples") {
    const std::vector<std::uint64_t> samples = samples_over_all_scales(5000);
    Histogram all, a, b, empty;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        all.add(samples[i]);
        (i % 3 == 0 ? a : b).add(samples[i]);
    }
    a.merge(b);
    a.merge(empty);
    CHECK(contents(a) == contents(all));
    CHECK(a.n() == all.n());
    CHECK(a.mean_ns() == all.mean_ns());
    CHECK(a.min_ns() == all.min_ns());
    CHECK(a.max_ns() == all.max_ns());
    empty.merge(all);
    CHECK(empty.min_ns() == all.min_ns());
    CHECK_THROWS_AS(a.merge(Histogram(COST_BIN_NS)), std::invalid_argument);
}

TEST_CASE("an empty histogram says 0 and impossible bins are refused") {
    const Histogram empty;
    CHECK(empty.n() == 0);
    CHECK(empty.percentile_ns(Level::P99) == 0);
    CHECK(empty.mean_ns() == 0.0);
    CHECK(empty.min_ns() == 0);
    CHECK(empty.bins().empty());
    CHECK_THROWS_AS(Histogram(0), std::invalid_argument);
    CHECK_THROWS_AS(Histogram(500001), std::invalid_argument);
}
