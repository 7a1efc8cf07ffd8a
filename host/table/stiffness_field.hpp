/// Stiffness as a field on the object: solved once per scan point, kept, and interpolated between.
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "host/chart/patch.hpp"
#include "host/contact/surface.hpp"

namespace palpate::table {

/// A value between the scan's points.
struct FieldValue {
    double n_per_m;         ///< NaN where no plate can be cut
    double relative_error;  ///< estimated: the plates' own error and the misfit of the interpolation
};

class StiffnessField {
public:
    /// `surface` is borrowed. Nothing is solved yet.
    StiffnessField(const contact::Surface& surface, const chart::Material& material);

    /// Stiffness at a place of the skin: weighted cubic through the points of its sheet within 2.8
    /// spacings (MATH.md eq. 27). Solves for those that are not known yet (about 1 ms each); otherwise about
    /// 10 us.
    [[nodiscard]] FieldValue at(const contact::Foot& foot) const;
    /// Solves for `points`, telling how many are done.
    void bake(std::span<const cloud::Index> points, const std::function<void(std::size_t)>& progress) const;
    /// The points that at(foot) reads, and those within `radius_m` more along the surface.
    [[nodiscard]] std::vector<cloud::Index> needed_for(const contact::Foot& foot, double radius_m) const;

    [[nodiscard]] const std::vector<float>& known_n_per_m() const {
        return shown_;
    }  ///< NaN: not solved, or no plate
    [[nodiscard]] std::size_t n_solved() const { return n_solved_; }
    [[nodiscard]] std::size_t n_saddles() const { return n_saddles_; }
    /// Why the last point that could not be solved has no plate, in words; empty when none was refused one.
    [[nodiscard]] const std::string& why_not() const { return why_not_; }

private:
    struct Sample {
        enum class State : std::uint8_t { unknown, solved, impossible } state = State::unknown;
        Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
        double n_per_m = 0.0, relative_error = 0.0;
    };
    const Sample& sample(cloud::Index point) const;
    [[nodiscard]] double support_m() const;
    const std::vector<cloud::Index>& near(cloud::Index point) const;

    const contact::Surface* surface_;
    chart::Material material_;
    mutable std::vector<Sample> samples_;
    mutable std::vector<std::vector<cloud::Index>> near_;
    mutable std::vector<float> shown_;
    mutable std::size_t n_solved_ = 0, n_saddles_ = 0;
    mutable std::string why_not_;
};

}  // namespace palpate::table
