#include "host/plate/reference/press.hpp"

#include <algorithm>

namespace palpate::reference {
namespace {

/// A start for the next depth: w grows with it, in-plane displacement with its square.
void grow(const Model& model, std::span<double> values, double ratio) {
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] *= i < model.deflections ? ratio : ratio * ratio;
    }
}

}  // namespace

Pressed press(const Model& model, const Scale& scale, std::span<const double> depths_m) {
    const double energy_j =
        scale.rigidity_n_m * scale.thickness_m * scale.thickness_m / scale.size_m / scale.size_m;
    Pressed pressed;
    pressed.depths_m.assign(depths_m.begin(), depths_m.end());
    LeastSquares linear(model.unknowns);
    model.add(linear, Strain::linear);
    linear.values()[model.contact] = 1.0;
    pressed.linear_stiffness_n_per_m =
        2.0 * linear.minimise(model.contact).energy * energy_j / scale.thickness_m / scale.thickness_m;

    LeastSquares energy(model.unknowns);
    model.add(energy, Strain::quadratic);
    const std::span<double> values = energy.values();
    std::ranges::copy(linear.values(), values.begin());
    for (const double depth_m : depths_m) {
        const double depth = depth_m / scale.thickness_m;
        grow(model, values, depth / values[model.contact]);
        values[model.contact] = depth;
        const Minimum minimum = energy.minimise(model.contact);
        pressed.reaction_n.push_back(minimum.reaction * energy_j / scale.thickness_m);
        pressed.force_ratio.push_back(pressed.reaction_n.back() /
                                      (pressed.linear_stiffness_n_per_m * depth_m));
        pressed.energy_j.push_back(minimum.energy * energy_j);
        pressed.iterations.push_back(minimum.iterations);
    }
    return pressed;
}

}  // namespace palpate::reference
