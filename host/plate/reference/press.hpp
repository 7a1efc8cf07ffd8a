/// One energy pressed to a list of depths.
#pragma once
#include <functional>
#include <span>

#include "host/plate/reference/least_squares.hpp"
#include "host/plate/reference/pressed.hpp"

namespace palpate::reference {

/// Units of an energy that is a plain number: w in thicknesses, in-plane displacement in thickness^2/size.
struct Scale {
    double thickness_m;
    double size_m;
    double rigidity_n_m;
};

/// The quadratic part of the strains is left out of a linear energy.
enum class Strain { linear, quadratic };

/// `add(energy, strain)` puts the residuals in; unknowns [0, deflections) are w, those after it in-plane.
struct Model {
    std::size_t unknowns;
    std::size_t deflections;
    Unknown contact;
    std::function<void(LeastSquares&, Strain)> add;
};

/// Throws std::runtime_error when Ceres finds no minimum.
[[nodiscard]] Pressed press(const Model& model, const Scale& scale, std::span<const double> depths_m);

}  // namespace palpate::reference
