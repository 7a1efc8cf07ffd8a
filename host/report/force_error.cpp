#include "host/report/force_error.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>

#include "host/report/reference.hpp"
#include "host/report/ticks.hpp"

namespace palpate::report {
namespace {

using Eigen::Vector3d;

/// The four parts of one tick's error, and the reference.
struct Checked {
    bool good = false;
    Vector3d reference_n, table_n, staleness_n, delay_n, quantisation_n;
};

class TableSet {
public:
    explicit TableSet(const std::map<std::uint64_t, record::TableBytes>& bytes) {
        for (const auto& [id, table] : bytes) tables_[id] = record::table_from(table);
    }
    [[nodiscard]] const pal_table* at(std::uint64_t id) const {
        const auto found = tables_.find(id);
        return found == tables_.end() ? nullptr : found->second.get();
    }

private:
    std::map<std::uint64_t, std::unique_ptr<pal_table>> tables_;
};

/// What the loop would have commanded at `at_m` with this tick's tables, fade, gain and clamp, without
/// rounding.
Vector3d commanded(const pal_tick& tick, const TableSet& tables, const LoopModel& loop, double force_max_n,
                   const Vector3d& at_m) {
    Vector3d force = Vector3d::Zero();
    const auto weight = static_cast<double>(tick.fade_weight);
    if (const pal_table* now = tables.at(tick.table_id)) {
        force += (tick.before_id != 0 ? weight : 1.0) * loop.table_force_n(*now, at_m);
    }
    if (const pal_table* before = tables.at(tick.before_id))
        force += (1.0 - weight) * loop.table_force_n(*before, at_m);
    force *= static_cast<double>(tick.gain);
    const double size = force.norm();
    return size > force_max_n ? Vector3d(force * (force_max_n / size)) : force;
}

/// `sensed_m`: where the tool truly was when this tick's encoders were read.
Checked check(const pal_tick& tick, const contact::Foot& foot, const Vector3d& sensed_m,
              const Vector3d& reference_n, const TableSet& tables, const LoopModel& loop,
              double force_max_n) {
    const Vector3d acts_m = vec(tick.truth_position_m);
    const auto fresh = loop.fresh_table(acts_m, foot);
    if (!fresh) return {};
    const Vector3d made = vec(tick.truth_force_n), ideal = loop.table_force_n(*fresh, acts_m);
    const Vector3d at_sensed = commanded(tick, tables, loop, force_max_n, sensed_m);
    const Vector3d at_acting = commanded(tick, tables, loop, force_max_n, acts_m);
    return {
        true, reference_n, ideal - reference_n, at_acting - ideal, at_sensed - at_acting, made - at_sensed};
}

class Accumulator {
public:
    void add(const Vector3d& error) {
        sum_squares_ += error.squaredNorm();
        max_ = std::max(max_, error.norm());
        ++n_;
    }
    [[nodiscard]] double rms() const {
        return n_ == 0 ? 0.0 : std::sqrt(sum_squares_ / static_cast<double>(n_));
    }
    [[nodiscard]] double max() const { return max_; }
    [[nodiscard]] Figure relative_to(const Accumulator& reference) const {
        return {rms() / reference.rms(), max() / reference.max()};
    }

private:
    double sum_squares_ = 0.0, max_ = 0.0;
    std::size_t n_ = 0;
};

/// References for the chosen ticks, on two threads, each with caches of its own.
std::vector<std::optional<ReferenceForce>> references(const scene::World& world,
                                                      std::span<const pal_tick> ticks,
                                                      std::span<const Touch> touches,
                                                      const std::vector<std::size_t>& chosen,
                                                      const std::function<void(double)>& progress) {
    std::vector<std::optional<ReferenceForce>> found(chosen.size());
    std::atomic<std::size_t> next{0};
    const auto work = [&](bool tells) {
        const Reference reference(world);
        for (std::size_t i = next++; i < chosen.size(); i = next++) {
            const Vector3d at = world.on_object(vec(ticks[chosen[i]].truth_position_m));
            found[i] = reference.at(at, touches[chosen[i]].foot->nearest);
            if (tells) progress(static_cast<double>(i) / static_cast<double>(chosen.size()));
        }
    };
    auto other = std::async(std::launch::async, work, false);
    try {
        work(true);
    } catch (...) {  // `progress` wants no more: the other thread, waited for on the way out, ends too
        next = chosen.size();
        throw;
    }
    other.get();
    return found;
}

void count(const pal_tick& tick, ForceError& error) {
    if (tick.before_id != 0) ++error.n_fading;
    if (is_clamped(tick)) ++error.n_clamped;
    if (tick.state == PAL_STATE_RAMP) ++error.n_ramped;
    if (is_stale(tick)) ++error.n_stale;
    if ((tick.faults & (PAL_FAULT_TABLE_MISSING | PAL_FAULT_TABLE_LEFT)) != 0) ++error.n_without_table;
}

}  // namespace

std::vector<std::size_t> ticks_to_check(std::span<const Touch> touches, std::size_t n_wanted) {
    std::vector<std::size_t> contact, chosen;
    for (std::size_t i = 1; i < touches.size(); ++i) {
        if (touches[i].contact()) contact.push_back(i);
    }
    const std::size_t step = std::max<std::size_t>(1, contact.size() / n_wanted);
    for (std::size_t i = 0; i < contact.size(); i += step) chosen.push_back(contact[i]);
    return chosen;
}

std::optional<ForceError> force_error(const scene::World& world, std::span<const pal_tick> ticks,
                                      std::span<const Touch> touches,
                                      const std::map<std::uint64_t, record::TableBytes>& tables,
                                      const LoopModel& loop, std::size_t n_wanted,
                                      const std::function<void(double)>& progress) {
    ForceError error;
    error.n_contact = ticks_to_check(touches, EVERY_TICK).size();
    const std::vector<std::size_t> chosen = ticks_to_check(touches, n_wanted);
    const auto reference = references(world, ticks, touches, chosen, progress);
    const TableSet set(tables);
    Accumulator whole, total, table, staleness, delay, quantisation;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        const pal_tick& tick = ticks[chosen[i]];
        const Vector3d sensed_m = vec(ticks[chosen[i] - 1].truth_position_m);
        const double force_scale = world.scene.placement.force_scale;
        const Checked c = reference[i] ? check(tick, *touches[chosen[i]].foot, sensed_m,
                                               force_scale * reference[i]->force_n, set, loop,
                                               world.scene.touch.force_max_n)
                                       : Checked{};
        if (!c.good) {
            ++error.n_without_reference;
            continue;
        }
        ++error.n_checked;
        count(tick, error);
        whole.add(c.reference_n);
        total.add(c.table_n + c.staleness_n + c.delay_n + c.quantisation_n);
        table.add(c.table_n);
        staleness.add(c.staleness_n);
        delay.add(c.delay_n);
        quantisation.add(c.quantisation_n);
    }
    if (error.n_checked == 0 || !(whole.max() > 0.0)) return std::nullopt;
    error.reference_rms_n = whole.rms();
    error.reference_max_n = whole.max();
    error.total = total.relative_to(whole);
    error.table = table.relative_to(whole);
    error.staleness = staleness.relative_to(whole);
    error.delay = delay.relative_to(whole);
    error.quantisation = quantisation.relative_to(whole);
    return error;
}

}  // namespace palpate::report
