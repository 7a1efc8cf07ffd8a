#include "host/scene/nearest.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace palpate::scene {
namespace {

/// Insertions, deletions, replacements and swaps of neighbours that turn `a` into `b`.
std::size_t typing_errors(std::string_view a, std::string_view b) {
    std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), now(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        now[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            now[j] = std::min({replaced, last[j] + 1, now[j - 1] + 1});
            const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (swapped) now[j] = std::min(now[j], before[j - 2] + 1);
        }
        before.swap(last);
        last.swap(now);
    }
    return last[b.size()];
}

}  // namespace

std::string nearest_among(std::string_view name, std::span<const std::string> known_names) {
    constexpr std::size_t LONGEST = 64;  // more is not a typing error
    const auto parent = [](std::string_view of) { return of.substr(0, of.find_last_of('.') + 1); };
    std::string best;
    std::size_t fewest = static_cast<std::size_t>(-1);
    for (const std::string& known : known_names) {
        const std::size_t errors = 2 * typing_errors(name.substr(0, LONGEST), known);
        const std::size_t elsewhere = parent(known) == parent(name) ? 0 : 1;  // decides between equals
        if (errors + elsewhere < fewest) {
            fewest = errors + elsewhere;
            best = known;
        }
    }
    return best;
}

}  // namespace palpate::scene
