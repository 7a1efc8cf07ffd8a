#include "host/report/figures.hpp"

#include <algorithm>
#include <vector>

#include "host/record/record.hpp"
#include "host/report/ticks.hpp"

namespace palpate::report {
namespace {

using Eigen::Vector3d;

constexpr double SMALL_DEFLECTION = 0.5;  // of h: beyond it linear plate theory is only nominal

/// On a leg of the path that stays in contact and moves.
bool on_stroke(const scene::Scene& scene, double t_s) {
    const std::vector<scene::PathPoint>& path = scene.hand.path;
    for (std::size_t i = 1; i < path.size(); ++i) {
        const scene::PathPoint &a = path[i - 1], &b = path[i];
        if (t_s < a.t_s || t_s >= b.t_s) continue;
        return a.depth_m > 0.0 && b.depth_m > 0.0 && a.at_m != b.at_m;
    }
    return false;
}

std::optional<double> median(std::vector<double>& values) {
    if (values.empty()) return std::nullopt;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

constexpr const char* NO_CONTACT = "no contact";

struct Range {
    double low = 0.0, high = 0.0;
    bool any = false;
    void add(double value) {
        low = any ? std::min(low, value) : value;
        high = any ? std::max(high, value) : value;
        any = true;
    }
    /// `why_none`: said when nothing was added.
    [[nodiscard]] Json json(const char* why_none) const {
        return any ? Json{{"min", low}, {"max", high}}
                   : Json{{"min", nullptr}, {"max", nullptr}, {"min_why", why_none}, {"max_why", why_none}};
    }
};

/// How often each stop latched, and in how many ticks each fault was there, by name.
struct Counters {
    Json stops = Json::object(), fault_ticks = Json::object();
    std::uint32_t stop = 0;  ///< of the tick before

    void add(const pal_tick& tick) {
        if (tick.stop != 0 && tick.stop != stop) count(stops, record::stop_word(tick.stop));
        stop = tick.stop;
        for (std::uint32_t left = tick.faults; left != 0; left &= left - 1)
            count(fault_ticks, record::fault_words(left & ~(left - 1)));
    }
    static void count(Json& all, const std::string& word) { all[word] = all.value(word, 0) + 1; }
};

bool holds(const scene::Expect& expect, const Json& value) {
    if (!expect.number) return value.is_string() && value.get<std::string>() == expect.word;
    if (!value.is_number()) return false;
    const double number = value.get<double>();
    if (expect.op == "<=") return number <= *expect.number;
    if (expect.op == ">=") return number >= *expect.number;
    return number == *expect.number;
}

Json figure_json(const Figure& figure) {
    return {{"rms_relative", figure.rms_relative}, {"max_relative", figure.max_relative}};
}

}  // namespace

StiffnessRatio stiffness_ratio(const scene::World& world, std::span<const pal_tick> ticks,
                               std::span<const Touch> touches) {
    if (world.nodules.empty()) return {std::nullopt, "the scene has no nodule", 0, 0};
    const scene::Nodule& nodule = world.nodules.front();
    std::vector<double> over, beside;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        if (!touches[i].contact() || !on_stroke(world.scene, 1e-3 * ticks[i].path_tick)) continue;
        const double away = (touches[i].foot->point_m - nodule.at_m).norm() / nodule.radius_m;
        const double stiffness = force_of(ticks[i]).norm() / touches[i].depth_m;
        if (away <= 1.0) over.push_back(stiffness);
        if (away >= 1.5 && away <= 3.0) beside.push_back(stiffness);
    }
    StiffnessRatio ratio{std::nullopt, "", over.size(), beside.size()};
    const auto a = median(over), b = median(beside);
    if (a && b) {
        ratio.value = *a / *b;
    } else {
        ratio.why =
            std::string("no stroke of the path touched the skin ") + (a ? "beside" : "over") + " the nodule";
    }
    return ratio;
}

Json run_figures(const scene::World& world, std::span<const pal_tick> ticks, std::span<const Touch> touches) {
    Range force, depth, k, age;
    std::size_t n_contact = 0, n_fading = 0, n_clamped = 0, n_stale = 0;
    std::uint32_t faults = 0, stop = 0;
    Counters counters;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        const pal_tick& tick = ticks[i];
        faults |= tick.faults;
        counters.add(tick);
        if (tick.stop != 0) stop = tick.stop;
        n_fading += static_cast<std::size_t>(tick.before_id != 0);
        n_clamped += static_cast<std::size_t>(is_clamped(tick));
        n_stale += static_cast<std::size_t>(is_stale(tick));
        if (!touches[i].contact()) continue;
        ++n_contact;
        force.add(force_of(tick).norm());
        depth.add(touches[i].depth_m);
        if (tick.k_n_per_m > 0.0F) k.add(static_cast<double>(tick.k_n_per_m));
        age.add(tick.table_age_ticks);
    }
    const double relative = depth.any ? depth.high / world.scene.skin.thickness_m : 0.0;
    Json figures = {{"stop", record::stop_word(stop)},
                    {"stop_counts", counters.stops},
                    {"faults", record::fault_words(faults)},
                    {"fault_ticks", counters.fault_ticks},
                    {"n_ticks", ticks.size()},
                    {"n_contact_ticks", n_contact},
                    {"n_fading_ticks", n_fading},
                    {"n_clamped_ticks", n_clamped},
                    {"n_stale_ticks", n_stale},
                    {"n_missed_ticks", ticks.empty() ? 0U : ticks.back().n_missed},
                    {"force_n", force.json(NO_CONTACT)},
                    {"depth_m", depth.json(NO_CONTACT)},
                    {"k_n_per_m", k.json(n_contact == 0 ? NO_CONTACT : "no table in contact")},
                    {"table_age_ticks", age.json(NO_CONTACT)},
                    {"depth_over_thickness_max", relative},
                    {"fade_work_j", ticks.empty() ? 0.0 : static_cast<double>(ticks.back().fade_work_j)}};
    if (relative > SMALL_DEFLECTION) {
        figures["depth_over_thickness_warning"] =
            "deeper than half the thickness: the linear law is nominal there (docs/MATH.md, depth law)";
    }
    return figures;
}

void add_force_error(Json& summary, const std::optional<ForceError>& error, const std::string& why_not) {
    const bool complete = error && error->n_without_reference == 0;
    if (!complete) {
        const std::string why = error ? std::to_string(error->n_without_reference) +
                                            " of the chosen ticks have no plate to compare with"
                                      : why_not;
        for (const char* name :
             {"force_error_rms_relative", "force_error_max_relative", "force_error_parts"}) {
            summary[name] = nullptr;
            summary[std::string(name) + "_why"] = why;
        }
        if (!error) return;
    } else {
        summary["force_error_rms_relative"] = error->total.rms_relative;
        summary["force_error_max_relative"] = error->total.max_relative;
        summary["force_error_parts"] = {{"table", figure_json(error->table)},
                                        {"staleness", figure_json(error->staleness)},
                                        {"delay", figure_json(error->delay)},
                                        {"quantisation", figure_json(error->quantisation)}};
    }
    summary["force_error_ticks"] = {{"contact", error->n_contact},
                                    {"checked", error->n_checked},
                                    {"without_reference", error->n_without_reference},
                                    {"fading", error->n_fading},
                                    {"clamped", error->n_clamped},
                                    {"ramped", error->n_ramped},
                                    {"stale", error->n_stale},
                                    {"without_table", error->n_without_table}};
    summary["force_reference_rms_n"] = error->reference_rms_n;
    summary["force_reference_max_n"] = error->reference_max_n;
}

std::vector<std::string> failed_expectations(const scene::Scene& scene, const Json& summary) {
    std::vector<std::string> failed;
    for (const scene::Expect& expect : scene.expect) {
        const bool known = summary.contains(expect.name);
        if (known && holds(expect, summary[expect.name])) continue;
        const std::string bound =
            expect.op + " " + (expect.number ? Json(*expect.number).dump() : expect.word);
        failed.push_back(expect.name + " " + bound + " does not hold: it is " +
                         (known ? summary[expect.name].dump() : std::string("not in summary.json")));
    }
    return failed;
}

}  // namespace palpate::report
