#include "host/plate/bounds/continuum.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "host/plate/coarser.hpp"

namespace palpate::plate {
namespace {

using Eigen::ArrayXXd;
using Eigen::Index;

constexpr double SAFETY = 1.0;  ///< on what the grid may do to the ratio
constexpr double REFERENCE_ERROR =
    1e-6;  ///< of the uniform plate's continuum and grid compliances, with a margin
constexpr double JUMP_MAX = 100.0;

std::span<const double> span_of(const ArrayXXd& field) {
    return {field.data(), static_cast<std::size_t>(field.size())};
}

/// The problem on every second node; plates with jumps along lines or holes have no certificate.
Problem thinned_problem(const Problem& fine) {
    Problem coarse = every_second_node(fine);
    coarse.harmonic_x_n_m.resize(0, 0);
    coarse.harmonic_z_n_m.resize(0, 0);
    coarse.solid.resize(0, 0);
    return coarse;
}

/// An odd node's share goes half and half to its neighbours.
std::vector<double> thinned_force(std::span<const double> fine, Index nx, Index nz) {
    const Index cx = (nx + 1) / 2, cz = (nz + 1) / 2;
    std::vector<double> coarse(static_cast<std::size_t>(cx * cz), 0.0);
    for (Index iz = 0; iz < nz; ++iz) {
        for (Index ix = 0; ix < nx; ++ix) {
            const double quarter = 0.25 * fine[static_cast<std::size_t>(ix + nx * iz)];
            for (const Index jx : {ix / 2, (ix + 1) / 2}) {
                for (const Index jz : {iz / 2, (iz + 1) / 2})
                    coarse[static_cast<std::size_t>(jx + cx * jz)] += quarter;
            }
        }
    }
    return coarse;
}

/// Nodes of one grid, x fastest.
struct Nodes {
    std::size_t nx, nz;
    [[nodiscard]] std::size_t count() const { return nx * nz; }
};

void thin(const Nodes& fine, std::span<const double> field, std::vector<double>& coarse) {
    const std::size_t cx = (fine.nx + 1) / 2, cz = (fine.nz + 1) / 2;
    coarse.resize(field.empty() ? 0 : cx * cz);  // within what was reserved
    if (field.empty()) return;
    for (std::size_t iz = 0; iz < cz; ++iz) {
        for (std::size_t ix = 0; ix < cx; ++ix) coarse[ix + cx * iz] = field[2 * ix + fine.nx * 2 * iz];
    }
}

bool jumps_too_far(const Nodes& nodes, std::span<const double> d) {
    const auto apart = [](double a, double b) { return a > JUMP_MAX * b || b > JUMP_MAX * a; };
    for (std::size_t iz = 0; iz < nodes.nz; ++iz) {
        for (std::size_t ix = 0; ix < nodes.nx; ++ix) {
            const double here = d[ix + nodes.nx * iz];
            if (ix + 1 < nodes.nx && apart(here, d[ix + 1 + nodes.nx * iz])) return true;
            if (iz + 1 < nodes.nz && apart(here, d[ix + nodes.nx * (iz + 1)])) return true;
        }
    }
    return false;
}

double product(std::span<const double> a, std::span<const double> b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}

/// Of the energy, the part that sits where the coarse grid would guess another value: shares times
/// |ln(value/guess)|, at most 1 each.
double unsure(const Nodes& fine, std::span<const double> field, const std::vector<double>& coarse,
              const std::vector<double>& shares) {
    const std::size_t cx = (fine.nx + 1) / 2;
    double sum = 0.0;
    for (std::size_t iz = 0; iz < fine.nz; ++iz) {
        for (std::size_t ix = 0; ix < fine.nx; ++ix) {
            const std::size_t x0 = ix / 2, x1 = (ix + 1) / 2, z0 = iz / 2, z1 = (iz + 1) / 2;
            const double guess = 0.25 * ((coarse[x0 + cx * z0] + coarse[x1 + cx * z0]) +
                                         (coarse[x0 + cx * z1] + coarse[x1 + cx * z1]));
            const double value = field[ix + fine.nx * iz];
            if (value == guess) continue;
            const double ratio = value / guess;
            const double off = ratio > 0.0 ? std::fabs(std::log(ratio)) : 1.0;
            sum += shares[ix + fine.nx * iz] * (off < 1.0 ? off : 1.0);
        }
    }
    return sum;
}

}  // namespace

struct ContinuumBounds::Impl {
    Nodes nodes;
    bool with_foundation;
    Bounds fine, coarse;
    double spacing_m;  ///< the larger mean one
    std::vector<double> force;
    std::vector<double> inverse_l, fine_factor,
        coarse_factor;  ///< continuum over grid, of the uniform plates

    Impl(const Problem& problem, std::span<const double> force_n, const UniformCompliance& exact,
         const Bounds::Foundations& foundations)
        : nodes{static_cast<std::size_t>(problem.rigidity_n_m.rows()),
                static_cast<std::size_t>(problem.rigidity_n_m.cols())},
          with_foundation(problem.foundation_n_per_m3.size() != 0),
          fine(problem, force_n, foundations),
          coarse(thinned_problem(problem),
                 thinned_force(force_n, problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols()),
                 foundations),
          spacing_m(std::max(problem.size_m.x() / static_cast<double>(nodes.nx - 1),
                             problem.size_m.y() / static_cast<double>(nodes.nz - 1))),
          force(force_n.begin(), force_n.end()) {
        for (const Bounds::Uniform& u : fine.uniforms()) {
            inverse_l.push_back(std::sqrt(std::sqrt(u.foundation_n_per_m3)));
            fine_factor.push_back(exact(u.foundation_n_per_m3) / u.m_per_n);
            coarse_factor.push_back(fine_factor.back() * u.m_per_n);
        }
        std::size_t i = 0;
        for (const Bounds::Uniform& u : coarse.uniforms()) coarse_factor[i++] /= u.m_per_n;
    }

    /// Of D and k_f; nullptr when there is a bracket.
    [[nodiscard]] const char* refusal(std::span<const double> d, double foundation_per_rigidity) const {
        if (jumps_too_far(nodes, d))
            return "no certificate about the continuum: rigidity changes by more than a factor of 100 from "
                   "node "
                   "to node, and the grid does not tell where";
        if (foundation_per_rigidity * (spacing_m * spacing_m) * (spacing_m * spacing_m) > 1.0)
            return "no certificate about the continuum: under the load the foundation's length is shorter "
                   "than "
                   "the grid's spacing";
        return nullptr;
    }

    struct Factors {
        double fine, coarse, error;  ///< continuum over grid; relative error of the interpolation
    };
    /// Linear in 1/l between the two nearest foundations; the error from the curvature about them.
    [[nodiscard]] Factors factors(double foundation_per_rigidity) const {
        const double at = std::sqrt(std::sqrt(foundation_per_rigidity));
        const std::size_t n = inverse_l.size();
        std::size_t i = 1;
        while (i < n && inverse_l[i] < at) ++i;
        if (i >= n) return {fine_factor.back(), coarse_factor.back(), 0.0};  // two grids see what is missing
        const auto between = [&](const std::vector<double>& f) {
            return f[i - 1] + (at - inverse_l[i - 1]) * (f[i] - f[i - 1]) / (inverse_l[i] - inverse_l[i - 1]);
        };
        const auto slope = [&](std::size_t k) {
            return (fine_factor[k] - fine_factor[k - 1]) / (inverse_l[k] - inverse_l[k - 1]);
        };
        double bend = 0.0;  // half the second derivative
        if (i > 1) bend = std::fabs((slope(i) - slope(i - 1)) / (inverse_l[i] - inverse_l[i - 2]));
        if (i + 1 < n)
            bend =
                std::max(bend, std::fabs((slope(i + 1) - slope(i)) / (inverse_l[i + 1] - inverse_l[i - 1])));
        return {between(fine_factor), between(coarse_factor),
                bend * (at - inverse_l[i - 1]) * (inverse_l[i] - at)};
    }
};

struct ContinuumBounds::Scratch::Impl {
    Bounds::Scratch fine, coarse;
    std::vector<double> coarse_d, coarse_k, d_shares, k_shares;

    explicit Impl(const ContinuumBounds::Impl& of)
        : fine(of.fine), coarse(of.coarse), d_shares(of.nodes.count()) {
        coarse_d.reserve(d_shares.size());
        coarse_k.reserve(d_shares.size());
        if (of.with_foundation) k_shares.resize(d_shares.size());
    }
};

ContinuumBounds::Scratch::Scratch(const ContinuumBounds& bounds)
    : impl_(std::make_unique<Impl>(*bounds.impl_)) {}
ContinuumBounds::Scratch::~Scratch() = default;
ContinuumBounds::Scratch::Scratch(Scratch&&) noexcept = default;

std::optional<std::string> ContinuumBounds::none_because(const Problem& problem) {
    if (auto words = Bounds::none_because(problem)) return words;
    for (const Index n : {problem.rigidity_n_m.rows(), problem.rigidity_n_m.cols()}) {
        if (n < 9 || n % 2 == 0)
            return "no certificate about the continuum from " + std::to_string(n) +
                   " nodes a side; needs 2 m + 1, at least 9";
    }
    return std::nullopt;
}

ContinuumBounds::ContinuumBounds(const Problem& grid_of, std::span<const double> force_n,
                                 const UniformCompliance& exact, const Bounds::Foundations& foundations) {
    if (const auto words = none_because(grid_of)) throw std::invalid_argument(*words);
    impl_ = std::make_unique<Impl>(grid_of, force_n, exact, foundations);
}
ContinuumBounds::ContinuumBounds(const Problem& grid_of, std::span<const double> force_n,
                                 const UniformCompliance& exact)
    : ContinuumBounds(grid_of, force_n, exact, Bounds::Foundations{}) {}
ContinuumBounds::~ContinuumBounds() = default;
ContinuumBounds::ContinuumBounds(ContinuumBounds&&) noexcept = default;

std::optional<Bracket> ContinuumBounds::bracket(std::span<const double> rigidity_n_m,
                                                std::span<const double> foundation_n_per_m3,
                                                const Climb& climb, Scratch& scratch,
                                                std::string* why) const {
    Scratch::Impl& s = *scratch.impl_;
    const Bracket fine = impl_->fine.bracket(rigidity_n_m, foundation_n_per_m3, climb, s.fine);
    // The grid's error is that of the plate right under the load.
    const double ratio = foundation_n_per_m3.empty() ? 0.0
                                                     : product(impl_->force, foundation_n_per_m3) /
                                                           product(impl_->force, rigidity_n_m);
    if (const char* words = impl_->refusal(rigidity_n_m, ratio)) {
        if (why != nullptr) *why = words;
        return std::nullopt;
    }
    thin(impl_->nodes, rigidity_n_m, s.coarse_d);
    thin(impl_->nodes, foundation_n_per_m3, s.coarse_k);
    const Climb same{.relative_error = 0.0, .last = fine.rung};
    const Bracket coarse = impl_->coarse.bracket(s.coarse_d, s.coarse_k, same, s.coarse);
    const Impl::Factors factors = impl_->factors(ratio);

    impl_->fine.energy_shares(s.fine, s.d_shares, s.k_shares);
    double sampling = unsure(impl_->nodes, rigidity_n_m, s.coarse_d, s.d_shares);
    if (!foundation_n_per_m3.empty())
        sampling += unsure(impl_->nodes, foundation_n_per_m3, s.coarse_k, s.k_shares);
    const auto widening = [&](double on_coarse, double on_fine) {
        const double change = std::fabs(std::log(factors.coarse / factors.fine * (on_coarse / on_fine)));
        return 1.0 + REFERENCE_ERROR + SAFETY * (change + sampling + factors.error);
    };
    return Bracket{fine.lower_m_per_n * factors.fine / widening(coarse.lower_m_per_n, fine.lower_m_per_n),
                   fine.upper_m_per_n * factors.fine * widening(coarse.upper_m_per_n, fine.upper_m_per_n),
                   fine.rung};
}

Bounds::Foundations foundations_for(const Problem& problem) {
    constexpr double RATIO = 1.2, LEAST = 0.5;
    if (problem.foundation_n_per_m3.size() == 0 || !(problem.foundation_n_per_m3 > 0.0).any()) return {};
    const ArrayXXd ratio = problem.foundation_n_per_m3 / problem.rigidity_n_m;
    const double shorter_m = problem.size_m.minCoeff();
    const auto most =
        static_cast<double>(std::min(ratio.rows(), ratio.cols()));  // l no shorter than the spacing
    const auto clamped = [&](double s) { return std::clamp(s, LEAST, most); };
    const double positive = (ratio > 0.0).select(ratio, ratio.maxCoeff()).minCoeff();
    return {.first = clamped(shorter_m * std::sqrt(std::sqrt(positive)) / RATIO),
            .last = clamped(shorter_m * std::sqrt(std::sqrt(ratio.maxCoeff()))),
            .ratio = RATIO};
}

std::optional<Bracket> continuum_bracket(const Problem& problem, std::span<const double> force_n,
                                         const UniformCompliance& exact, const Climb& climb,
                                         std::string* why) {
    if (const auto words = ContinuumBounds::none_because(problem)) {
        if (why != nullptr) *why = *words;
        return std::nullopt;
    }
    const ContinuumBounds bounds(problem, force_n, exact, foundations_for(problem));
    ContinuumBounds::Scratch scratch(bounds);
    return bounds.bracket(span_of(problem.rigidity_n_m), span_of(problem.foundation_n_per_m3), climb, scratch,
                          why);
}

}  // namespace palpate::plate
