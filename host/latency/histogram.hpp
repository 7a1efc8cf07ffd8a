/// Latencies of a run, counted: fixed memory, exact counts, no allocation after the constructor.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace palpate::latency {

inline constexpr std::uint64_t WAKE_BIN_NS = 1000;  ///< as cyclictest counts
inline constexpr std::uint64_t COST_BIN_NS = 10;    ///< a stage of the tick takes 100 ns and more

/// Share of the samples, in 1/10000: percentile_ns() counts in whole samples, without rounding of its own.
enum class Level : std::uint64_t { P50 = 5000, P90 = 9000, P99 = 9900, P99_9 = 9990, P99_99 = 9999 };

/// Counts per bin: 2000 bins of bin_ns from 0 on, then 80 bins an octave (1.25 % of their place, or less) to
/// 1 s at least, then one bin for the rest. 0 to 2 ms in steps of 1 us by default. Smallest, largest and mean
/// are exact.
class Histogram {
public:
    static constexpr std::uint64_t N_EVEN = 2000;  ///< bins of bin_ns

    /// One bin of the even part, `bin_ns` wide: 1 to 500000; throws std::invalid_argument otherwise.
    explicit Histogram(std::uint64_t bin_ns = WAKE_BIN_NS);
    /// `n` samples. Bounded time, no allocation.
    void add(std::uint64_t value_ns, std::uint64_t n = 1) noexcept;
    /// A start that came `late_ns` late in a loop of this period, with every start that waited behind it:
    /// late, late - period, late - 2 period, ..., while above 0. Without these a stall of 30 ms were one bad
    /// sample of a thousand instead of 30 (coordinated omission; G. Tene). 0 counts once. Time: late /
    /// period.
    void add_start(std::uint64_t late_ns, std::uint64_t period_ns) noexcept;
    /// The samples of `other` too. Throws std::invalid_argument when its bins are of another width.
    void merge(const Histogram& other);

    [[nodiscard]] std::uint64_t bin_ns() const { return bin_ns_; }
    [[nodiscard]] std::uint64_t n() const { return n_; }
    [[nodiscard]] std::uint64_t min_ns() const { return n_ == 0 ? 0 : min_ns_; }
    [[nodiscard]] std::uint64_t max_ns() const { return max_ns_; }
    [[nodiscard]] double mean_ns() const;
    /// By nearest rank: the end of the bin in which the sample of rank ceil(level n) lies, but no more than
    /// the largest sample. So at least that share is not above it, and it is too high by less than a bin. 0
    /// when there are no samples.
    [[nodiscard]] std::uint64_t percentile_ns(Level level) const;

    struct Bin {
        std::uint64_t from_ns, to_ns;  ///< [from, to); of the last bin `to` is the largest number
        std::uint64_t n;
    };
    /// Those with samples, ascending.
    [[nodiscard]] std::vector<Bin> bins() const;

private:
    [[nodiscard]] std::size_t bin_of(std::uint64_t value_ns) const noexcept;
    [[nodiscard]] std::uint64_t from_ns(std::size_t bin) const;
    [[nodiscard]] std::uint64_t to_ns(std::size_t bin) const;

    std::uint64_t bin_ns_;
    std::vector<std::uint64_t> counts_;
    std::uint64_t n_ = 0, sum_ns_ = 0, min_ns_ = ~std::uint64_t{0}, max_ns_ = 0;
};

}  // namespace palpate::latency
