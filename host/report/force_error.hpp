/// How wrong the force was, tick by tick, and why.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/table.h"
#include "common/tick.h"
#include "host/record/record.hpp"
#include "host/report/touches.hpp"
#include "host/scene/world.hpp"

namespace palpate::report {

/// What the analysis needs from the side of the loop, handed in so that nothing here depends on it.
struct LoopModel {
    /// Force of a table at a tool centre, N, workspace frame, without rounding.
    std::function<Eigen::Vector3d(const pal_table&, const Eigen::Vector3d&)> table_force_n;
    /// A table made for this very place and its foot, without delay; nullptr where none can be built. Called
    /// from one thread.
    std::function<std::unique_ptr<pal_table>(const Eigen::Vector3d&, const contact::Foot&)> fresh_table;
};

/// An error vector's size over the ticks that were checked, relative to the reference force.
struct Figure {
    double rms_relative = 0.0;  ///< sqrt(mean |dF|^2)/sqrt(mean |Fref|^2)
    double max_relative = 0.0;  ///< max |dF|/max |Fref|
};

struct ForceError {
    std::size_t n_contact = 0;            ///< ticks with contact
    std::size_t n_checked = 0;            ///< of them compared with the reference
    std::size_t n_without_reference = 0;  ///< chosen, but no plate exists there
    std::size_t n_fading = 0, n_clamped = 0, n_ramped = 0, n_stale = 0;  ///< among the checked
    std::size_t n_without_table = 0;                                     ///< likewise: table missing or left
    double reference_rms_n = 0.0, reference_max_n = 0.0;
    Figure total;      ///< motor words through the true Jacobian, against the reference
    Figure table;      ///< a fresh table at the true place, against the reference
    Figure staleness;  ///< the tables in use with fade, ladder and clamp, against a fresh one
    Figure delay;      ///< the place that was sensed, against the place where the force acts
    Figure
        quantisation;  ///< encoder counts, float and motor words, against exact numbers at the sensed place
};

inline constexpr std::size_t SAMPLE = 400;  ///< ticks wanted: enough for the figure of a run
inline constexpr std::size_t EVERY_TICK = std::numeric_limits<std::size_t>::max();

/// Ticks to check: every n-th contact tick, n = contact ticks/n_wanted rounded down (1 at least).
[[nodiscard]] std::vector<std::size_t> ticks_to_check(std::span<const Touch> touches, std::size_t n_wanted);

/// `touches`: those of `ticks`, which carry the truth of a simulated device. nullopt without a single tick
/// that can be checked. Two threads; the answer does not depend on their schedule. What `progress` (0 to 1)
/// throws ends it.
[[nodiscard]] std::optional<ForceError> force_error(const scene::World& world,
                                                    std::span<const pal_tick> ticks,
                                                    std::span<const Touch> touches,
                                                    const std::map<std::uint64_t, record::TableBytes>& tables,
                                                    const LoopModel& loop, std::size_t n_wanted,
                                                    const std::function<void(double)>& progress);

}  // namespace palpate::report
