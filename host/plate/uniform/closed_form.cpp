#include "host/plate/uniform/closed_form.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "host/plate/uniform/green.hpp"

namespace palpate::plate {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using std::numbers::pi;
using Rectangle = UniformSolution::Plate;
using Mode = UniformSolution::Mode;
using Load = UniformSolution::Load;

// No foundation is one too weak to matter: 1e-16 of the plate's own stiffness. Imaginary parts keep their
// relative accuracy however small epsilon is.
constexpr double EPSILON_MIN = 1e-8;
constexpr int HALF_WAVES_FIRST = 50, HALF_WAVES_MAX = 800;  // per short side
constexpr double ENOUGH = 1e-11;                            // relative change at which doubling ends
constexpr double SUM_ROUNDING = 1e-15;                      // of the supported plate's compliance, absolute
constexpr double LENGTH = 10.0;            // of a plate to either side of the load, in short sides
constexpr double RADIUS_OVER_L_MAX = 6.0;  // the disc's power series lose digits beyond

/// Power series in y = i epsilon rho^2/4 = (lambda rho/2)^2, lambda^2 = i epsilon, H_k the harmonic numbers.
struct DiscSeries {
    Complex i0 = 0.0;           ///< I0(lambda rho): sum y^k/k!^2
    Complex i0_harmonic = 0.0;  ///< sum H_k y^k/k!^2
    Complex i1 = 0.0;           ///< 2 I1(lambda rho)/(lambda rho): sum y^k/(k! (k+1)!)
    Complex i1_harmonic = 0.0;  ///< sum (H_k + H_(k+1)) y^k/(k! (k+1)!)
    Complex i1_rest = 0.0;      ///< (i1 - 1)/y
    Complex i0_rest = 0.0;      ///< (i0 - 1)/y

    DiscSeries(double epsilon, double rho) {
        const Complex y(0.0, 0.25 * epsilon * rho * rho);
        Complex term = 1.0;  // y^k/k!^2
        double harmonic = 0.0;
        for (int k = 0; k < 60; ++k) {
            const double next = k + 1.0;
            i0 += term;
            i0_harmonic += harmonic * term;
            i1 += term / next;
            i1_harmonic += (2.0 * harmonic + 1.0 / next) * term / next;
            i0_rest += term / (next * next);
            i1_rest += term / (next * next * (next + 1.0));
            harmonic += 1.0 / next;
            term *= y / (next * next);
        }
    }
};

/// Mean over the disc of the singular part of Green's function, -[ln(rho/r) I0 - sum H_k y^k/k!^2]/(2 pi), at
/// `rho` from the disc's centre, rho <= r.
Complex disc_potential(double epsilon, double radius, double rho) {
    const DiscSeries disc(epsilon, radius), here(epsilon, rho);
    const double share = rho * rho / (radius * radius);
    return (disc.i1_harmonic * here.i0 - share * here.i0_rest) / (4.0 * pi);
}

/// The mean of that over the disc.
Complex disc_self(double epsilon, double radius) {
    const DiscSeries disc(epsilon, radius);
    return (disc.i1 * disc.i1_harmonic - disc.i1_rest) / (4.0 * pi);
}

/// Green's function less its singular part around b, a within the radius of b.
Complex regular_part(const Rectangle& plate, const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                     double radius) {
    const double rho = (a - b).norm();
    const DiscSeries here(plate.epsilon, rho);
    const double log_rho = rho > 0.0 ? std::log(rho) : 0.0;  // times i0 - 1
    const Complex singular = log_rho * (here.i0 - 1.0) - std::log(radius) * here.i0 - here.i0_harmonic;
    return green_without_log(plate.size, plate.epsilon, a, b) + singular / (2.0 * pi);
}

/// The supported plate's deflection at `at`.
double supported(const Rectangle& plate, const Load& load, const Eigen::Vector2d& at) {
    Complex green;
    if ((at - load.at).norm() < load.radius) {
        green = load.spread * regular_part(plate, at, load.at, load.radius) +
                disc_potential(plate.epsilon, load.radius, (at - load.at).norm());
    } else {
        green = green_without_log(plate.size, plate.epsilon, at, load.at);
        if (load.radius > 0.0) green = load.spread * (green - std::log((at - load.at).norm()) / (2.0 * pi));
    }
    return -green.imag() / plate.epsilon;
}

/// Its deflection at the load, mean over the disc.
double supported_at_load(const Rectangle& plate, const Load& load) {
    if (!(load.radius > 0.0)) return supported(plate, load, load.at);
    const Complex green = load.spread * load.spread * regular_part(plate, load.at, load.at, load.radius) +
                          disc_self(plate.epsilon, load.radius);
    return -green.imag() / plate.epsilon;
}

double wave_of(const Rectangle& plate, const Mode& mode) {
    return mode.half_waves * pi / plate.size[1 - mode.axis];
}

/// Deflection at `at` (its mean over a disc there, with the disc's `spread`) from a moment of amplitude 1.
double deflection(const Rectangle& plate, const Mode& mode, const Eigen::Vector2d& at, Complex spread) {
    const double wave = wave_of(plate, mode);
    const Complex mu = std::sqrt(Complex(wave * wave, plate.epsilon));
    const double height = plate.size[mode.axis], z = at[mode.axis];
    const auto decay = [&](double d) { return std::exp(-mu * d) - std::exp(-mu * (2.0 * height - d)); };
    const Complex shape =
        (mode.low * decay(z) + mode.high * decay(height - z)) / (1.0 - std::exp(-2.0 * mu * height));
    return -(spread * shape).imag() * std::sin(wave * at[1 - mode.axis]) / plate.epsilon;
}

/// Work of a mode's moments on its own slopes.
double own(const Rectangle& plate, const Mode& mode) {
    const double wave = wave_of(plate, mode);
    const Complex mu = std::sqrt(Complex(wave * wave, plate.epsilon));
    const Complex once = std::exp(-mu * plate.size[mode.axis]);
    const Complex slope = mu *
                          ((mode.low * mode.low + mode.high * mode.high) * (1.0 + once * once) -
                           4.0 * mode.low * mode.high * once) /
                          (1.0 - once * once);
    return 0.5 * plate.size[1 - mode.axis] * slope.imag() / plate.epsilon;
}

/// Work of a mode's moments on the slopes that a mode across the other axis makes.
double mutual(const Rectangle& plate, const Mode& a, const Mode& b) {
    const auto ends = [](const Mode& edges, int half_waves) {
        return half_waves % 2 == 0 ? edges.low - edges.high : edges.low + edges.high;
    };
    const double alpha = wave_of(plate, a), beta = wave_of(plate, b);
    const double sum = alpha * alpha + beta * beta;
    return alpha * beta / (sum * sum + plate.epsilon * plate.epsilon) * ends(a, b.half_waves) *
           ends(b, a.half_waves);
}

/// Whether the two edges across `axis` are held alike; then even and odd deflections do not mix.
bool alike(const Rectangle& plate, Index axis) {
    const auto k = static_cast<std::size_t>(2 * axis);
    return plate.edges[k] == plate.edges[k + 1];
}

/// Modes of the clamped edges across `axis`, up to `half_waves` per short side, whose deflections are even
/// (0) or odd (1) along x and z as `parity` says; where the edges are not alike all belong to 0.
std::vector<Mode> modes_across(const Rectangle& plate, Index axis, int half_waves,
                               const std::array<int, 2>& parity) {
    const auto k = static_cast<std::size_t>(2 * axis);
    const bool low = plate.edges[k] == Edge::clamped, high = plate.edges[k + 1] == Edge::clamped;
    std::vector<Mode> modes;
    if (!low && !high) return modes;
    const int across = parity[static_cast<std::size_t>(axis)],
              along = parity[static_cast<std::size_t>(1 - axis)];
    const double high_weight = across == 0 ? 1.0 : -1.0;
    const int last = static_cast<int>(half_waves * plate.size[1 - axis]);
    const bool halved = alike(plate, 1 - axis);
    for (int m = halved ? 1 + along : 1; m <= last; m += halved ? 2 : 1) {
        modes.push_back({axis, m, low ? 1.0 : 0.0, high ? high_weight : 0.0});
    }
    return modes;
}

/// The edge moments under a load and the deflection that they take off at it.
struct Moments {
    std::vector<Mode> modes;
    std::vector<double> moments;
    double relief = 0.0;
};

Eigen::VectorXd deflections(const Rectangle& plate, const std::vector<Mode>& modes, const Load& load) {
    Eigen::VectorXd w(static_cast<Index>(modes.size()));
    for (Index i = 0; i < w.size(); ++i)
        w(i) = deflection(plate, modes[static_cast<std::size_t>(i)], load.at, load.spread);
    return w;
}

Eigen::VectorXd own_works(const Rectangle& plate, const std::vector<Mode>& modes) {
    Eigen::VectorXd works(static_cast<Index>(modes.size()));
    for (Index i = 0; i < works.size(); ++i) works(i) = own(plate, modes[static_cast<std::size_t>(i)]);
    return works;
}

void add(Moments& all, const std::vector<Mode>& modes, const Eigen::VectorXd& moments,
         const Eigen::VectorXd& deflections_at_load) {
    all.modes.insert(all.modes.end(), modes.begin(), modes.end());
    all.moments.insert(all.moments.end(), moments.begin(), moments.end());
    all.relief += moments.dot(deflections_at_load);
}

/// One parity: the slope of the load plus that of all moments is 0 on every edge (MATH.md eq. 36). The
/// matrix is diagonal within an axis; the longer list is eliminated.
void solve_parity(Moments& all, const Rectangle& plate, const Load& load, int half_waves,
                  const std::array<int, 2>& parity) {
    std::vector<Mode> many = modes_across(plate, 0, half_waves, parity);
    std::vector<Mode> few = modes_across(plate, 1, half_waves, parity);
    if (many.size() < few.size()) many.swap(few);
    const Eigen::VectorXd w_many = deflections(plate, many, load), w_few = deflections(plate, few, load);
    const Eigen::VectorXd d_many = own_works(plate, many);
    if (few.empty()) return add(all, many, w_many.cwiseQuotient(d_many), w_many);

    Eigen::MatrixXd coupling(w_few.size(), w_many.size());
    for (Index j = 0; j < w_many.size(); ++j) {
        for (Index i = 0; i < w_few.size(); ++i) {
            coupling(i, j) =
                mutual(plate, few[static_cast<std::size_t>(i)], many[static_cast<std::size_t>(j)]);
        }
    }
    Eigen::MatrixXd matrix = own_works(plate, few).asDiagonal();
    const Eigen::MatrixXd weighted = coupling * d_many.cwiseSqrt().cwiseInverse().asDiagonal();
    matrix.selfadjointView<Eigen::Lower>().rankUpdate(weighted, -1.0);
    const Eigen::VectorXd few_moments = matrix.llt().solve(w_few - coupling * w_many.cwiseQuotient(d_many));
    const Eigen::VectorXd many_moments = (w_many - coupling.transpose() * few_moments).cwiseQuotient(d_many);
    add(all, few, few_moments, w_few);
    add(all, many, many_moments, w_many);
}

Moments edge_moments(const Rectangle& plate, const Load& load, int half_waves) {
    Moments all;
    for (int x = 0; x < (alike(plate, 0) ? 2 : 1); ++x) {
        for (int z = 0; z < (alike(plate, 1) ? 2 : 1); ++z) {
            solve_parity(all, plate, load, half_waves, {x, z});
        }
    }
    return all;
}

/// What doubling the waves once more would change at most, twice the geometric guess; all of `held` where the
/// changes do not fall yet.
double next_change(double before, double change, double held) {
    return 2.0 * change < before ? 2.0 * change * change / before : held;
}

void require(bool holds, const char* words) {
    if (!holds) throw std::invalid_argument(words);
}

bool has_free_edge(const UniformPlate& plate) {
    return std::count(plate.edges.begin(), plate.edges.end(), Edge::free) > 0;
}

void require_usable(const UniformPlate& plate, const UniformLoad& load) {
    require(!has_free_edge(plate), "a free edge has no closed form");
    require(plate.size_m.allFinite() && plate.size_m.minCoeff() > 0.0, "sides must be positive");
    require(plate.rigidity_n_m > 0.0 && std::isfinite(plate.rigidity_n_m), "rigidity must be positive");
    require(plate.foundation_n_per_m3 >= 0.0 && std::isfinite(plate.foundation_n_per_m3),
            "foundation must not be negative");
    require(load.radius_m >= 0.0 &&
                load.radius_m <= disc_radius_max_m(plate.rigidity_n_m, plate.foundation_n_per_m3),
            "the disc's radius must be between 0 and 6 l");
    const double reach_m = std::min(load.at_m.minCoeff(), (plate.size_m - load.at_m).minCoeff());
    require(load.at_m.allFinite() && reach_m > 0.0 && reach_m >= load.radius_m,
            "the load must lie inside the plate");
}

/// The part of a long plate that a load is felt in, from `corner_m`. Beyond LENGTH short sides what an edge
/// there does comes back exp(-2 pi LENGTH) times smaller, so that it may as well be supported.
UniformPlate felt(UniformPlate plate, const UniformLoad& load, Eigen::Vector2d& corner_m) {
    const double reach_m = LENGTH * plate.size_m.minCoeff();
    for (Index axis = 0; axis < 2; ++axis) {
        const auto low = static_cast<std::size_t>(2 * axis);
        const double from_m = load.at_m[axis] - load.radius_m - reach_m;
        const double to_m = load.at_m[axis] + load.radius_m + reach_m;
        if (to_m < plate.size_m[axis]) {
            plate.size_m[axis] = to_m;
            plate.edges[low + 1] = Edge::supported;
        }
        if (from_m > 0.0) {
            corner_m[axis] = from_m;
            plate.size_m[axis] -= from_m;
            plate.edges[low] = Edge::supported;
        }
    }
    return plate;
}

}  // namespace

UniformSolution::UniformSolution(const UniformPlate& whole, const UniformLoad& load) {
    require_usable(whole, load);
    const UniformPlate plate = felt(whole, load, corner_m_);
    unit_m_ = plate.size_m.minCoeff();
    scale_m_per_n_ = unit_m_ * unit_m_ / plate.rigidity_n_m;
    const double foundation_1 = plate.foundation_n_per_m3 / plate.rigidity_n_m;
    plate_ = {plate.size_m / unit_m_, std::max(std::sqrt(foundation_1) * unit_m_ * unit_m_, EPSILON_MIN),
              plate.edges};
    load_ = {(load.at_m - corner_m_) / unit_m_, load.radius_m / unit_m_, 1.0};
    load_.spread = DiscSeries(plate_.epsilon, load_.radius).i1;

    const double held = supported_at_load(plate_, load_);
    Moments moments = edge_moments(plate_, load_, HALF_WAVES_FIRST);
    double change = held, error = held;
    for (int half_waves = 2 * HALF_WAVES_FIRST; half_waves <= HALF_WAVES_MAX; half_waves *= 2) {
        Moments finer = edge_moments(plate_, load_, half_waves);
        const double before = change;
        change = std::fabs(finer.relief - moments.relief);
        error = next_change(before, change, held);
        moments = std::move(finer);
        if (change <= ENOUGH * (held - moments.relief)) break;
    }
    modes_ = std::move(moments.modes);
    moments_ =
        Eigen::Map<const Eigen::VectorXd>(moments.moments.data(), static_cast<Index>(moments.moments.size()));
    const double left = held - moments.relief;
    require(left > 0.0, "the load lies so close to an edge that the series leave no digit");
    const double blurred =
        GREEN_REAL_ERROR * std::fabs((load_.spread * load_.spread).imag()) / plate_.epsilon;
    compliance_ = {left * scale_m_per_n_, (error + SUM_ROUNDING + blurred) / left};
}

ClosedForm UniformSolution::compliance() const {
    return compliance_;
}

double UniformSolution::deflection_m_per_n(const Eigen::Vector2d& at_m) const {
    const Eigen::Vector2d at = (at_m - corner_m_) / unit_m_;
    if ((at.array() < 0.0).any() || (at.array() > plate_.size.array()).any()) return 0.0;  // LENGTH away
    double w = supported(plate_, load_, at);
    for (std::size_t i = 0; i < modes_.size(); ++i) {
        w -= moments_(static_cast<Index>(i)) * deflection(plate_, modes_[i], at, 1.0);
    }
    return w * scale_m_per_n_;
}

double disc_radius_max_m(double rigidity_n_m, double foundation_n_per_m3) {
    return RADIUS_OVER_L_MAX * std::pow(rigidity_n_m / foundation_n_per_m3, 0.25);
}

}  // namespace palpate::plate
